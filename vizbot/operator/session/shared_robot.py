"""The robot that people share: what a session needs of its base and of its run."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import Candidate, GoalReport
from vizbot.core.types import BaseState, Feedback
from vizbot.operator.session.drive_lease import DriveLease


class SharedRobot(Protocol):
    """What an `OperatorSession` needs of its robot; called by any thread, and never waits."""

    @property
    def lease(self) -> DriveLease:
        """Who drives it by hand."""
        ...

    @property
    def stopped(self) -> threading.Event:
        """Set while its wheels must rest."""
        ...

    @property
    def folder(self) -> Path | None:
        """Folder of the run; None where it keeps none."""
        ...

    @property
    def begun_in(self) -> Path | None:
        """Folder of the saved map in which the run began; None where it began in none."""
        ...

    def base_state(self) -> BaseState | None:
        """The newest state of the base; None without one."""
        ...

    def battery_state(self) -> BaseState | None:
        """The newest state that may still be shown for the battery; it may be some seconds old."""
        ...

    def resume_base(self) -> None:
        """Ask a base that stopped obeying, at an edge or lifted, to obey again."""
        ...

    def show(self, feedback: Feedback) -> None:
        """Play feedback on the base's lights and speaker."""
        ...

    def picture_of(self, report: GoalReport) -> bytes | None:
        """JPEG of the best place of a report; None where there is none."""
        ...

    def picture_of_place(self, place: Candidate) -> bytes | None:
        """JPEG of a place on the map; None where there is none."""
        ...

    def keep_verdict(self, report: GoalReport, confirmed: bool) -> None:
        """Keep beside the run what people say of an arrival."""
        ...

    def keep_verdict_on_way(self, xy: NDArray[np.float64], confirmed: bool) -> None:
        """Keep what people say of the place that the robot approaches, (2,) in `map` [m]."""
        ...


class BareRobot:
    """A robot that has no base, takes no pictures and keeps nothing."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self.lease, self.stopped = DriveLease(now), threading.Event()
        self.folder: Path | None = None
        self.begun_in: Path | None = None

    def base_state(self) -> BaseState | None:
        """None."""
        return None

    def battery_state(self) -> BaseState | None:
        """None."""
        return None

    def resume_base(self) -> None:
        """Do nothing."""

    def show(self, feedback: Feedback) -> None:
        """Do nothing."""

    def picture_of(self, report: GoalReport) -> bytes | None:
        """None."""
        return None

    def picture_of_place(self, place: Candidate) -> bytes | None:
        """None."""
        return None

    def keep_verdict(self, report: GoalReport, confirmed: bool) -> None:
        """Do nothing."""

    def keep_verdict_on_way(self, xy: NDArray[np.float64], confirmed: bool) -> None:
        """Do nothing."""
