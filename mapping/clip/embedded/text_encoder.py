"""The embedded CLIP's texts, embedded without PyTorch, which takes a second to load.

A saved map is asked with it. A run embeds its texts by `towers`: cosines of the two differ by less
than 1e-6, but not every bit of them is the same.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import safetensors.numpy
from numpy.typing import NDArray
from tokenizers import Tokenizer

from mapping.clip.embedded.model_files import EmbeddedFiles, damaged_files
from mapping.clip.embedded.word_table import read_goal
from mapping.clip.reading import Reading

NOTICE = "rehearsal model, trained on simulated homes"
DIMENSION = 256
"""Length of an embedding."""
LONGEST_TEXT = 24
"""Tokens of a text; what is beyond is cut off."""
HEADS = 4
"""Heads of the text tower's attention."""

_LN_EPSILON = 1e-5


class EmbeddedTexts:
    """A `TextEncoder` of the embedded model."""

    dimension = DIMENSION
    notice: str | None = NOTICE

    def __init__(self, files: EmbeddedFiles) -> None:
        """Take the text tower out of the weights.

        Raises:
            ConfigError: they are damaged.
        """
        self.model_id, self.threshold = files.model_id, files.threshold
        self._tokenizer, self._words = files.tokenizer, files.words
        try:
            tensors = safetensors.numpy.load(files.weights)
            prefix = "text_tower."
            self._tower = {
                name.removeprefix(prefix): tensor.astype(np.float32)
                for name, tensor in tensors.items()
                if name.startswith(prefix)
            }
            scale, bias = (tensors[name].astype(np.float32) for name in ("log_scale", "bias"))
            self.log_odds: tuple[float, float] | None = (math.exp(scale), float(bias))
            self.embed_texts(["a sofa"])
        except Exception as error:  # the library raises whatever a damaged file leads it into
            raise damaged_files(files.folder) from error

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embeddings (N, 256), unit rows; a text beyond 24 tokens is cut off there."""
        return text_embeddings(self._tower, token_ids(self._tokenizer, texts))

    def reading(self, text: str) -> Reading:
        """The text with nouns that were not trained looked up in a table of words."""
        return read_goal(text, self._words)


def token_ids(tokenizer: Tokenizer, texts: Sequence[str]) -> NDArray[np.int64]:
    """Token ids (N, L) of texts, 0 behind the end of each."""
    encoded = [item.ids[:LONGEST_TEXT] for item in tokenizer.encode_batch(list(texts))]
    longest = max(map(len, encoded), default=0)
    ids = np.zeros((len(encoded), max(longest, 1)), np.int64)
    for row, tokens in zip(ids, encoded, strict=True):
        row[: len(tokens)] = tokens
    return ids


def text_embeddings(
    tower: Mapping[str, NDArray[np.float32]], ids: NDArray[np.int64]
) -> NDArray[np.float32]:
    """Unit embeddings (N, 256) of token ids (N, L), as `towers.TextTower` has them.

    Args:
        tower: The parameters of that tower by their names.
        ids: 0 where there is no token.
    """
    there = ids != 0
    x = tower["tokens.weight"][ids] + tower["positions"][: ids.shape[1]]
    layer = 0
    while (name := f"transformer.layers.{layer}.") + "norm1.weight" in tower:
        x = x + _attention(
            tower, f"{name}self_attn.", _normalised(tower, f"{name}norm1.", x), there
        )
        inner = _linear(tower, f"{name}linear1.", _normalised(tower, f"{name}norm2.", x))
        x = x + _linear(tower, f"{name}linear2.", np.maximum(inner, 0.0))
        layer += 1
    count = there.sum(axis=1, keepdims=True).clip(min=1).astype(np.float32)
    mean = (x * there[..., None]).sum(axis=1) / count
    projected = mean @ tower["projection.weight"].T
    length = np.linalg.norm(projected, axis=1, keepdims=True)
    return np.asarray(projected / np.maximum(length, 1e-12), np.float32)


def _attention(
    tower: Mapping[str, NDArray[np.float32]],
    name: str,
    x: NDArray[np.float32],
    there: NDArray[np.bool_],
) -> NDArray[np.float32]:
    """Self-attention of tokens (N, L, 256) to those that are `there` (N, L)."""
    count, length, _ = x.shape
    joint = x @ tower[f"{name}in_proj_weight"].T + tower[f"{name}in_proj_bias"]
    split = joint.reshape(count, length, 3, HEADS, DIMENSION // HEADS)
    query, key, value = split.transpose(2, 0, 3, 1, 4)
    scores = query @ key.swapaxes(-1, -2) / np.sqrt(np.float32(DIMENSION // HEADS))
    scores = np.where(there[:, None, None], scores, -np.inf)
    weights = np.exp(scores - scores.max(axis=-1, keepdims=True))
    weights /= weights.sum(axis=-1, keepdims=True)
    heads = (weights @ value).transpose(0, 2, 1, 3).reshape(x.shape)
    return _linear(tower, f"{name}out_proj.", heads)


def _normalised(
    tower: Mapping[str, NDArray[np.float32]], name: str, x: NDArray[np.float32]
) -> NDArray[np.float32]:
    centred = x - x.mean(axis=-1, keepdims=True)
    variance = np.square(centred).mean(axis=-1, keepdims=True)
    scaled = centred / np.sqrt(variance + np.float32(_LN_EPSILON))
    return np.asarray(scaled * tower[f"{name}weight"] + tower[f"{name}bias"])


def _linear(
    tower: Mapping[str, NDArray[np.float32]], name: str, x: NDArray[np.float32]
) -> NDArray[np.float32]:
    return np.asarray(x @ tower[f"{name}weight"].T + tower[f"{name}bias"])
