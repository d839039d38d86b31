"""Fits the numbers of the belief: `python -m benchmarks.fast_world.fit FOLDER`.

In training homes that neither the encoder nor its threshold has seen, views are taken from places
drawn by the home's seed. First the evidence of one view is fitted to what is truly at the places
that it shows, near and far apart; then, on walks from view to view, what all views of a place say
together. Both are logistic regressions over the paper's goals. FOLDER keeps the views. With
`--without` they are fitted to less, to see what the rest is worth.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from benchmarks.episodes.run import encoder_of
from benchmarks.fast_world.places import are_true, true_places
from benchmarks.fast_world.views import HEADINGS, View, pose_of
from benchmarks.fast_world.walk import FastHome
from benchmarks.harness.bench_plan import UNATTENDED
from benchmarks.harness.workers import in_parallel
from mapping.clip.background.phrases import other_rooms
from mapping.clip.evidence import NAMES, NEAR, PRIOR, WEIGHTS_FILE, Weights, evidence, features
from mapping.clip.footprint import PLACE
from mapping.clip.place_views import PlaceViews
from mapping.clip.scores import Background, Query
from sim_stubs.scoring.success import GOALS
from vizbot.core.geometry import transform
from vizbot.operator.printing import echo

HOMES = range(916, 926)
"""Training homes from 916 on serve for this: the encoder learned in 0 to 399, its threshold was
chosen in 900 to 915."""
_PLACES = 80
"""Number of places in a home that views are taken from."""
_MOST_VIEWS = 12_000
"""Views of places of one goal and home that count, at most."""
_WALKS, _LONGEST_WALK, _CUTS = 3, 220, (0.15, 0.4, 0.7, 1.0)
"""Walks for each goal, the number of views of the longest, and when on it places are looked at."""
_KEPT = 0.3
"""Share of the places without the goal that count, in place of all."""
_RIDGE = 1e-6


class Omission(StrEnum):
    """What the numbers may be fitted without."""

    Z_SCORE = "z-score"
    """Standard deviations above the background: the log odds of the encoder are left."""
    JOINED_VIEWS = "joined views"
    """How views agree, and what is around a place: its best views are left."""
    OFFSETS_OF_TEXTS = "offsets of texts"
    """How high the question's own log odds go on the bank of pictures: all texts count alike."""


_OF_VIEWS = {Omission.Z_SCORE: "z-score", Omission.OFFSETS_OF_TEXTS: "upper tail"}
"""How the names of the features of a view begin that are left out (`mapping.clip.evidence`)."""
_BEST_VIEWS = (0, 1, 6, 8, 14, 19)
"""Features of a place that its best views alone make (`mapping.clip.place_views`)."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenHome:
    """What the views of a home show of their places, one view of a place a row.

    Attributes:
        features: (R, 20) of each goal, and of the rooms that one may be instead, by its name.
        there: (R,) whether it is truly there, of the goals, likewise.
        true: What `true_places` returns, likewise.
        likeness: (R,) of each with features, likewise.
        ranges: (R,) [m].
        places: (R, 2) column, row.
        first: (V + 1,) first row of each view.
        stands: (V,) number of the place that each view is taken from.
        xy: (V, 2) where that is [m].
        headings: (V,) numbers of their headings.
    """

    features: dict[str, NDArray[np.float32]]
    there: dict[str, NDArray[np.bool_]]
    true: dict[str, tuple[NDArray[np.bool_], NDArray[np.int64]]]
    likeness: dict[str, NDArray[np.float32]]
    ranges: NDArray[np.float32]
    places: NDArray[np.int64]
    first: NDArray[np.int64]
    stands: NDArray[np.int64]
    xy: NDArray[np.float64]
    headings: NDArray[np.int64]


def logistic(
    inputs: NDArray[np.float64], outcomes: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Weights (K,) of a logistic regression, by Newton's method.

    Args:
        inputs: (N, K); a column of ones gives a constant.
        outcomes: (N,) 0 or 1.
        weights: (N,) of the rows.
    """
    found = np.zeros(inputs.shape[1])
    ridge = _RIDGE * weights.sum() * np.eye(len(found))
    for _ in range(50):
        expected = 1.0 / (1.0 + np.exp(-np.clip(inputs @ found, -30.0, 30.0)))
        slope = inputs.T @ (weights * (expected - outcomes)) + ridge @ found
        spread = weights * expected * (1.0 - expected)
        step = np.linalg.solve((inputs * spread[:, None]).T @ inputs + ridge, slope)
        found -= step
        if np.abs(step).max() < 1e-6:
            break
    return found


def seen_in(home: FastHome) -> SeenHome:
    """Take the views of a home and see what is truly at the places that they show."""
    rng = np.random.default_rng(home.seed)
    stands = np.sort(rng.permutation(len(home.places.xy))[:_PLACES])
    numbers = [(int(stand), heading) for stand in stands for heading in range(HEADINGS)]
    views = [home.views.view(home.places.xy[stand], stand, heading) for stand, heading in numbers]
    background = Background.embedded_by(home.encoder)
    embeddings = np.concatenate([view.elements.embeddings for view in views])
    statistics = background.statistics(embeddings)
    first_element = np.cumsum([0, *(len(view.elements.boxes) for view in views)])
    first = np.cumsum([0, *(len(view.footprint.shares) for view in views)])
    patches = np.concatenate(
        [view.footprint.patches + start for view, start in zip(views, first_element, strict=False)]
    ).astype(np.int64)
    points = [
        _in_world(view, home, stand, heading)
        for view, (stand, heading) in zip(views, numbers, strict=True)
    ]
    xy = home.places.xy[[stand for stand, _ in numbers]]
    offsets = np.concatenate(points) - np.repeat(xy, np.diff(first), axis=0)
    ranges = np.linalg.norm(offsets, axis=1).astype(np.float32)
    shares = np.concatenate([view.footprint.shares for view in views])
    places = np.floor(np.concatenate(points) / PLACE).astype(np.int64)
    goals = [goal for goal in GOALS if true_places(home.world.house, goal)[0].any()]
    asked = list(dict.fromkeys([*goals, *(each for goal in goals for each in other_rooms(goal))]))
    found, there, true, likeness = {}, {}, {}, {}
    for goal, text in zip(asked, home.encoder.embed_texts(asked), strict=True):
        question = Query(text, home.encoder.log_odds)
        scores, tail = question.scores(embeddings, statistics), question.tail(background.pictures)
        found[goal] = features(scores, patches, ranges, shares, tail)
        likeness[goal] = scores[patches[:, 2], 1]
    for goal in goals:
        true[goal] = true_places(home.world.house, goal)
        there[goal] = are_true(places, *true[goal])
    return SeenHome(
        found, there, true, likeness, ranges, places, first,
        np.array([stand for stand, _ in numbers]), xy, np.array([turn for _, turn in numbers]),
    )  # fmt: skip


def fitted(homes: list[SeenHome], without: Omission | None = None) -> Weights:
    """The numbers that fit what was seen in these homes; what is left out weighs nothing."""
    rng = np.random.default_rng(0)
    inputs, outcomes, weights, ranges = (
        np.concatenate(each)
        for each in zip(*(part for home in homes for part in _views(home, rng)), strict=True)
    )
    if without in _OF_VIEWS:
        inputs[:, [name.startswith(_OF_VIEWS[without]) for name in NAMES]] = 0.0
    near = ranges <= NEAR
    of_views = [logistic(inputs[m], outcomes[m], weights[m]) for m in (near, ~near)]
    joined = [part for home in homes for part in _joined(home, of_views[0], of_views[1], rng)]
    inputs, outcomes, weights = (np.concatenate(each) for each in zip(*joined, strict=True))
    if without is Omission.JOINED_VIEWS:
        inputs[:, [i for i in range(inputs.shape[1]) if i not in _BEST_VIEWS]] = 0.0
    return Weights(of_views[0], of_views[1], logistic(inputs, outcomes, weights))


def is_room(goal: str) -> bool:
    """Whether a goal of the paper is a room."""
    return bool(other_rooms(goal))


def _in_world(view: View, home: FastHome, stand: int, heading: int) -> NDArray[np.float64]:
    """Points (R, 2) on the plan that a view shows [m]."""
    T_world_cam = pose_of(home.places.xy[stand], heading) @ home.world.T_base_cam
    return transform(T_world_cam, view.footprint.points_cam)[:, :2]


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
            home.ranges[rows].astype(np.float64),
        )


def _joined(
    home: SeenHome,
    near: NDArray[np.float64],
    far: NDArray[np.float64],
    rng: np.random.Generator,
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]]:
    """Features, outcomes and weights of places, as they stand on walks for each goal."""
    for goal, (there, low) in home.true.items():
        found = evidence(home.features[goal], home.ranges, near, far)
        for walk in (walk_in(home, rng) for _ in range(_WALKS)):
            views, done = PlaceViews(), 0
            for cut in (max(5, int(len(walk) * share)) for share in _CUTS):
                for view in walk[done:cut]:
                    rows = slice(home.first[view], home.first[view + 1])
                    stands = np.full(rows.stop - rows.start, home.stands[view])
                    views.add(
                        home.places[rows], found[rows], home.likeness[goal][rows],
                        home.ranges[rows], stands, np.zeros((len(stands), 2), np.float32),
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


def walk_in(home: SeenHome, rng: np.random.Generator) -> list[int]:
    """Views on a way from place to place, mostly to the nearest that was not visited."""
    number = {pair: i for i, pair in enumerate(zip(home.stands, home.headings, strict=True))}
    places = np.unique(home.stands)
    xy = home.xy[np.searchsorted(home.stands, places)]
    left, at = np.ones(len(places), bool), int(rng.integers(len(places)))
    views = [number[places[at], heading] for heading in range(HEADINGS)]
    while len(views) < _LONGEST_WALK:
        left[at] = False
        if not left.any():
            break
        others = np.flatnonzero(left)
        away = np.linalg.norm(xy[others] - xy[at], axis=1)
        ahead = int(others[np.argmin(away + rng.exponential(0.5, len(others)))])
        dx, dy = xy[ahead] - xy[at]
        turn = round(float(np.arctan2(dy, dx)) / (2 * np.pi / HEADINGS)) + int(rng.integers(-1, 2))
        at = ahead
        views += [number[places[at], (turn + i) % HEADINGS] for i in range(rng.integers(1, 5))]
    return views


def see_home(job: tuple[int, Path]) -> SeenHome:
    """Take the views of a home, or read them."""
    seed, folder = job
    with FastHome(seed, UNATTENDED, encoder_of(UNATTENDED), folder) as home:
        return seen_in(home)


def fit(
    folder: Annotated[Path, typer.Argument(help="Where views are kept.")],
    out: Annotated[Path, typer.Option(help="The file of the numbers.")] = WEIGHTS_FILE,
    without: Annotated[Omission | None, typer.Option(help="What to fit them without.")] = None,
) -> None:
    """Fit the numbers of the belief and write them."""
    jobs = [(seed, folder) for seed in HOMES]
    seen = dict(in_parallel(see_home, jobs, "views", lambda job, _: f"home {job[0]}"))
    weights = fitted([seen[job] for job in jobs], without)
    content = {
        "made_by": "python -m benchmarks.fast_world.fit",
        **({} if without is None else {"without": without}),
        "encoder": encoder_of(UNATTENDED).model_id,
        "homes": list(HOMES),
        "near": weights.near.round(5).tolist(),
        "far": weights.far.round(5).tolist(),
        "join": weights.join.round(5).tolist(),
    }
    out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    echo(f"written: {out}", err=True)


if __name__ == "__main__":
    typer.run(fit)
