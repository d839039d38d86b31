"""What a run reports to its observers: a `Step` for each step and a `GoalReport` for each goal."""

from __future__ import annotations

import errno
import logging
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vizbot.core.errors import VizbotError
from vizbot.core.place_scores import Measure, PlaceScores
from vizbot.core.types import SE3, OccupancyGrid, PoseEstimate, RGBDFrame, Twist


class Outcome(StrEnum):
    """How the search for one goal, or an exploration, ended."""

    ARRIVED = "arrived"
    LOCATED = "located"
    NOT_FOUND = "not_found"
    EXPLORED = "explored"
    GAVE_UP = "gave_up"
    STUCK = "stuck"


_HEADLINES = {
    Outcome.ARRIVED: "Found {}",
    Outcome.LOCATED: "Found {} on the map",
    Outcome.NOT_FOUND: "Did not find {}",
    Outcome.EXPLORED: "Explored {}",
    Outcome.GAVE_UP: "Gave up on {}",
    Outcome.STUCK: "Got stuck on the way to {}",
}
CLAUSE_JOINT = "; "
"""Text between the clauses of a reason."""
_NAMED = re.compile(r"(the|a|an|my|our|your|this|that) ", re.IGNORECASE)
"""Begins a goal that takes no article."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A place on the map that may be what was asked for.

    Attributes:
        position: (3,) in `map` [m].
        score: Probability that the place is the goal; by the method `paper` the cosine between the
            two, -1 to 1.
        frame: Number of the frame that shows the place, as in `Step.frame_number`.
        box: (4,) int32, u0, v0, u1, v1 of the patch in that frame [px], the end not included.
    """

    position: NDArray[np.float64]
    score: float
    frame: int
    box: NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Effort:
    """What a search took.

    Attributes:
        seconds: By the clock of the run [s].
        way: That the robot has driven [m].
    """

    seconds: float
    way: float

    def __str__(self) -> str:
        digits = 0 if self.way >= 10.0 else 1
        return f"{self.seconds:.0f} s, {self.way:.{digits}f} m"


@dataclass(frozen=True, slots=True, eq=False)
class GoalReport:
    """The outcome of the search for one goal.

    Attributes:
        text: The goal in the user's words.
        outcome: How the search ended.
        reason: Why it ended so, in one line.
        candidates: The best places on the map, best first. Where the robot has arrived comes
            before all others.
        measure: What their scores are.
        effort: What the search took; None where the map alone was asked.
        threshold: The score that the places were compared with at the end; None where it is not
            known.
    """

    text: str
    outcome: Outcome
    reason: str
    candidates: tuple[Candidate, ...]
    measure: Measure = Measure.PROBABILITY
    effort: Effort | None = None
    threshold: float | None = None

    @property
    def headline(self) -> str:
        """The outcome in words."""
        return headline(self.text, self.outcome, self.effort)


def headline(goal: str, outcome: Outcome, effort: Effort | None) -> str:
    """How the search for a goal ended, in words: "Found the yellow chair after 50 s, 12 m"."""
    named = goal if _NAMED.match(goal) else f"the {goal}"
    words = _HEADLINES[outcome].format(named)
    return words if effort is None else f"{words} after {effort}"


@dataclass(frozen=True, slots=True)
class OpenQuestion:
    """What only a person can say; the robot rests until somebody says to go on.

    Attributes:
        text: The question, in plain words.
        unanswered: Why the task ends where nobody can be asked, in one line, with the remedy.
    """

    text: str
    unanswered: str


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One run of the paper's Algorithm 1, or one frame of a recording.

    Attributes:
        index: From 0; counts the steps of this run.
        frame: What the camera saw.
        frame_number: Index of that frame on its map. A step may take several frames.
        map_number: From 0; counts the maps of this run. Poses, ids and frame numbers of one map
            mean nothing on another.
        estimate: Where the frame was taken.
        T_map_base: Where the base was then.
        goal: The goal in words; empty for another task.
        activity: What the robot is doing, in plain words.
        why: Why it does that, in clauses with `CLAUSE_JOINT` between them, the first of which
            stands by itself; empty where it needs no saying.
        path: (P, 2) x, y in `map` [m] still to be driven; None without one.
        target: (2,) x, y in `map` [m] of the element driven to; None while exploring.
        distance_to_go: Length of the path [m]; None without one.
        scores: What the search decides by; None without a goal.
        measure: What those scores are.
        threshold: The score that the places were compared with in this step.
        points: (N, 3) elements of the CLIP map in `map` [m].
        frames: (N,) int32, numbers of the frames that show the elements. An embedding takes time,
            so the newest are seldom of this frame.
        boxes: (N, 4) int32, u0, v0, u1, v1 of the elements' patches in those frames [px], the end
            not included.
        keyframe_poses: T_map_cam of every keyframe by its id, as known now.
        closures: Pairs of ids between which a loop is closed.
        frontiers: (F, 2) x, y in `map` [m] of the frontiers at the latest exploration.
        ended: How the task ended in this step, and why in one line; None while it goes on.
        command: The twist that the base was sent, or would have been if there were a base; None
            while only mapping.
        seen_share: Share of the floor that was seen, 0 to 1, as of the last search for a frontier;
            None before one.
        candidate_xy: (2,) x, y in `map` [m] of the place that the robot approaches because it may
            be the goal; None without one.
        decided_score: Score of the place that this step is done for; None where it is for none.
        question: What it asks people, whose answer every task waits for; None where it asks
            nothing.
    """

    index: int
    frame: RGBDFrame
    frame_number: int
    map_number: int
    estimate: PoseEstimate
    T_map_base: SE3
    grid: OccupancyGrid
    goal: str
    activity: str
    why: str
    path: NDArray[np.float64] | None
    target: NDArray[np.float64] | None
    distance_to_go: float | None
    scores: PlaceScores | None
    measure: Measure
    threshold: float
    points: NDArray[np.float64]
    frames: NDArray[np.int32]
    boxes: NDArray[np.int32]
    keyframe_poses: Mapping[int, SE3]
    closures: Sequence[tuple[int, int]]
    frontiers: NDArray[np.float64]
    ended: tuple[Outcome, str] | None
    command: Twist | None
    seen_share: float | None = None
    candidate_xy: NDArray[np.float64] | None = None
    decided_score: float | None = None
    question: OpenQuestion | None = None

    @property
    def shown_score(self) -> float | None:
        """Score of the place that the step is done for, or of the best one where it is for none."""
        return self.best_score if self.decided_score is None else self.decided_score

    @property
    def best_score(self) -> float | None:
        """Score of the best place; None without a goal or a place."""
        return None if self.scores is None else self.scores.best

    @property
    def short_why(self) -> str:
        """The first clause of why."""
        return self.why.split(CLAUSE_JOINT)[0]

    @property
    def keyframe_places(self) -> NDArray[np.float64]:
        """Where the keyframes were taken (K, 3) in `map` [m], in the order of their ids."""
        poses = self.keyframe_poses
        return np.array([poses[i][:3, 3] for i in sorted(poses)]).reshape(-1, 3)

    @property
    def closure_ends(self) -> NDArray[np.float64]:
        """Places (C, 2, 3) in `map` [m] of the keyframes that closed loops join."""
        ends = [[self.keyframe_poses[i][:3, 3] for i in pair] for pair in self.closures]
        return np.array(ends).reshape(-1, 2, 3)


class Observer(Protocol):
    """Watches a run, as viewer, recorder and report do. It must not change what it receives."""

    def on_step(self, step: Step) -> None:
        """Receive a step that has been done."""
        ...

    def on_goal(self, report: GoalReport) -> None:
        """Receive the report of a goal whose search has ended."""
        ...


log = logging.getLogger(__name__)

_REMEDIES = {errno.ENOSPC: "; free some space", errno.EDQUOT: "; free some space"}


class Observers:
    """An observer that passes everything on to others, and drops one that cannot write.

    A full disk costs the video, not the search.
    """

    def __init__(self, observers: Sequence[Observer]) -> None:
        """Pass everything on in this order."""
        self._observers = tuple(observers)

    def on_step(self, step: Step) -> None:
        """Receive a step that has been done."""
        self._notify(lambda observer: observer.on_step(step))

    def on_goal(self, report: GoalReport) -> None:
        """Receive the report of a goal whose search has ended."""
        self._notify(lambda observer: observer.on_goal(report))

    def _notify(self, notify: Callable[[Observer], None]) -> None:
        for observer in self._observers:
            try:
                notify(observer)
            except OSError as error:
                if isinstance(error, VizbotError):
                    raise  # a DeviceTimeoutError is an OSError, too
                name, remedy = type(observer).__name__, _REMEDIES.get(error.errno or 0, "")
                log.warning("%s ends here: %s%s", name, error.strerror or error, remedy)
                self._observers = tuple(other for other in self._observers if other is not observer)
