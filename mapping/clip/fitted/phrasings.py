"""Phrasings: the sentences that together stand for a goal in an encoder's space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import TextEncoder

BARE = ("{}",)
"""The words of the goal alone."""
ENSEMBLE = ("{}", "a photo of a {}", "a {} in a room")
"""What is taken in place of bare words where an encoder tells things better apart by it."""
_ARTICLES = ("a ", "an ", "the ")


def embed_phrased(
    encoder: TextEncoder, texts: Sequence[str], phrasings: Sequence[str]
) -> NDArray[np.float32]:
    """Embeddings (N, D), unit rows, of texts, each the mean of its phrasings.

    Args:
        encoder: Embeds them.
        texts: What is looked for; with an article the phrasing's own one is left out.
        phrasings: Sentences with `{}` where the text comes.
    """
    several = [
        encoder.embed_texts([_phrased(text, phrasing) for text in texts]) for phrasing in phrasings
    ]
    if len(several) == 1:
        return several[0]
    mean = np.mean(several, axis=0)
    return np.asarray(mean / np.maximum(np.linalg.norm(mean, axis=1)[:, None], 1e-9), np.float32)


def _phrased(text: str, phrasing: str) -> str:
    if text.lower().startswith(_ARTICLES):
        phrasing = phrasing.replace("a {}", "{}")
    return phrasing.replace("{}", text)
