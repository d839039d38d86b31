"""Faults of the program: it is killed, its disk is full, its encoder is out of memory."""

from __future__ import annotations

import errno
import os
import resource
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.fitted.encoder import calibration_of
from mapping.clip.reading import Reading
from sim_stubs.faults.catalogue import FaultSchedule
from vizbot.core.errors import DeviceError
from vizbot.core.observer import GoalReport, Observer, Step

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder


class FaultyObserver:
    """An `Observer` that writes to a disk that may be full."""

    def __init__(self, observer: Observer, schedule: FaultSchedule) -> None:
        """Wrap an observer."""
        self._observer = observer
        self._schedule = schedule

    def on_step(self, step: Step) -> None:
        """Report to the observer.

        Raises:
            OSError: the disk is full.
        """
        self._require_space()
        self._observer.on_step(step)

    def on_goal(self, report: GoalReport) -> None:
        """Report to the observer.

        Raises:
            OSError: the disk is full.
        """
        self._require_space()
        self._observer.on_goal(report)

    def _require_space(self) -> None:
        if self._schedule.active("disk-full"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@contextmanager
def full_disk(most: int = 0) -> Iterator[None]:
    """Let every write beyond so many bytes of a file fail in the `with` block."""
    limit = resource.RLIMIT_FSIZE
    soft, hard = resource.getrlimit(limit)
    resource.setrlimit(limit, (most, hard))
    try:
        yield
    finally:
        resource.setrlimit(limit, (soft, hard))


class Killer:
    """An observer that kills its own program when that fault is due."""

    def __init__(self, schedule: FaultSchedule) -> None:
        """Kill the program at the time of the schedule."""
        self._schedule = schedule

    def on_step(self, step: Step) -> None:
        """Kill the program if that is due."""
        if self._schedule.began("process-killed") is not None:
            os.kill(os.getpid(), signal.SIGKILL)

    def on_goal(self, report: GoalReport) -> None:
        """Do nothing."""


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
        self.calibration = calibration_of(encoder)
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
