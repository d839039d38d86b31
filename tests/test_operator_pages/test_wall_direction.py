"""The map is turned to the walls, and stays as it is while it grows."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.boxes import askew_room
from tests.helpers.served import step
from vizbot.core.types import OccupancyGrid
from vizbot.operator.figures.wall_direction import MapTurn, wall_direction

DEGREE = np.pi / 180


def grid_of(occupied):
    return OccupancyGrid(np.where(occupied, 0.9, 0.1).astype(np.float32), 0.05, np.zeros(2))


def cluttered(grid, seed, share):
    """The grid with obstacles strewn over it."""
    strewn = np.random.default_rng(seed).random(grid.occupancy.shape) < share
    known = grid.occupancy != 0.5
    return replace(grid, occupancy=np.where(strewn & known, 0.9, grid.occupancy))


def shown(grid, map_number=0):
    return replace(step(0), grid=grid, map_number=map_number)


@given(st.floats(-44.0, 44.0), st.integers(0, 9))
@settings(max_examples=30)
def test_the_direction_of_walls_is_found_among_furniture(degrees, seed):
    found = wall_direction(cluttered(askew_room(degrees * DEGREE), seed, 0.05))
    assert found == pytest.approx(degrees * DEGREE, abs=1.0 * DEGREE)


@pytest.mark.parametrize("degrees", [-45, 45, 90, 200])
def test_it_is_the_one_nearest_to_the_axes(degrees):
    found = wall_direction(askew_room(degrees * DEGREE))
    assert -45.1 * DEGREE < found < 45.1 * DEGREE
    assert abs((found - degrees * DEGREE + np.pi / 4) % (np.pi / 2) - np.pi / 4) < 0.6 * DEGREE


def test_without_walls_there_is_none():
    assert wall_direction(grid_of(np.zeros((100, 100)))) is None
    few = np.zeros((100, 100))
    few[20, :80] = 1
    assert wall_direction(grid_of(few)) is None
    assert wall_direction(grid_of(np.random.default_rng(3).random((200, 200)) < 0.1)) is None
    rows, cols = np.mgrid[:200, :200] - 100
    assert wall_direction(grid_of(np.abs(np.hypot(rows, cols) - 70) < 2)) is None


def test_it_takes_no_longer_in_a_large_building():
    rows, cols = np.mgrid[:2000, :2000]
    rotated = (cols * np.cos(0.3) + rows * np.sin(0.3)) % 60 < 2
    assert wall_direction(grid_of(rotated)) == pytest.approx(0.3, abs=0.6 * DEGREE)


def test_a_map_that_grows_is_turned_once():
    turn, turns = MapTurn(), []
    for seen in np.linspace(0.02, 1.0, 60):
        turns.append(turn.turn_at(shown(cluttered(askew_room(0.4, seen), 0, 0.02))))
    assert turn.turn_at(shown(grid_of(np.zeros((9, 9))))) == turns[-1]
    assert turns[-1] == pytest.approx(0.4, abs=1.6 * DEGREE)
    changes = np.abs(np.diff(turns))
    assert np.count_nonzero(changes) <= 2
    assert (changes[changes > 0] > 1.5 * DEGREE).all()


def test_a_turn_of_a_quarter_is_none():
    turn = MapTurn()
    before = turn.turn_at(shown(askew_room(44 * DEGREE, 0.4)))
    after = turn.turn_at(shown(askew_room(47 * DEGREE)))
    assert before == pytest.approx(44 * DEGREE, abs=DEGREE)
    assert after == pytest.approx(47 * DEGREE, abs=DEGREE)


def test_what_was_decided_stays_where_little_is_new():
    turn = MapTurn()
    before = turn.turn_at(shown(askew_room(0.3)))
    assert turn.turn_at(shown(askew_room(0.6))) == before


def test_another_map_is_turned_anew_and_a_step_of_the_one_before_changes_nothing():
    turn = MapTurn()
    first, second = shown(askew_room(0.3)), shown(askew_room(-0.2), 1)
    assert turn.turn_at(first) == pytest.approx(0.3, abs=DEGREE)
    assert turn.turn_at(second) == pytest.approx(-0.2, abs=DEGREE)
    assert turn.turn_at(first) == 0.0
    assert turn.turn_at(second) == pytest.approx(-0.2, abs=DEGREE)
