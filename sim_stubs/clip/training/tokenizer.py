"""Subword tokens for the embedded CLIP: byte-pair encoding (Sennrich et al. 2016)."""

from __future__ import annotations

from collections.abc import Iterator
from string import ascii_lowercase, digits

import numpy as np
from tokenizers import Tokenizer, models, normalizers, pre_tokenizers, trainers

from sim_stubs.clip.training.captions.captions import draw_captions, draw_negatives
from sim_stubs.clip.training.captions.facts import Facts

VOCABULARY = 2000
"""Tokens; frequent words are one, all others are put together from pieces."""
DRAWS = 40_000
"""Captions that the pieces are learned from."""


def train_tokenizer(atoms: Facts, seed: int) -> Tokenizer:
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
    tokenizer.train_from_iterator(_texts(atoms, seed), trainer)
    return tokenizer


def _texts(atoms: Facts, seed: int) -> Iterator[str]:
    rng = np.random.default_rng((seed, 13))
    for patch in rng.integers(len(atoms), size=DRAWS):
        yield from (caption.text for caption in draw_captions(atoms, int(patch), rng, 1))
    yield from (caption.text for caption in draw_negatives(rng, DRAWS // 4))
