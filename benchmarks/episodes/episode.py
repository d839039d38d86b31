"""Episodes of a benchmark and their results, as they are stored."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal
from zlib import crc32

from sim_stubs.world.world_spec import seed_of
from vizbot.config import Config
from vizbot.core.observer import Outcome

EncoderScale = Literal["clip", "offset", "unknown"]
"""`clip`: scaled and shifted to those of ViT-L/14; `offset`: that, with offsets and errors;
`unknown`: those of `clip`, of an encoder that does not tell its scale and bias."""


@dataclass(frozen=True, slots=True)
class Variant:
    """One way to run the episodes: a row of the paper's tables.

    Attributes:
        name: Name of the row and of its file.
        config: Settings of the robot.
        oracle: The part that is switched to the truth ("pose", "depth", "encoder", "map", or
            "stop": when it has arrived); None for the robot as it is.
        encoder_scale: Whose cosines the encoder has; None for its own.
        ablated: The part of the search that is taken away (`benchmarks.ablations`); None for the
            whole search.
    """

    name: str
    config: Config
    oracle: str | None = None
    encoder_scale: EncoderScale | None = None
    ablated: str | None = None


FAR = 3.0
"""A goal is far when its shortest path from where the robot truly stands is longer [m]."""


Home = int | str
"""A home: the seed of one of ours, or a name that `--world` takes: bare walls, a file of others."""


def seed_of_home(home: Home) -> int:
    """The seed of starts and noise in a home; that of a file is made of its name alone.

    With bare walls a home has the starts and the noise that it has without.
    """
    seed = home if isinstance(home, int) else seed_of(home)
    return crc32(Path(str(home)).name.encode()) if seed is None else seed


@dataclass(frozen=True, slots=True)
class Episode:
    """One run in one home.

    Attributes:
        home: The home.
        goals: Goals, commanded one after another while each one succeeds.
        number: Number among the episodes of this home. With the home and the first goal it draws
            the start and the noise.
        choose: Number of goals that are commanded: the first, then each time the next in order
            that is FAR from where the robot stands. None for all, however near.
    """

    home: Home
    goals: tuple[str, ...]
    number: int = 0
    choose: int | None = None

    @property
    def count(self) -> int:
        """Number of goals that are commanded while each one succeeds."""
        return len(self.goals) if self.choose is None else self.choose


@dataclass(frozen=True, slots=True)
class GoalResult:
    """How the search for one goal ended.

    Attributes:
        text: The goal in words.
        success: The scorer's verdict.
        claimed: Whether the robot says that it has arrived.
        reason: The scorer's reason for a failure, in a few words; empty on success.
        answer: The robot's last message, in one line.
        distance: Distance on the plan from the stop to the nearest instance [m]; None where it was
            not measured.
        steps: Runs of Algorithm 1.
        path_length: True length of the driven path [m].
        shortest_path: Length of the shortest path from the start to a place that counts as success
            [m]; None when there is none.
        simulated_seconds: Time from the command to the stop [s].
        outcome: How the robot ended it; None after an error, and in older results.
        said_seen: Share of the floor that the robot then said that it had seen, 0 to 1; None where
            it did not know, and in older results.
        truly_seen: Share that it had seen; None likewise.
        stuck: Whether it failed and stood still, by `is_stuck` of `benchmarks.episodes.run`; None
            in older results.
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
    outcome: Outcome | None = None
    said_seen: float | None = None
    truly_seen: float | None = None
    stuck: bool | None = None


@dataclass(frozen=True, slots=True)
class EpisodeResult:
    """How an episode ended. Two results are equal that differ in the time they took alone.

    Attributes:
        episode: The episode.
        goals: Results of the goals that were commanded.
        collisions: Number of collisions.
        ate: Absolute trajectory error of the robot's pose estimates [m]; None for a run too short.
        wall_seconds: Duration on this machine [s].
        track: True x, y of the base along the path [m], thinned.
        stop: True x, y [m] and yaw [rad] of the base at the end.
    """

    episode: Episode
    goals: tuple[GoalResult, ...]
    collisions: int
    ate: float | None
    wall_seconds: float = field(compare=False)
    track: tuple[tuple[float, float], ...]
    stop: tuple[float, float, float]

    @property
    def reached(self) -> int:
        """Number of goals that succeeded."""
        return sum(goal.success for goal in self.goals)

    @property
    def success(self) -> bool:
        """Whether all goals succeeded."""
        return self.reached == self.episode.count


@dataclass(frozen=True, slots=True)
class HomeGoals:
    """The goals that exist in a home.

    Attributes:
        home: The home.
        goals: Those of the paper's 16 goals that exist in it, in the paper's order.
        models: Pairs of one of these goals and a model that counts as it, each pair once; a model
            is named with its author and licence, a shape of our own by the seed that drew it.
            Empty where it was not recorded.
    """

    home: Home
    goals: tuple[str, ...]
    models: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class ExplorationResult:
    """How the exploration of a home ended.

    Attributes:
        home: Seed of the home.
        explored: Whether nothing was left to explore.
        reason: Why the exploration ended, in one line.
        steps: Runs of Algorithm 1.
    """

    home: int
    explored: bool
    reason: str
    steps: int


@dataclass(frozen=True, slots=True)
class BelievedAnswer:
    """The most probable place of a map for a query.

    Attributes:
        probability: That it is what was asked for; 0 where the map shows no place.
        correct: Whether it lies within half a metre of an instance, or inside the room asked for.
    """

    probability: float
    correct: bool


@dataclass(frozen=True, slots=True)
class QueryResult:
    """The answer of a map to one query.

    Attributes:
        home: Seed of the explored home.
        scales: Scales of the patches that were searched.
        text: The query.
        exists: Whether the home has such a thing; queries for absent things show false alarms.
        similarity: Of the most similar element, -1 to 1; of an answer that is not by belief that of
            the place that is answered.
        threshold: Probability above which the robot takes a place for it; of an answer that is not
            by belief the similarity.
        position: True x, y of the answered place on the plan [m], by the pose at the start.
        correct: Whether it lies within half a metre of an instance, or inside the room asked for.
        most_similar_correct: The same for the most similar element alone (the paper's rule).
        believed: The answer by belief; None where there was none, as before the robot had beliefs.
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
    believed: BelievedAnswer | None = None
