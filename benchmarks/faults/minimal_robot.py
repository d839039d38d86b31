"""Cheap stand-ins for the parts of a robot that a fault drive does not test."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapping import map_bundle
from mapping.clip.reading import Reading
from mapping.odometry.features import Features
from sim_stubs.faults.catalogue import FaultSchedule
from sim_stubs.faults.faulty_program import full_disk
from vizbot.core.errors import MapError
from vizbot.core.observer import GoalReport, Step
from vizbot.core.types import SE3, PoseEstimate, RGBDFrame, Tracking
from vizbot.pipeline import Pipeline

ENDED_BY = {"process-killed": "killed", "hangs-docking": "the program hangs"}
"""Faults that end the program, and what is kept as the reason."""


class WheelPoses:
    """A pose estimator that takes the poses of the wheels; the first frame is its only keyframe."""

    def __init__(self, T_base_cam: SE3) -> None:
        self._T_base_cam = T_base_cam
        self._T_map_cam: SE3 | None = None
        self._T_map_keyframe: SE3 = T_base_cam

    def track(self, frame: RGBDFrame, T_odom_base: SE3 | None) -> PoseEstimate:
        """The pose by the wheels."""
        first = self._T_map_cam is None
        if T_odom_base is not None:
            self._T_map_cam = T_odom_base @ self._T_base_cam
        if first:
            self._T_map_keyframe = self._here()
        return self._estimate(frame.stamp, first, Tracking.TRACKING)

    def lift(self, stamp: float) -> PoseEstimate:
        """The last pose: a lifted robot has no odometry."""
        return self._estimate(stamp, False, Tracking.WHEELS_ONLY)

    def keyframe_poses(self) -> dict[int, SE3]:
        """The only keyframe."""
        return {0: self._T_map_keyframe}

    @property
    def closures(self) -> list[tuple[int, int]]:
        """No loop closures."""
        return []

    def features(self) -> dict[int, Features]:
        """None: this estimator recognises no place."""
        return {}

    def _here(self) -> SE3:
        return self._T_base_cam if self._T_map_cam is None else self._T_map_cam

    def _estimate(self, stamp: float, is_keyframe: bool, tracking: Tracking) -> PoseEstimate:
        T_keyframe_cam = np.linalg.inv(self._T_map_keyframe) @ self._here()
        return PoseEstimate(stamp, self._here(), 0, T_keyframe_cam, is_keyframe, tracking)


class GreyEncoder:
    """A `ClipEncoder` for which all images are equal and no text matches them."""

    model_id = "grey"
    dimension = 2
    threshold = 1.0
    log_odds: tuple[float, float] | None = None
    notice: str | None = None

    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Embeddings (N, 2)."""
        return np.tile(np.array([1.0, 0.0], np.float32), (len(images), 1))

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embeddings (N, 2), at right angles to those of images."""
        return np.tile(np.array([0.0, 1.0], np.float32), (len(texts), 1))

    def reading(self, text: str) -> Reading:
        """The text as it is."""
        return Reading(text)


@dataclass
class LogObserver:
    """An observer that logs the robot's messages.

    Attributes:
        schedule: Schedule of the faults, among them the kill of the program.
        now: Returns the time of the run [s].
        ended_by: The fault that has ended the program; None while it runs.
        lines: Time [s] and text of all messages to the user.
        steps: Number of steps so far.
    """

    schedule: FaultSchedule
    now: Callable[[], float]
    ended_by: str | None = None
    lines: list[tuple[float, str]] = field(default_factory=list)
    steps: int = 0

    def on_step(self, step: Step) -> None:
        """Log the activity of a step without a path, and note whether the program ends here."""
        self.steps += 1
        for fault in ENDED_BY:
            if self.ended_by is None and self.schedule.began(fault) is not None:
                self.ended_by = fault
        said = step.activity if step.ended is None else step.ended[1]
        if step.path is None and (not self.lines or self.lines[-1][1] != said):
            self.lines.append((self.now(), said))

    def on_goal(self, report: GoalReport) -> None:
        """Do nothing: a fault drive has no goals."""


def map_survives(pipeline: Pipeline, observer: LogObserver) -> bool | None:
    """Whether the map can be saved and loaded, with every step; None for a killed program.

    A full disk must damage neither the saved map nor the one in memory, and must raise an error.
    """
    if observer.ended_by is not None:
        return None
    with tempfile.TemporaryDirectory() as folder, suppress(MapError):
        path = Path(folder) / "map"
        if not _saved(pipeline, path):
            return False
        if observer.schedule.active("disk-full"):
            try:
                with full_disk():
                    _saved(pipeline, path)
                return False  # the failed save went unnoticed
            except MapError:
                map_bundle.load(path)
            if not _saved(pipeline, path):
                return False
        loaded = map_bundle.load(path)
        return len(loaded.keyframes.ids) > 0 and len(loaded.trajectory.stamps) >= observer.steps
    return False


def _saved(pipeline: Pipeline, path: Path) -> bool:
    """Save the map, if there is one; return whether there is.

    Raises:
        MapError: the disk is full.
    """
    bundle = pipeline.bundle()
    if bundle is not None:
        map_bundle.save(bundle, path)
    return bundle is not None
