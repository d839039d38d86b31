"""Rates with their uncertainty, and SPL."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from sim_stubs.scoring.goals import IN_COCO
from vizbot.bench.episodes.episode import EpisodeResult, GoalResult

_Z = 1.959964
"""Half width of the middle 95 % of a normal distribution, in standard deviations."""


@dataclass(frozen=True, slots=True)
class Rate:
    """How often something happened.

    Attributes:
        count: How many times it happened.
        trials: How many times it could have happened.
    """

    count: int
    trials: int

    @staticmethod
    def over(happened: Iterable[bool]) -> Rate:
        """Count what is True."""
        values = list(happened)
        return Rate(sum(values), len(values))

    @property
    def value(self) -> float | None:
        """The share, 0 to 1; None without trials."""
        return self.count / self.trials if self.trials else None

    def interval(self) -> tuple[float, float]:
        """95 % score interval of the true rate (Wilson 1927); (0, 1) without trials."""
        if self.trials == 0:
            return 0.0, 1.0
        p, n = self.count / self.trials, self.trials
        centre = (p + _Z**2 / (2 * n)) / (1 + _Z**2 / n)
        half = _Z / (1 + _Z**2 / n) * sqrt(p * (1 - p) / n + _Z**2 / (4 * n**2))
        return max(0.0, centre - half), min(1.0, centre + half)


def spl(goals: Sequence[GoalResult]) -> float | None:
    """Success weighted by path length (Anderson et al. 2018, section 3); None without goals.

    A goal that is reached where the robot starts counts as driven without a detour.
    """
    if not goals:
        return None
    return float(np.mean([goal.success * _directness(goal) for goal in goals]))


def _directness(goal: GoalResult) -> float:
    shortest = goal.shortest_path or 0.0
    longest = max(goal.path_length, shortest)
    return shortest / longest if longest > 0 else 1.0


@dataclass(frozen=True, slots=True)
class NavigationScore:
    """A row of the paper's table of object-goal navigation.

    Attributes:
        success: Success rate of all episodes.
        coco: Success rate of the episodes whose goal is an object in COCO.
        others: Success rate of the other episodes.
        spl: Success weighted by path length.
        steps: Mean number of steps of all episodes.
        steps_of_successes: Mean number of steps of the successful episodes.
        collisions: Number of collisions in all episodes.
        ate: Median error of the trajectories [m].
    """

    success: Rate
    coco: Rate
    others: Rate
    spl: float | None
    steps: float | None
    steps_of_successes: float | None
    collisions: int
    ate: float | None

    @staticmethod
    def from_results(results: Sequence[EpisodeResult]) -> NavigationScore:
        """Score episodes with one goal each."""
        goals = [result.goals[0] for result in results]
        errors = [result.ate for result in results if result.ate is not None]
        return NavigationScore(
            Rate.over(goal.success for goal in goals),
            Rate.over(goal.success for goal in goals if goal.text in IN_COCO),
            Rate.over(goal.success for goal in goals if goal.text not in IN_COCO),
            spl(goals),
            _mean([goal.steps for goal in goals]),
            _mean([goal.steps for goal in goals if goal.success]),
            sum(result.collisions for result in results),
            float(np.median(errors)) if errors else None,
        )


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None
