"""An encoder as a weaker one would be: half of what it says of a picture is noise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder
    from mapping.clip.reading import Reading


class WeakEncoder:
    """A `ClipEncoder` whose pictures are embedded with as much noise as there is to them.

    It has scale and bias of the own one, which are too large for it: what a user's encoder says of
    itself is seldom right in a home. The same picture always gets the same noise.

    Attributes:
        model_id: Of the own one, marked as weak.
        dimension: Length of the embeddings.
        threshold: Of the own one.
        log_odds: Of the own one.
        notice: Of the own one.
    """

    def __init__(self, own: ClipEncoder) -> None:
        """Wrap an encoder."""
        self._own = own
        self.model_id, self.dimension = f"{own.model_id}-weak", own.dimension
        self.threshold, self.log_odds, self.notice = own.threshold, own.log_odds, own.notice

    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows, of pictures."""
        return self.embeddings_of_pictures(self._own.embed_images(images))

    def embeddings_of_pictures(self, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Embeddings (N, D) of the pictures that the own encoder embeds as these rows."""
        noise = np.zeros(rows.shape)
        for row, out in zip(rows, noise, strict=True):
            out[:] = np.random.default_rng(crc32(row.tobytes())).normal(size=self.dimension)
        mixed = rows + noise / np.sqrt(self.dimension)
        return np.asarray(mixed / np.linalg.norm(mixed, axis=1, keepdims=True), np.float32)

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows, of texts: those of the own one."""
        return self._own.embed_texts(texts)

    def reading(self, text: str) -> Reading:
        """How the own one takes a text."""
        return self._own.reading(text)
