"""Rooms on the map: parts of the plan that most probably show each of them."""

import numpy as np
import pytest

from mapping.clip.places.belief import PlaceBelief
from vizbot.operator.session.household import HouseholdBeliefs
from vizbot.operator.session.room_areas import RoomAreas, room_areas


def belief(probabilities, low=(0, 0)):
    seen = np.ones(probabilities.shape, np.bool_)
    return PlaceBelief(
        np.array(low),
        probabilities,
        np.zeros(seen.shape, np.float32),
        seen,
        np.zeros((*seen.shape, 2)),
        np.zeros(seen.shape, np.float32),
    )


def plan(*patches, size=(40, 60)):
    """Probabilities of places: 0 but in patches of rows, columns and a value."""
    probabilities = np.zeros(size)
    for rows, cols, value in patches:
        probabilities[slice(*rows), slice(*cols)] = value
    return probabilities


@pytest.mark.slow
def test_a_place_belongs_to_the_room_that_it_most_probably_shows():
    kitchen = belief(plan(((0, 10), (0, 20), 0.9), ((0, 10), (20, 30), 0.6)), (4, -8))
    bedroom = belief(plan(((0, 10), (16, 40), 0.7)), (4, -8))
    first, second = room_areas({"bedroom": bedroom, "kitchen": kitchen}, 0.5)
    assert (first.name, second.name) == ("bedroom", "kitchen")
    np.testing.assert_allclose(first.position, [(4 + 30) * 0.25, (-8 + 5) * 0.25], atol=0.2)
    np.testing.assert_allclose(second.position, [(4 + 10) * 0.25, (-8 + 5) * 0.25], atol=0.2)


def test_rooms_of_one_kind_that_lie_apart_are_several():
    bedrooms = plan(((0, 6), (0, 8), 0.8), ((0, 6), (20, 30), 0.8), ((0, 6), (33, 36), 0.8))
    found = room_areas({"bedroom": belief(bedrooms)}, 0.5)
    assert [one.name for one in found] == ["bedroom", "bedroom"]
    assert found[0].position[0] > found[1].position[0]


def test_what_is_small_or_improbable_is_no_room():
    study = plan(((0, 4), (0, 5), 0.9), ((20, 40), (0, 40), 0.5))
    assert room_areas({"study": belief(study)}, 0.5) == []
    assert room_areas({"study": belief(np.zeros((0, 0)))}, 0.5) == []


def test_the_name_stands_on_a_place_of_the_room():
    ring = plan(((0, 30), (0, 30), 0.9), ((5, 25), (5, 25), 0.0))
    [room] = room_areas({"hallway": belief(ring)}, 0.5)
    column, row = np.floor(np.array(room.position) / 0.25).astype(int)
    assert ring[row, column] == 0.9


@pytest.mark.parametrize(("number", "seconds", "asked"), [(0, 9.0, 1), (0, 10.0, 2), (1, 1.0, 2)])
def test_an_answer_serves_everybody_for_a_while_but_not_on_another_map(number, seconds, asked):
    times, maps, reads = iter([100.0, 100.0 + seconds]), iter([0, number]), []
    areas = RoomAreas(HouseholdBeliefs(), lambda: next(times))

    def whole():
        reads.append(True)
        return None, next(maps), None

    assert areas.found(0, whole) == [] and areas.found(number, whole) == []
    assert len(reads) == asked
