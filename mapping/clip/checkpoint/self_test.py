"""Whether weights that were loaded from a disk do what an encoder is for.

What is missing or spoilt beside the weights may leave a model that computes, and tells nothing from
anything else: without a vocabulary every text is the same one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

_TEXTS = ("a chair", "kitchen", "something red", "sofa")
_SAME = 0.999
"""Least cosine between two embeddings of one thing, alone and in a batch."""
_APART = 1e-5
"""Least difference, in any number of a row, of two things that are not the same."""
_UNIT = 1e-3
"""Greatest difference of a length from 1."""


def fault_in_use(encoder: ClipEncoder) -> str | None:
    """What is wrong with an encoder, in words that go on from its name; None for nothing.

    It embeds four texts and two pictures together, and each of them alone.
    """
    texts, pictures = list(_TEXTS), _pictures()
    alone = np.concatenate([encoder.embed_texts([each]) for each in texts])
    if (fault := _fault("texts", encoder.embed_texts(texts), alone)) is not None:
        return fault
    alone = np.concatenate([encoder.embed_images([each]) for each in pictures])
    return _fault("pictures", encoder.embed_images(pictures), alone)


def _fault(of: str, rows: NDArray[np.float32], alone: NDArray[np.float32]) -> str | None:
    if not (np.abs(np.linalg.norm(rows, axis=1) - 1.0) < _UNIT).all():  # nor is NaN
        return f"embeds {of} as what is no direction: its weights are damaged"
    apart = np.abs(rows[:, None] - rows[None]).max(axis=-1) + np.eye(len(rows))
    if not (apart > _APART).all():
        because = "its tokenizer knows no words" if of == "texts" else "its weights are damaged"
        return f"embeds different {of} as the same: {because}"
    nearest = np.linalg.norm(rows[:, None] - alone[None], axis=-1).argmin(axis=1)
    alike = (rows * alone).sum(axis=-1) >= _SAME
    if (nearest != np.arange(len(rows))).any() or not alike.all():
        return f"embeds {of} otherwise alone than among others, or in another order"
    return None


def _pictures() -> list[NDArray[np.uint8]]:
    """A plain one, and one of noise, of other sizes."""
    noise = np.random.default_rng(0).integers(0, 256, (96, 128, 3), np.uint8)
    return [np.full((112, 112, 3), (200, 30, 30), np.uint8), noise]
