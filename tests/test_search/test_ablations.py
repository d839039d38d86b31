"""The search without one of its parts: that part alone is gone."""

import numpy as np
import pytest

from benchmarks.ablations.ablation import ABLATIONS
from mapping.clip.places.evidence import EMBEDDED_FILE, fitted_weights
from mapping.clip.places.place_views import PlaceViews
from mapping.clip.scores import Query
from nav.frontier import FrontierSearch
from tests.test_search.test_belief_search import CONFIG, SOFA, believed, room
from vizbot.core.geometry import planar
from vizbot.objectnav.belief_search import BeliefSearch
from vizbot.objectnav.search_parts import ALL_PARTS, SearchParts


def hall():
    """A hall of 8 m by 4 m whose west and east ends are unseen, and its frontiers."""
    grid, frontiers = room(width=8.0)
    seen = frontiers.explored.mask_on(grid)
    seen[:, :45] = seen[:, -45:] = False
    return grid, frontiers


def belief(likeness=0.0, at=None):
    """A belief on the plan of the hall."""
    return believed(at, likeness, (18, 34), (0.0, 0.0))


def both(part):
    """The whole search and the one without a part, each in a hall of its own."""
    for parts in (ALL_PARTS, ABLATIONS[part]):
        grid, frontiers = hall()
        yield grid, BeliefSearch(CONFIG, frontiers, parts)


def test_what_looks_alike_near_a_frontier_draws_the_whole_search_alone():
    likeness = np.zeros((18, 34), np.float32)
    likeness[:, 20:] = 3.0  # in the east, which is farther away
    goals = []
    for grid, search in both("likeness at frontiers"):
        decision = search.go(SOFA, belief(likeness), grid, planar(3.6, 2.0, np.pi / 2))
        goals.append(decision.navigation.goal_xy[0])
    assert goals[0] > 4.0 > goals[1]


def test_each_takes_one_part_away():
    for name, parts in ABLATIONS.items():
        changed = [
            part for part in SearchParts.__slots__
            if getattr(parts, part) != getattr(ALL_PARTS, part)
        ]  # fmt: skip
        assert len(changed) == 1, name


def test_without_the_z_score_it_weighs_nothing():
    weights = fitted_weights(ABLATIONS["z-score"].weights)
    for of_views in (weights.near, weights.far):
        assert (np.flatnonzero(of_views == 0.0) == range(7, 14)).all()
    assert weights.join.all()


def test_without_joined_views_only_the_best_of_a_place_count():
    frontiers = FrontierSearch(CONFIG.frontier)
    search = BeliefSearch(CONFIG, frontiers, ABLATIONS["joined views"])
    whole, alone = map(fitted_weights, (EMBEDDED_FILE, ABLATIONS["joined views"].weights))
    for one, other in ((alone.near, whole.near), (alone.far, whole.far)):
        assert one == pytest.approx(other, abs=0.05)  # pictures differ a bit between machines
    odds = []
    for times in (1, 5):  # the same again, from other spots, says nothing more
        views = PlaceViews()
        views.add(
            np.zeros((times, 2), np.int64), np.full(times, 2.0, np.float32),
            np.zeros(times, np.float32), np.ones(times, np.float32), np.arange(times),
            np.zeros((times, 2), np.float32), np.zeros(times, np.float32),
        )  # fmt: skip
        odds.append(views.features(room=False)[0, 0] @ np.stack([whole.join, alone.join], axis=1))
    assert odds[0][1] == pytest.approx(odds[1][1]) and odds[0][0] < odds[1][0]
    assert search.belief_of(SOFA, Query(SOFA.embedding, (1.0, 0.0)))._weights is alone
