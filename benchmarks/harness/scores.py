"""Rates with their uncertainty, paired comparisons, and SPL."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from scipy.stats import binomtest

from benchmarks.episodes.episode import EpisodeResult, GoalResult, Home
from sim_stubs.scoring.success import IN_COCO

_Z = 1.959964
"""Half width of the middle 95 % of a normal distribution, in standard deviations."""
_RESAMPLES = 10_000
_BINS = 10
"""Number of bins in which probabilities are compared with the truth."""
_LEAST_PROBABILITY = 1e-6
"""A probability counts as this at least, so that one surely wrong trial is not all."""
_SIGNIFICANT = 0.05
"""A comparison shows a difference where its p is below this."""


@dataclass(frozen=True, slots=True)
class Rate:
    """How often something happened."""

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


def interval_over_homes(
    values: Iterable[tuple[Home, float]], percentiles: tuple[float, float] = (2.5, 97.5)
) -> tuple[float, float] | None:
    """An interval of a mean, or a rate, by the cluster bootstrap: whole homes are drawn again.

    What happens in one home is not independent. With few homes the interval is rough, and where
    they happen to be alike it is too narrow. A fixed seed makes it the same every time.

    Args:
        values: Home and value of each trial; an outcome counts as 0 or 1.
        percentiles: Of the ends of the interval; those of one of 95 % by default.

    Returns:
        These percentiles of the pooled mean; None with fewer than two homes.
    """
    by_home: dict[Home, list[float]] = {}
    for home, value in values:
        by_home.setdefault(home, []).append(value)
    homes = len(by_home)
    if homes < 2:
        return None
    tallies = np.array([(sum(each), len(each)) for each in by_home.values()])
    drawn = np.random.default_rng(0).integers(homes, size=(_RESAMPLES, homes))
    counts, trials = tallies[drawn].sum(axis=1).T
    low, high = np.percentile(counts / trials, percentiles)
    return float(low), float(high)


@dataclass(frozen=True, slots=True)
class PairedCounts:
    """Two ways to do the same trials: in how many of them only one succeeded.

    Attributes:
        wins: Trials in which only the first way succeeded.
        losses: Trials in which only the second way succeeded.
    """

    wins: int
    losses: int

    @staticmethod
    def over(first: Mapping[Any, bool], second: Mapping[Any, bool]) -> PairedCounts:
        """Count over the trials that both ways have done; True is a success."""
        both = [(first[trial], second[trial]) for trial in first.keys() & second.keys()]
        return PairedCounts(both.count((True, False)), both.count((False, True)))

    @property
    def p(self) -> float:
        """Two-sided p of the exact test that wins and losses are equally likely (McNemar 1947)."""
        pairs = self.wins + self.losses
        return float(binomtest(self.wins, pairs).pvalue) if pairs else 1.0

    @property
    def shows_better(self) -> bool:
        """Whether the first way is shown to be better than the second."""
        return self.wins > self.losses and self.p < _SIGNIFICANT


def log_loss(judged: Sequence[tuple[float, bool]]) -> float | None:
    """Mean of -log of the probability given to what came true; None without trials."""
    if not judged:
        return None
    given = [probability if happened else 1.0 - probability for probability, happened in judged]
    return float(-np.log(np.maximum(given, _LEAST_PROBABILITY)).mean())


def expected_calibration_error(judged: Sequence[tuple[float, bool]]) -> float | None:
    """How far probabilities are from what came true, in ten bins of equal width (Naeini 2015).

    It is the mean over the trials of what the mean probability and the rate of their bin differ by;
    None without trials. Few trials make it larger than it is for many.
    """
    if not judged:
        return None
    probabilities, happened = (np.array(each, float) for each in zip(*judged, strict=True))
    bins = np.minimum((probabilities * _BINS).astype(int), _BINS - 1)
    excess = np.bincount(bins, probabilities - happened, _BINS)
    return float(np.abs(excess).sum() / len(judged))


def spl(goals: Sequence[GoalResult]) -> float | None:
    """Success weighted by path length (Anderson et al. 2018, section 3); None without goals.

    A goal that is reached where the robot starts counts as driven without a detour.
    """
    if not goals:
        return None
    return float(np.mean([path_weighted_success(goal) for goal in goals]))


def path_weighted_success(goal: GoalResult) -> float:
    """What one goal adds to SPL: 0 where it was not reached, else shortest over driven way."""
    shortest = goal.shortest_path or 0.0
    longest = max(goal.path_length, shortest)
    return goal.success * (shortest / longest if longest > 0 else 1.0)


@dataclass(frozen=True, slots=True)
class NavigationScore:
    """A row of the paper's table of object-goal navigation.

    Attributes:
        success: Success rate of all episodes.
        success_over_homes: Its 95 % interval over homes; None with fewer than two homes.
        coco: Success rate of the episodes whose goal is an object in COCO.
        others: Success rate of the other episodes.
        said_wrongly: Rate of the episodes in which the robot said that it had arrived and had not.
        spl: Success weighted by path length.
        steps: Mean number of steps of all episodes.
        steps_of_successes: Mean number of steps of the successful episodes.
        path_of_successes: Mean length of the paths of the successful episodes [m].
        shortest_of_successes: Mean length of the shortest paths of the same episodes [m].
        collisions: Number of collisions in all episodes.
        ate: Median error of the trajectories [m].
        stuck: Number of episodes that failed and stood still; None where it was not kept of each
            that failed.
    """

    success: Rate
    success_over_homes: tuple[float, float] | None
    coco: Rate
    others: Rate
    said_wrongly: Rate
    spl: float | None
    steps: float | None
    steps_of_successes: float | None
    path_of_successes: float | None
    shortest_of_successes: float | None
    collisions: int
    ate: float | None
    stuck: int | None

    @staticmethod
    def from_results(results: Sequence[EpisodeResult]) -> NavigationScore:
        """Score episodes with one goal each."""
        goals = [result.goals[0] for result in results]
        reached = [goal for goal in goals if goal.success]
        errors = [result.ate for result in results if result.ate is not None]
        return NavigationScore(
            Rate.over(goal.success for goal in goals),
            interval_over_homes((r.episode.home, r.goals[0].success) for r in results),
            Rate.over(goal.success for goal in goals if goal.text in IN_COCO),
            Rate.over(goal.success for goal in goals if goal.text not in IN_COCO),
            Rate.over(goal.claimed and not goal.success for goal in goals),
            spl(goals),
            _mean([goal.steps for goal in goals]),
            _mean([goal.steps for goal in reached]),
            _mean([goal.path_length for goal in reached]),
            _mean([goal.shortest_path or 0.0 for goal in reached]),
            sum(result.collisions for result in results),
            float(np.median(errors)) if errors else None,
            number_stuck(goals),
        )


def number_stuck(goals: Sequence[GoalResult]) -> int | None:
    """How many goals failed with the robot standing still.

    None where that was not kept of each that failed.
    """
    failed = [goal.stuck for goal in goals if not goal.success]
    return None if None in failed else failed.count(True)


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None
