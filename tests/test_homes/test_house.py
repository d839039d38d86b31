from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_stubs.homes.floor_plan.walls import Opening, RectangularRoom, build_structure
from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.geometry.house import Instance
from sim_stubs.homes.geometry.occupancy_slice import grid_around, occupied, reachable
from sim_stubs.homes.geometry.solids import triangles

GREY = (0.5, 0.5, 0.5)
EAST = RectangularRoom("east", 2.1, 0, 4, 3, GREY, 1.0, GREY)
WEST = RectangularRoom("west", 0, 0, 2, 3, GREY, 1.0, GREY)
STOOL = procedural.piece("chair", np.random.default_rng(0))


def ways_between(openings):
    structure = triangles(build_structure((WEST, EAST), openings))
    grid = grid_around(structure)
    free = ~occupied(structure, 0.1, 2.0, grid)
    return bool(reachable(free, grid.cell_of(1, 1))[grid.cell_of(3, 1)])


def test_a_wall_separates_rooms_until_a_doorway_joins_them():
    assert not ways_between(())
    assert ways_between((Opening(2, 1, 2.1, 1.9),))
    assert not ways_between((Opening(2, 1, 2.1, 1.9, sill=0.95),))
    assert not ways_between((Opening(2, 1, 2.1, 1.9, pane=GREY),))


def test_walls_face_into_their_room():
    corners = triangles(build_structure((WEST,), ()))
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    upright = np.ptp(corners[..., 2], axis=1) > 0.2
    inwards = (1, 1.5, 1.25) - corners.mean(axis=1)
    assert upright.sum() > 40
    assert ((normals * inwards).sum(axis=1) > 0)[upright].all()


@given(x=st.floats(-5, 5), y=st.floats(-5, 5), yaw=st.floats(-pi, pi))
def test_the_footprint_encloses_the_piece(x, y, yaw):
    instance = Instance("chair#1", STOOL, x, y, yaw)
    edges = np.roll(instance.footprint, -1, axis=0) - instance.footprint
    points = triangles(instance.parts())[..., :2].reshape(-1, 2)
    offsets = points[:, None] - instance.footprint
    left_of = edges[:, 0] * offsets[..., 1] - edges[:, 1] * offsets[..., 0]
    assert left_of.min() > -1e-4
    assert instance.footprint.mean(axis=0) == pytest.approx([x, y])
