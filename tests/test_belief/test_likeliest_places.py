"""The places that answer a question."""

from dataclasses import replace

import numpy as np
import pytest

from mapping.clip.mapped_frames import MappedFrame
from mapping.clip.places.belief import PlaceBelief
from mapping.clip.places.footprint import PLACE
from mapping.clip.places.likeliest_places import belief_of_map, likeliest_places
from mapping.clip.places.place_rows import PlaceMap
from mapping.clip.scores import NO_PICTURES
from sim_stubs.world.world_plan import D435I_COLOUR
from tests.test_belief.test_belief import ASKED, WEIGHTS, camera, shown
from vizbot.core.geometry import planar

SEEN = [(row, column) for row in (1, 2, 3) for column in (1, 2, 3)] + [(2, 10)]
"""Row and column of places."""
SIMPLY_ASKED = replace(ASKED, weights=WEIGHTS)


def ask(views, likeness, poses=None, first_xy=None):
    embeddings = np.array([[each, np.sqrt(1 - each**2)] for each in likeness], np.float32)
    embeddings = embeddings.reshape(-1, 2)
    statistics = np.tile(np.float32([0.1, 0.1]), (len(likeness), 1))
    poses = poses or {0: np.eye(4)}
    belief = belief_of_map(views, poses, embeddings, statistics, NO_PICTURES, SIMPLY_ASKED)
    return likeliest_places(belief, views, poses, embeddings, SIMPLY_ASKED, first_xy)


def look(views, T_map_cam, footprint, first_element):
    """Add a picture."""
    views.add(
        MappedFrame(len(views.frames), 0, T_map_cam, 0.0), T_map_cam, footprint, first_element
    )


@pytest.fixture
def two_things():
    """A map of one thing that looks like what is asked for, and of one that does not."""
    views = PlaceMap(D435I_COLOUR)
    look(views, camera(0, 0.1), shown(1.1), 0)
    look(views, camera(0, 3.1), shown(1.1), 1)
    return views


def test_the_likeliest_place_comes_first_with_the_element_that_shows_it(two_things):
    first, second = ask(two_things, [0.1, 0.9])
    assert (first.element, second.element) == (1, 0)
    assert first.probability > 0.8 and second.probability < 0.2
    assert first.position == pytest.approx([1.1, 3.1, 0.0], abs=1e-5)


def test_where_the_robot_has_arrived_comes_first(two_things):
    first, second = ask(two_things, [0.1, 0.9], first_xy=np.array([1.2, 0.0]))
    assert (first.element, second.element) == (0, 1)
    assert first.probability < 0.2 < 0.8 < second.probability


def test_places_beside_one_another_are_one_answer():
    views = PlaceMap(D435I_COLOUR)
    look(views, camera(0, 0.1), shown(1.1, 1.3, 1.6, 2.1), 0)
    positions = np.array([place.position for place in ask(views, [0.9])])
    away = np.linalg.norm(positions[:, None, :2] - positions[None, :, :2], axis=2)
    assert len(positions) == 2 and away[0, 1] > 0.45


def test_the_middle_of_a_thing_answers_and_not_a_likelier_place_at_its_edge():
    probabilities = np.zeros((5, 14))
    probabilities[1:4, 1:4], probabilities[1, 1], probabilities[2, 10] = 0.8, 0.85, 0.9
    views = PlaceMap(D435I_COLOUR)
    shown_at = [((column + 0.5) * PLACE, (row + 0.5) * PLACE) for row, column in SEEN]
    for x, y in shown_at:
        look(views, camera(0, y), shown(x), 0)
    seen = np.zeros(probabilities.shape, bool)
    seen[tuple(np.transpose(SEEN))] = True
    nothing = np.zeros(probabilities.shape, np.float32)
    seen_from = np.zeros((5, 14, 2))
    belief = PlaceBelief(np.zeros(2, np.int64), probabilities, nothing, seen, seen_from, nothing)
    embeddings = np.ones((len(SEEN), 2), np.float32)
    first, second = likeliest_places(belief, views, {0: np.eye(4)}, embeddings, SIMPLY_ASKED)[:2]
    assert (first.position[:2] / PLACE - 0.5).round().tolist() == [10, 2], "the likeliest first"
    assert (second.position[:2] / PLACE - 0.5).round().tolist() == [2, 2]
    assert first.probability == pytest.approx(0.9) and second.probability == pytest.approx(0.8)


def test_answers_move_with_the_keyframes(two_things):
    moved = planar(1.0, -2.0, 0.5)
    place, _ = ask(two_things, [0.1, 0.9], {0: moved})
    assert place.position == pytest.approx((moved @ [1.1, 3.1, 0.0, 1.0])[:3], abs=1e-5)


def test_an_empty_map_has_no_places():
    assert ask(PlaceMap(D435I_COLOUR), []) == []
