"""An encoder whose device runs out of memory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.reading import Reading
from sim_stubs.faults.catalogue import FaultSchedule
from vizbot.core.errors import DeviceError

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder


class FaultyEncoder:
    """A `ClipEncoder` with faults."""

    def __init__(self, encoder: ClipEncoder, schedule: FaultSchedule) -> None:
        """Wrap an encoder."""
        self._encoder = encoder
        self._schedule = schedule
        self.model_id = encoder.model_id
        self.dimension = encoder.dimension
        self.threshold = encoder.threshold
        self.log_odds = encoder.log_odds
        self.notice = encoder.notice

    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Embed images.

        Raises:
            DeviceError: out of memory.
        """
        if self._schedule.active("encoder-out-of-memory"):
            raise DeviceError(f"{self.model_id}: out of memory for {len(images)} images")
        return self._encoder.embed_images(images)

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embed texts."""
        return self._encoder.embed_texts(texts)

    def reading(self, text: str) -> Reading:
        """Read a text."""
        return self._encoder.reading(text)
