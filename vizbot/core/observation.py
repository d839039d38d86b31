"""What a run tells its observers: one `Step` for each frame, one `GoalReport` for each goal."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vizbot.core.types import SE3, OccupancyGrid, PoseEstimate, RGBDFrame, Twist


class Outcome(StrEnum):
    """How the search for one goal, or an exploration, ended."""

    ARRIVED = "arrived"
    LOCATED = "located"
    NOT_FOUND = "not_found"
    EXPLORED = "explored"
    GAVE_UP = "gave_up"


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A place on the map that may be what was asked for.

    Attributes:
        position: (3,) in `map` [m].
        similarity: Cosine between the question and the place, -1 to 1.
    """

    position: NDArray[np.float64]
    similarity: float


@dataclass(frozen=True, slots=True, eq=False)
class GoalReport:
    """What became of one goal.

    Attributes:
        text: The goal in the user's words.
        outcome: How it ended.
        reason: Why, in one line.
        candidates: The best places on the map, best first; but where the robot has arrived comes
            before all others.
    """

    text: str
    outcome: Outcome
    reason: str
    candidates: tuple[Candidate, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One run of the paper's Algorithm 1, or one frame of a recording.

    Attributes:
        index: From 0, over the whole run.
        frame: What the camera saw.
        estimate: Where it was taken.
        T_map_base: The base then.
        grid: The obstacle map.
        goal: The words looked for; empty while only mapping.
        activity: What the robot is doing, in plain words.
        path: (P, 2) x, y in `map` [m] still to be driven; None without one.
        target: (2,) x, y in `map` [m] of the element driven to; None while exploring.
        distance_to_go: Along the path [m]; None without one.
        threshold: Similarity above which an element counts as found.
        points: (N, 3) elements of the CLIP map in `map` [m].
        similarities: (N,) of the elements to the goal; all zero without a goal.
        ended: How the search ended in this step, and why in one line; None while it goes on.
        command: What the base is to do, or would be without one; None while only mapping.
    """

    index: int
    frame: RGBDFrame
    estimate: PoseEstimate
    T_map_base: SE3
    grid: OccupancyGrid
    goal: str
    activity: str
    path: NDArray[np.float64] | None
    target: NDArray[np.float64] | None
    distance_to_go: float | None
    threshold: float
    points: NDArray[np.float64]
    similarities: NDArray[np.float32]
    ended: tuple[Outcome, str] | None
    command: Twist | None

    @property
    def best_similarity(self) -> float | None:
        """Of all elements to the goal; None while the map is empty or nothing is asked."""
        return float(self.similarities.max()) if self.goal and len(self.similarities) else None


class Observer(Protocol):
    """Watches a run: viewer, recorder, report. It must not change what it is shown."""

    def on_step(self, step: Step) -> None:
        """One more frame has been worked on."""
        ...

    def on_goal(self, report: GoalReport) -> None:
        """The search for one goal has ended."""
        ...
