"""What a benchmark asks of the robot, and what became of it."""

from __future__ import annotations

from dataclasses import dataclass

from vizbot.config import Config


@dataclass(frozen=True, slots=True)
class Variant:
    """One way to run the episodes: a row of the paper's tables.

    Attributes:
        name: Of the row; also the name of its file.
        config: Settings of the robot.
        counterpart: The part that is switched to the truth ("pose", "depth", "encoder", "map");
            None for the robot as it is.
    """

    name: str
    config: Config
    counterpart: str | None = None


@dataclass(frozen=True, slots=True)
class Episode:
    """One run in one home.

    Attributes:
        home: Seed of the home.
        goals: Told one after another, each only when the last one succeeded.
        number: Tells episodes of one home with the same goals apart; with the home and the first
            goal it draws start and noise.
    """

    home: int
    goals: tuple[str, ...]
    number: int = 0


@dataclass(frozen=True, slots=True)
class GoalResult:
    """What became of one goal.

    Attributes:
        text: The goal in words.
        success: The scorer's verdict.
        claimed: Whether the robot says that it has arrived.
        reason: Why not, in a few words of the scorer; empty on success.
        answer: What the robot said in the end, in one line.
        distance: From where it stopped to the nearest instance on the plan [m]; None when nobody
            measured it.
        steps: Runs of Algorithm 1.
        path_length: Truly driven [m].
        shortest_path: From where the goal was told to the nearest place that would do [m]; None
            when there is none.
        simulated_seconds: From being told to having stopped.
    """

    text: str
    success: bool
    claimed: bool
    reason: str
    answer: str
    distance: float | None
    steps: int
    path_length: float
    shortest_path: float | None
    simulated_seconds: float


@dataclass(frozen=True, slots=True)
class EpisodeResult:
    """What became of an episode.

    Attributes:
        episode: What was asked.
        goals: One for each goal that was told.
        collisions: How often the robot ran into something.
        ate: Absolute trajectory error of its own pose estimates [m]; None for a run too short.
        wall_seconds: What it took here.
        track: True x, y of the base along the way [m], thinned.
        stop: True x, y [m] and yaw [rad] where it ended.
    """

    episode: Episode
    goals: tuple[GoalResult, ...]
    collisions: int
    ate: float | None
    wall_seconds: float
    track: tuple[tuple[float, float], ...]
    stop: tuple[float, float, float]

    @property
    def reached(self) -> int:
        """How many goals in a row succeeded."""
        return sum(goal.success for goal in self.goals)

    @property
    def success(self) -> bool:
        """Whether all goals did."""
        return self.reached == len(self.episode.goals)


@dataclass(frozen=True, slots=True)
class HomeGoals:
    """What can be asked for in a home.

    Attributes:
        home: Its seed.
        goals: Those of the paper's 16 that exist in it, in the paper's order.
    """

    home: int
    goals: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ExplorationResult:
    """How the exploration of a home ended.

    Attributes:
        home: Its seed.
        explored: Whether nothing was left to see.
        reason: Why it ended, in one line.
        steps: Runs of Algorithm 1.
    """

    home: int
    explored: bool
    reason: str
    steps: int


@dataclass(frozen=True, slots=True)
class QueryResult:
    """The answer of a map to one question.

    Attributes:
        home: Seed of the home that was explored.
        scales: Of the patches that were asked.
        text: The question.
        exists: Whether the home has such a thing; asked all the same, for false alarms.
        similarity: Of the best element, -1 to 1.
        threshold: Above which the robot takes an element for what was asked.
        position: True x, y of that element on the plan [m], by the pose the robot started at.
        correct: Within half a metre of an instance, or inside the room that was asked for.
        most_similar_correct: The same for the most similar element, whatever the views around it
            say (the paper's rule).
    """

    home: int
    scales: tuple[int, ...]
    text: str
    exists: bool
    similarity: float
    threshold: float
    position: tuple[float, float]
    correct: bool
    most_similar_correct: bool
