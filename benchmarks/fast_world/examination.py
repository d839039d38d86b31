"""Examines the belief: `python -m benchmarks.fast_world.examination VIEWS --out FILE`.

In training homes on which nothing was fitted, walks are taken as for the fit. Two things are asked
of the probability of each place. Is it one, of all places that were seen? And does it tell what the
robot passes near by from what only looks like it: how much is missed at the first pass, where so
many of the likeliest wrong places are believed? Both are asked of the best cosine of each place,
too; it becomes a probability as Platt did it (1999, "Probabilistic outputs"), by two numbers that
the homes of the fit gave. And where the likeliest place is wrong, is the next one right as often as
it is believed? VIEWS keeps the views.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import cv2
import numpy as np
import typer
from numpy.typing import NDArray

from benchmarks.episodes.run import encoder_of
from benchmarks.fast_world.fit import HOMES, SeenHome, is_room, logistic, see_home, walk_in
from benchmarks.fast_world.views import HEADINGS
from benchmarks.harness.bench_plan import UNATTENDED
from benchmarks.harness.fingerprint import commit, hardware
from benchmarks.harness.scores import expected_calibration_error, interval_over_homes, log_loss
from benchmarks.harness.workers import in_parallel
from mapping.clip.background.phrases import other_rooms
from mapping.clip.belief import unless_another
from mapping.clip.evidence import evidence
from mapping.clip.footprint import PLACE
from mapping.clip.place_views import PlaceViews
from mapping.clip.retrieval import best
from mapping.clip.weights import fitted_weights
from sim_stubs.scoring.places import are_true
from vizbot.core.files import write_whole
from vizbot.objectnav.belief_search import CLOSING
from vizbot.objectnav.looks import APART
from vizbot.objectnav.verdicts import OF_ROOM
from vizbot.operator.printing import echo

HELD_OUT = range(932, 938)
"""Homes of the examination: neither encoder, threshold nor belief have seen them, and no number was
chosen in them."""
WALKS = 3
"""Walks for each goal of a home."""
FALSE_SHARES = (0.01, 0.02, 0.03, 0.05, 0.1, 0.15, 0.2, 0.3)
"""Shares of wrong places that are believed, for which the share of what is missed is told."""
ASKED = 0.03
"""Share of the wrong places that may be believed, at which it was asked what is missed."""
_NEAR = CLOSING
"""What a view shows within this distance is passed near by [m]."""
_GONE = HEADINGS
"""Views after which a thing that none of them shows near by is passed."""
_MOST_WRONG = 3
"""Wrong places of a walk that count, the likeliest first, `APART` from one another."""
_JUDGED_AT = (0.4, 1.0)
"""When on a walk all places are looked at, as shares of it."""
_LOG_ODDS = slice(0, 3)
"""Features of a view that are log odds by the encoder: a line of the cosine, cut off far out."""
_UNSEEN = -99.0


@dataclass(slots=True, eq=False)
class Passes:
    """What a measure says on walks, a row for each walk, pass or place.

    Attributes:
        wrong: Greatest values of the likeliest wrong places near by, with the home.
        first: Greatest value of a thing during the first pass near by it, with the home.
        values: Of the places that were seen.
        there: Whether the goal is there.
        refuted: Where the likeliest place is wrong, the value of the next one, with the home, and
            whether that one is right.
    """

    wrong: list[tuple[int, float]] = field(default_factory=list)
    first: list[tuple[int, float]] = field(default_factory=list)
    values: list[NDArray[np.float64]] = field(default_factory=list)
    there: list[NDArray[np.bool_]] = field(default_factory=list)
    refuted: list[tuple[int, float, bool]] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Missed:
    """What is missed where so many of the likeliest wrong places are believed.

    Attributes:
        false: Share of these.
        missed: Share of the things that are not taken for one at the first pass near by.
        over_homes: Bounds of that, 95 %, over homes; None of one home.
    """

    false: float
    missed: float
    over_homes: tuple[float, float] | None


@dataclass(frozen=True, slots=True)
class Bin:
    """Places with about the same probability.

    Attributes:
        mean: Mean probability.
        share: Share of them where the goal is.
        count: How many they are.
    """

    mean: float
    share: float
    count: int


@dataclass(frozen=True, slots=True)
class Examined:
    """What came of one measure.

    Attributes:
        log_loss: Mean log loss of all places that were seen.
        calibration_error: Expected calibration error over them.
        bins: Ten bins of equal width.
        curve: What is missed at each of `FALSE_SHARES`.
    """

    log_loss: float
    calibration_error: float
    bins: tuple[Bin, ...]
    curve: tuple[Missed, ...]


def passes_in(
    homes: Sequence[SeenHome],
    seeds: Sequence[int],
    counts: Callable[[str], bool] = lambda goal: True,
) -> tuple[Passes, Passes]:
    """What the belief and the best cosine say on walks in homes.

    Args:
        homes: What their views show.
        seeds: Of the homes, which draw the walks.
        counts: Which goals count; the walks for them are the same whichever do.
    """
    believed, cosine = Passes(), Passes()
    for home, seed in zip(homes, seeds, strict=True):
        rng = np.random.default_rng(seed)
        for goal in home.true:
            walks = [walk_in(home, rng) for _ in range(WALKS)]
            for walk in walks if counts(goal) else ():
                for passes, values in ((believed, _Believed(goal)), (cosine, _BestCosine())):
                    _walk(home, seed, goal, walk, values, passes)
    return believed, cosine


class _Believed:
    """The probability of each place by the belief, as a search has it."""

    def __init__(self, goal: str) -> None:
        self._views = {each: PlaceViews() for each in (goal, *other_rooms(goal))}
        self._weights, self._room = fitted_weights(), is_room(goal)

    def add(self, home: SeenHome, goal: str, view: int) -> None:
        rows = slice(home.first[view], home.first[view + 1])
        ranges, weights = home.ranges[rows], self._weights
        stands = np.full(len(ranges), home.stands[view])
        unasked = np.zeros((len(ranges), 2), np.float32)
        for asked, views in self._views.items():
            found = evidence(home.features[asked][rows], ranges, weights.near, weights.far)
            likeness = home.likeness[asked][rows]
            views.add(home.places[rows], found, likeness, ranges, stands, unasked)

    def values(self) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.bool_]]:
        views = next(iter(self._views.values()))
        own, *rivals = (self._probabilities(each) for each in self._views.values())
        values = unless_another(own, views.seen, rivals) if rivals else own
        return views.low, values, views.seen

    def _probabilities(self, views: PlaceViews) -> NDArray[np.float64]:
        odds = views.features(self._room) @ self._weights.join
        return np.asarray(1.0 / (1.0 + np.exp(-odds)))


class _BestCosine:
    """The best log odds of the encoder that any view of each place has, cut off far out."""

    def __init__(self) -> None:
        self._low, self._best = np.full(2, -200), np.full((400, 400), _UNSEEN)

    def add(self, home: SeenHome, goal: str, view: int) -> None:
        rows = slice(home.first[view], home.first[view + 1])
        column, row = (home.places[rows] - self._low).T
        np.maximum.at(self._best, (row, column), home.features[goal][rows, _LOG_ODDS].max(axis=1))

    def values(self) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.bool_]]:
        return self._low, self._best, self._best > _UNSEEN


def _walk(
    home: SeenHome,
    seed: int,
    goal: str,
    walk: Sequence[int],
    measure: _Believed | _BestCosine,
    passes: Passes,
) -> None:
    """Walk once, and add what the measure says near by."""
    there, low = home.true[goal]
    _, things = cv2.connectedComponents(there.astype(np.uint8))
    wrong = dict[tuple[int, int], float]()
    now, last, over = dict[int, float](), dict[int, int](), dict[int, float]()
    judged = {int(len(walk) * share) - 1 for share in _JUDGED_AT}
    for step, view in enumerate(walk):
        measure.add(home, goal, view)
        first, values, seen = measure.values()
        rows = slice(home.first[view], home.first[view + 1])
        places = np.unique(home.places[rows][home.ranges[rows] <= _NEAR], axis=0)
        column, row = (places - first).T
        near, true = values[row, column], are_true(places, there, low)
        for (x, y), value in zip(places[~true].tolist(), near[~true].tolist(), strict=True):
            wrong[x, y] = max(wrong.get((x, y), _UNSEEN), value)
        column, row = (places[true] - low).T
        for thing, value in zip(things[row, column].tolist(), near[true].tolist(), strict=True):
            if thing not in over:
                now[thing], last[thing] = max(now.get(thing, _UNSEEN), value), step
        for thing in [each for each in now if step - last[each] >= _GONE]:
            over[thing] = now.pop(thing)
        if step in judged:
            place = np.argwhere(seen)[:, ::-1] + first
            passes.values.append(values[seen])
            passes.there.append(are_true(place, there, low))
            apart = OF_ROOM if is_room(goal) else APART
            after = _next_after(values[seen], place, passes.there[-1], apart)
            passes.refuted += [(seed, *each) for each in after]
    passes.first += [(seed, value) for value in (over | now).values()]
    if wrong:
        at, values = np.array(list(wrong), float) * PLACE, np.array(list(wrong.values()))
        likeliest = best(values.astype(np.float32), at, _MOST_WRONG, APART)
        passes.wrong += [(seed, float(value)) for value in values[likeliest]]


def _next_after(
    values: NDArray[np.float64],
    places: NDArray[np.int64],
    right: NDArray[np.bool_],
    apart: float,
) -> Iterator[tuple[float, bool]]:
    """The second likeliest place where the likeliest is wrong: its value, and whether it is right.

    Args:
        values: (N,) of the places.
        places: (N, 2) column, row.
        right: (N,) whether the goal is there.
        apart: Least distance between the two [m].
    """
    centres = places.astype(np.float64) * PLACE
    likeliest = best(values.astype(np.float32), centres, 2, apart)
    if len(likeliest) == 2 and not right[likeliest[0]]:
        yield float(values[likeliest[1]]), bool(right[likeliest[1]])


def missed_at(passes: Passes, share: float) -> Missed:
    """What is missed where at most a share of the likeliest wrong places are believed."""
    wrong = np.sort([value for _, value in passes.wrong])[::-1]
    allowed = int(share * len(wrong))
    least = float(np.nextafter(wrong[allowed], np.inf)) if allowed < len(wrong) else _UNSEEN
    missed = [(seed, float(value < least)) for seed, value in passes.first]
    mean = float(np.mean([each for _, each in missed]))
    return Missed(share, mean, interval_over_homes(missed))


def after_refutation(passes: Passes) -> dict[str, Any]:
    """What the next place is believed to be where the likeliest is wrong, and how often it is."""
    right = [(seed, float(each)) for seed, _, each in passes.refuted]
    return {
        "count": len(right),
        "believed": float(np.mean([value for _, value, _ in passes.refuted])),
        "right": float(np.mean([each for _, each in right])),
        "over_homes": interval_over_homes(right),
    }


def examined(passes: Passes) -> Examined:
    """The figures of a measure whose values are probabilities."""
    values, there = np.concatenate(passes.values), np.concatenate(passes.there)
    judged = list(zip(values.tolist(), there.tolist(), strict=True))
    bins = []
    for low, high in pairwise(np.linspace(0.0, 1.0, 11)):
        inside = (values >= low) & ((values < high) | (high == 1.0))
        if inside.any():
            mean, share = float(values[inside].mean()), float(there[inside].mean())
            bins.append(Bin(mean, share, int(inside.sum())))
    curve = tuple(missed_at(passes, share) for share in FALSE_SHARES)
    loss, error = log_loss(judged), expected_calibration_error(judged)
    assert loss is not None and error is not None
    return Examined(loss, error, tuple(bins), curve)


def platt(fitted: Passes, passes: Passes) -> None:
    """Make probabilities of the values of `passes`, by what those of `fitted` say."""
    values, there = np.concatenate(fitted.values), np.concatenate(fitted.there)
    inputs = np.stack([values, np.ones_like(values)], axis=1)
    slope, offset = logistic(inputs, there.astype(float), np.ones(len(values)))
    passes.values = [1.0 / (1.0 + np.exp(-(slope * each + offset))) for each in passes.values]


def _seen(homes: range, folder: Path) -> Iterator[SeenHome]:
    jobs = [(seed, folder) for seed in homes]
    found = dict(in_parallel(see_home, jobs, "views", lambda job, _: f"home {job[0]}"))
    yield from (found[job] for job in jobs)


def examine(
    folder: Annotated[Path, typer.Argument(help="Where views are kept.")],
    out: Annotated[Path, typer.Option(help="The file of what comes of it.")],
) -> None:
    """Examine the belief and the best cosine in homes that nothing was fitted on."""
    _, before = passes_in(list(_seen(HOMES, folder)), HOMES)
    seen = list(_seen(HELD_OUT, folder))
    believed, cosine = passes_in(seen, HELD_OUT)
    things, _ = passes_in(seen, HELD_OUT, lambda goal: not is_room(goal))
    rooms, _ = passes_in(seen, HELD_OUT, is_room)
    platt(before, cosine)
    content = {
        "commit": commit(),
        "hardware": hardware(),
        "encoder": encoder_of(UNATTENDED).model_id,
        "fitted_on": list(HOMES),
        "homes": list(HELD_OUT),
        "wrong_places": len(believed.wrong),
        "passes": len(believed.first),
        "belief": asdict(examined(believed)),
        "cosine": asdict(examined(cosine)),
        "things": asdict(missed_at(things, ASKED)),
        "rooms": asdict(missed_at(rooms, ASKED)),
        "after_refutation": after_refutation(believed),
    }
    write_whole(out, (json.dumps(content, indent=1) + "\n").encode())
    echo(f"written: {out}", err=True)


if __name__ == "__main__":
    typer.run(examine)
