"""Obstacles around the robot laid over a known map."""

import numpy as np
import pytest

from mapping.relocalisation.config import ScanMatchConfig
from mapping.relocalisation.scan_matching import agreement_at, match_scan
from vizbot.core.geometry import invert, planar, rotation_angle
from vizbot.core.types import SE3, OccupancyGrid

pytestmark = pytest.mark.slow

CONFIG = ScanMatchConfig()
WALLS = [(-3.0, -2.0, 3.0, -2.0), (3.0, -2.0, 3.0, 2.0), (3.0, 2.0, -3.0, 2.0)]
"""Of a room that is open at its left."""
SHELVES = [(-1.0, 0.5, -1.0, 2.0), (1.5, -2.0, 1.5, -0.8)]


def room(
    T_grid_room: SE3, pieces: list[tuple[float, float, float, float]], reach: float
) -> OccupancyGrid:
    """A room in a grid whose cells are free wherever they are no obstacle, `reach` around."""
    size = round(2 * reach / 0.05)
    grid = OccupancyGrid(np.full((size, size), 0.1, np.float32), 0.05, np.array([-reach, -reach]))
    along = np.linspace(0.0, 1.0, 400)[:, None]
    for x0, y0, x1, y1 in pieces:
        xy = np.array([x0, y0]) * (1 - along) + np.array([x1, y1]) * along
        in_grid = xy @ T_grid_room[:2, :2].T + T_grid_room[:2, 3]
        cells = grid.to_cells(in_grid)
        rows, cols = cells[grid.contains(cells)].T
        grid.occupancy[rows, cols] = 0.95
    return grid


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (1.13, 0.77, 2.1), (-1.9, -1.21, -0.6)])
def test_a_room_is_found_in_its_map_to_within_a_cell(pose: tuple[float, float, float]) -> None:
    T_room_robot = planar(*pose)
    known = room(np.eye(4), WALLS + SHELVES, 6.0)
    found = match_scan(room(invert(T_room_robot), WALLS + SHELVES, 4.0), known, CONFIG)
    assert found is not None
    off = invert(T_room_robot) @ found.T_map_around
    assert np.linalg.norm(off[:3, 3]) < 0.06
    assert rotation_angle(off) < 0.03
    assert found.agreement > 0.8
    assert found.rival < 0.7 * found.agreement


def test_a_room_that_looks_the_same_turned_round_has_a_rival() -> None:
    closed = [*WALLS, (-3.0, 2.0, -3.0, -2.0)]
    found = match_scan(
        room(planar(0.4, 0.3, 0.2), closed, 5.0), room(np.eye(4), closed, 6.0), CONFIG
    )
    assert found is not None
    assert found.rival > 0.9 * found.agreement


def test_what_is_not_on_the_map_agrees_with_nothing() -> None:
    known = room(np.eye(4), WALLS, 6.0)
    elsewhere = [(x, y, x + 0.6, y) for x in (-2.0, 0.0, 2.0) for y in (-2.5, -0.5, 0.7, 1.8)]
    found = match_scan(room(np.eye(4), elsewhere, 4.0), known, CONFIG)
    assert found is not None
    assert found.agreement < 0.6


def test_agreement_is_high_where_the_robot_is_and_low_beside_it() -> None:
    T_room_robot = planar(0.5, -0.4, 1.0)
    known = room(np.eye(4), WALLS + SHELVES, 6.0)
    around = room(invert(T_room_robot), WALLS + SHELVES, 4.0)
    right = agreement_at(T_room_robot, around, known, CONFIG)
    wrong = agreement_at(T_room_robot @ planar(0.5, 0.3, 0.2), around, known, CONFIG)
    assert right is not None and wrong is not None
    assert right > 0.8
    assert wrong < 0.3


EMPTY = OccupancyGrid(np.full((64, 64), 0.5, np.float32), 0.05, np.array([-1.6, -1.6]))


def test_without_obstacles_around_there_is_no_match() -> None:
    known = room(np.eye(4), WALLS, 6.0)
    assert match_scan(EMPTY, known, CONFIG) is None
    assert agreement_at(np.eye(4), EMPTY, known, CONFIG) is None


def test_a_map_without_anything_agrees_with_nothing() -> None:
    empty = OccupancyGrid(np.full((64, 64), 0.5, np.float32), 0.05, np.array([-1.6, -1.6]))
    found = match_scan(room(np.eye(4), WALLS, 4.0), empty, CONFIG)
    assert found is not None
    assert found.agreement < 1e-6
