"""Subword tokens for the embedded CLIP: byte-pair encoding (Sennrich et al. 2016)."""

from __future__ import annotations

from collections.abc import Iterator
from string import ascii_lowercase, digits

import numpy as np
from tokenizers import Tokenizer, models, normalizers, pre_tokenizers, trainers

from training.captions.captions import draw_captions, draw_negatives
from training.captions.facts import Facts

VOCABULARY = 2000
"""Number of tokens; frequent words are one token, others several."""
DRAWS = 40_000
"""Number of captions that the tokens are learned from."""


def train_tokenizer(facts: Facts, seed: int) -> Tokenizer:
    """A tokenizer for captions of patches; its token 0 stands behind the end of a text."""
    tokenizer = Tokenizer(models.BPE(unk_token="<unknown>", end_of_word_suffix="</w>"))
    tokenizer.normalizer = normalizers.Sequence([normalizers.NFKD(), normalizers.Lowercase()])
    tokenizer.pre_tokenizer = pre_tokenizers.Whitespace()
    trainer = trainers.BpeTrainer(
        vocab_size=VOCABULARY,
        special_tokens=["<end>", "<unknown>"],
        initial_alphabet=list(ascii_lowercase + digits + "'-,.?"),
        end_of_word_suffix="</w>",
        show_progress=False,
    )
    tokenizer.train_from_iterator(_texts(facts, seed), trainer)
    return tokenizer


def _texts(facts: Facts, seed: int) -> Iterator[str]:
    rng = np.random.default_rng((seed, 13))
    for patch in rng.integers(len(facts), size=DRAWS):
        yield from (caption.text for caption in draw_captions(facts, int(patch), rng, 1))
    yield from (caption.text for caption in draw_negatives(rng, DRAWS // 4))
