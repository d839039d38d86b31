"""What views of a home show of its places, and what is truly there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.background.phrases import other_rooms
from mapping.clip.fitted.phrasings import BARE, embed_phrased
from mapping.clip.places.evidence import features
from mapping.clip.places.footprint import PLACE
from mapping.clip.scores import Background, Query
from sim_stubs.scoring.success import GOALS
from vizbot.core.geometry import transform
from vizbot.rehearsal.belief_fit.places import Places, are_true, true_places
from vizbot.rehearsal.belief_fit.views import HEADINGS, Views, pose_of

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import TextEncoder

Station = tuple[int, int]
"""Where a view is taken from: the numbers of a place and of a heading."""


@dataclass(frozen=True, slots=True, eq=False)
class ShownPlaces:
    """The places that views of a home show, one view of a place a row; no question is asked yet.

    Attributes:
        embeddings: (N, D) of the patches of all views.
        patches: (R, 3) of them: the finest, the middle and the coarsest one that shows the place.
        ranges: (R,) [m].
        shares: (R,) share of the finest patch that shows the place.
        places: (R, 2) column, row.
        first: (V + 1,) first row of each view.
        stands: (V,) number of the place that each view is taken from.
        xy: (V, 2) where that is [m].
        headings: (V,) numbers of their headings.
        true: What `true_places` returns, of each goal that the home has, by its name.
    """

    embeddings: NDArray[np.float32]
    patches: NDArray[np.int64]
    ranges: NDArray[np.float32]
    shares: NDArray[np.float32]
    places: NDArray[np.int64]
    first: NDArray[np.int64]
    stands: NDArray[np.int64]
    xy: NDArray[np.float64]
    headings: NDArray[np.int64]
    true: dict[str, tuple[NDArray[np.bool_], NDArray[np.int64]]]


@dataclass(frozen=True, slots=True, eq=False)
class SeenHome:
    """What the views of a home say of the paper's goals at the places that they show.

    Attributes:
        shown: What they show, R views of places.
        features: (R, 20) of each goal, and of the rooms that one may be instead, by its name.
        there: (R,) whether it is truly there, of the goals, likewise.
        likeness: (R,) of each with features, likewise.
    """

    shown: ShownPlaces
    features: dict[str, NDArray[np.float32]]
    there: dict[str, NDArray[np.bool_]]
    likeness: dict[str, NDArray[np.float32]]


def spread_stations(places: Places, seed: int, count: int) -> list[Station]:
    """Every heading of `count` places, drawn by a seed."""
    rng = np.random.default_rng(seed)
    stands = np.sort(rng.permutation(len(places.xy))[:count])
    return [(int(stand), heading) for stand in stands for heading in range(HEADINGS)]


def shown_from(views: Views, places: Places, stations: Sequence[Station]) -> ShownPlaces:
    """Take the views from these stations, in this order, and see what is truly there."""
    taken = [views.view(places.xy[stand], stand, heading) for stand, heading in stations]
    first_element = np.cumsum([0, *(len(view.elements.boxes) for view in taken)])
    first = np.cumsum([0, *(len(view.footprint.shares) for view in taken)])
    patches = [
        view.footprint.patches + start for view, start in zip(taken, first_element, strict=False)
    ]
    points = [
        transform(
            pose_of(places.xy[stand], heading) @ views.world.T_base_cam, view.footprint.points_cam
        )[:, :2]
        for view, (stand, heading) in zip(taken, stations, strict=True)
    ]
    xy = places.xy[[stand for stand, _ in stations]]
    offsets = np.concatenate(points) - np.repeat(xy, np.diff(first), axis=0)
    house = views.world.house
    true = {goal: true_places(house, goal) for goal in GOALS}
    return ShownPlaces(
        np.concatenate([view.elements.embeddings for view in taken]),
        np.concatenate(patches).astype(np.int64),
        np.linalg.norm(offsets, axis=1).astype(np.float32),
        np.concatenate([view.footprint.shares for view in taken]),
        np.floor(np.concatenate(points) / PLACE).astype(np.int64),
        first,
        np.array([stand for stand, _ in stations]),
        xy,
        np.array([heading for _, heading in stations]),
        {goal: found for goal, found in true.items() if found[0].any()},
    )


def seen_in(
    shown: ShownPlaces,
    encoder: TextEncoder,
    background: Background,
    log_odds: tuple[float, float] | None,
    phrasings: Sequence[str] = BARE,
) -> SeenHome:
    """Ask the views for every goal that the home has.

    Args:
        shown: What they show.
        encoder: Embeds the goals.
        background: As that encoder embeds it.
        log_odds: Scale and bias of the encoder, or those that are to be used; None for none.
        phrasings: Sentences that together stand for a goal.
    """
    statistics = background.statistics(shown.embeddings)
    asked = list(
        dict.fromkeys([*shown.true, *(each for goal in shown.true for each in other_rooms(goal))])
    )
    found, likeness = {}, {}
    for goal, text in zip(asked, embed_phrased(encoder, asked, phrasings), strict=True):
        question = Query(text, log_odds)
        scores = question.scores(shown.embeddings, statistics)
        tail = question.tail(background.pictures)
        found[goal] = features(scores, shown.patches, shown.ranges, shown.shares, tail)
        likeness[goal] = scores[shown.patches[:, 2], 1]
    there = {goal: are_true(shown.places, *true) for goal, true in shown.true.items()}
    return SeenHome(shown, found, there, likeness)
