"""Fits the numbers of the belief to what views of homes show.

First the evidence of one view is fitted to what is truly at the places that it shows, near and far
apart; then, on walks from view to view, what all views of a place say together. Both are logistic
regressions over the paper's goals.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from mapping.clip.background.phrases import other_rooms
from mapping.clip.places.evidence import NAMES, NEAR, PRIOR, Weights, evidence
from mapping.clip.places.place_views import PlaceViews
from vizbot.rehearsal.belief_fit.places import are_true
from vizbot.rehearsal.belief_fit.seen_home import SeenHome, ShownPlaces, Station
from vizbot.rehearsal.belief_fit.views import HEADINGS

_MOST_VIEWS = 12_000
"""Views of places of one goal and home that count, at most."""
_WALKS, _LONGEST_WALK, _CUTS = 3, 220, (0.15, 0.4, 0.7, 1.0)
"""Walks for each goal, the number of views of the longest, and when on it places are looked at."""
_KEPT = 0.3
"""Share of the places without the goal that count, in place of all."""
_RIDGE = 1e-6
"""Ridge of a regression [1 for each row]."""
_DRAWN = 0.01
"""The same, towards numbers that more views were fitted to. Of 0.0001 to 0.3 it has the least log
loss where half of the listed homes judges the other half, with `embedded` and with `photos`. The
numbers were fitted in ten of those homes, so that a little less might be as good elsewhere."""


class Omission(StrEnum):
    """What the numbers may be fitted without."""

    Z_SCORE = "z-score"
    """Standard deviations above the background: the log odds of the encoder are left."""
    JOINED_VIEWS = "joined views"
    """How views agree, and what is around a place: its best views are left."""
    OFFSETS_OF_TEXTS = "offsets of texts"
    """How high the question's own log odds go on the bank of pictures: all texts count alike."""


_OF_VIEWS = {Omission.Z_SCORE: "z-score", Omission.OFFSETS_OF_TEXTS: "upper tail"}
"""How names of features of a view begin that are left out (`mapping.clip.places.evidence`)."""
_BEST_VIEWS = (0, 1, 6, 8, 14, 19)
"""Features of a place that its best views alone make (`mapping.clip.places.place_views`)."""


Walks = Callable[[ShownPlaces, np.random.Generator], Sequence[int]]
"""A function that draws a walk in a home: numbers of its views, in their order."""


def logistic(
    inputs: NDArray[np.float64],
    outcomes: NDArray[np.float64],
    weights: NDArray[np.float64],
    prior: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Weights (K,) of a logistic regression, by Newton's method.

    Args:
        inputs: (N, K); a column of ones gives a constant.
        outcomes: (N,) 0 or 1.
        weights: (N,) of the rows.
        prior: (K,) what is found is drawn to these; None for none.
    """
    strength, towards = (_RIDGE, 0.0) if prior is None else (_DRAWN, prior)
    found = np.zeros(inputs.shape[1])
    ridge = strength * weights.sum() * np.eye(len(found))
    for _ in range(50):
        expected = 1.0 / (1.0 + np.exp(-np.clip(inputs @ found, -30.0, 30.0)))
        slope = inputs.T @ (weights * (expected - outcomes)) + ridge @ (found - towards)
        spread = weights * expected * (1.0 - expected)
        step = np.linalg.solve((inputs * spread[:, None]).T @ inputs + ridge, slope)
        found -= step
        if np.abs(step).max() < 1e-6:
            break
    return found


def walk(
    xy: NDArray[np.float64], rng: np.random.Generator, longest: int = _LONGEST_WALK
) -> list[Station]:
    """A way from place to place, mostly to the nearest that was not visited.

    Args:
        xy: (N, 2) of the places [m].
        rng: Draws it.
        longest: Number of views from which on no place is visited any more.

    Returns:
        Places, by their numbers in `xy`, and headings of the views.
    """
    left, at = np.ones(len(xy), bool), int(rng.integers(len(xy)))
    stations = [(at, heading) for heading in range(HEADINGS)]
    while len(stations) < longest:
        left[at] = False
        if not left.any():
            break
        others = np.flatnonzero(left)
        away = np.linalg.norm(xy[others] - xy[at], axis=1)
        ahead = int(others[np.argmin(away + rng.exponential(0.5, len(others)))])
        dx, dy = xy[ahead] - xy[at]
        turn = round(float(np.arctan2(dy, dx)) / (2 * np.pi / HEADINGS)) + int(rng.integers(-1, 2))
        at = ahead
        stations += [(at, (turn + i) % HEADINGS) for i in range(rng.integers(1, 5))]
    return stations


def drawn_walk(home: ShownPlaces, rng: np.random.Generator) -> list[int]:
    """A walk in a home that was seen with every heading of its places."""
    number = {pair: i for i, pair in enumerate(zip(home.stands, home.headings, strict=True))}
    places = np.unique(home.stands)
    xy = home.xy[np.searchsorted(home.stands, places)]
    return [number[places[stand], heading] for stand, heading in walk(xy, rng)]


def fitted(
    homes: Sequence[SeenHome],
    without: Omission | None = None,
    walks: Walks = drawn_walk,
    prior: Weights | None = None,
) -> Weights:
    """The numbers that fit what was seen in these homes.

    Args:
        homes: What was seen.
        without: What is left out, and weighs nothing.
        walks: Draws walks.
        prior: What the numbers are drawn to; None for none.
    """
    near_prior, far_prior, join_prior = (
        (None,) * 3 if prior is None else (prior.near, prior.far, prior.join)
    )
    rng = np.random.default_rng(0)
    inputs, outcomes, weights, ranges = (
        np.concatenate(each)
        for each in zip(*(part for home in homes for part in _views(home, rng)), strict=True)
    )
    if without in _OF_VIEWS:
        inputs[:, [name.startswith(_OF_VIEWS[without]) for name in NAMES]] = 0.0
    near, far = (
        logistic(inputs[of], outcomes[of], weights[of], drawn)
        for of, drawn in ((ranges <= NEAR, near_prior), (ranges > NEAR, far_prior))
    )
    of_views = Weights(near, far, np.zeros(0))
    joined = [part for home in homes for part in _joined(home, of_views, rng, walks)]
    inputs, outcomes, weights = (np.concatenate(each) for each in zip(*joined, strict=True))
    if without is Omission.JOINED_VIEWS:
        inputs[:, [i for i in range(inputs.shape[1]) if i not in _BEST_VIEWS]] = 0.0
    return replace(of_views, join=logistic(inputs, outcomes, weights, join_prior))


def believed(
    homes: Sequence[SeenHome], weights: Weights, walks: Walks
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Probabilities (N,) of places on walks, whether the goal is there, and how much each counts.

    What a room may be instead is not asked for.
    """
    rng = np.random.default_rng(1)
    joined = [part for home in homes for part in _joined(home, weights, rng, walks)]
    inputs, outcomes, counts = (np.concatenate(each) for each in zip(*joined, strict=True))
    odds = np.clip(inputs @ weights.join, -30.0, 30.0)
    return 1.0 / (1.0 + np.exp(-odds)), outcomes, counts


def is_room(goal: str) -> bool:
    """Whether a goal of the paper is a room."""
    return bool(other_rooms(goal))


def _views(home: SeenHome, rng: np.random.Generator) -> Iterator[tuple[NDArray[np.float64], ...]]:
    """Features, outcomes, weights and ranges of views of places, goal by goal.

    Every goal counts the same, with the share of its places that evidence is measured from.
    """
    for goal, there in home.there.items():
        drawn = []
        shares = (True, PRIOR, _MOST_VIEWS // 3), (False, 1 - PRIOR, _MOST_VIEWS)
        for outcome, share, most in shares:
            rows = np.flatnonzero(there == outcome)
            rows = rng.choice(rows, min(len(rows), most), replace=False)
            drawn.append((rows, np.full(len(rows), share / max(len(rows), 1))))
        if len(drawn[0][0]) == 0:
            continue
        rows, weights = (np.concatenate(each) for each in zip(*drawn, strict=True))
        yield (
            home.features[goal][rows].astype(np.float64),
            there[rows].astype(np.float64),
            weights,
            home.shown.ranges[rows].astype(np.float64),
        )


def _joined(
    home: SeenHome, of_views: Weights, rng: np.random.Generator, walks: Walks
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]]:
    """Features, outcomes and weights of places, as they stand on walks for each goal."""
    shown = home.shown
    for goal, (there, low) in shown.true.items():
        found = evidence(home.features[goal], shown.ranges, of_views.near, of_views.far)
        for way in (walks(shown, rng) for _ in range(_WALKS)):
            views, done = PlaceViews(), 0
            for cut in (max(5, int(len(way) * share)) for share in _CUTS):
                for view in way[done:cut]:
                    rows = slice(shown.first[view], shown.first[view + 1])
                    stands = np.full(rows.stop - rows.start, shown.stands[view])
                    views.add(
                        shown.places[rows], found[rows], home.likeness[goal][rows],
                        shown.ranges[rows], stands, np.zeros((len(stands), 2), np.float32),
                        np.zeros(len(stands), np.float32),
                    )  # fmt: skip
                done = cut
                row, column = np.nonzero(views.seen)
                outcomes = are_true(np.stack([column, row], axis=1) + views.low, there, low)
                kept = outcomes | (rng.random(len(outcomes)) < _KEPT)
                yield (
                    views.features(is_room(goal))[row[kept], column[kept]].astype(np.float64),
                    outcomes[kept].astype(np.float64),
                    np.where(outcomes[kept], 1.0, 1.0 / _KEPT),
                )
