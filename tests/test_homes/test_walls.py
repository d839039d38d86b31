from pathlib import Path

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.stairs import Stairs
from sim_stubs.homes.floor_plan.walls import TRIM, Opening, RectangularRoom, build_structure
from sim_stubs.homes.geometry.occupancy_slice import grid_around, occupied, reachable
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.homes.textures.surfaces import FAMILIES, finish, members

GREY = (0.5, 0.5, 0.5)
EAST = RectangularRoom("east", 2.1, 0, 4, 3, GREY, 1.0, GREY)
WEST = RectangularRoom("west", 0, 0, 2, 3, GREY, 1.0, GREY)
DOWN = Stairs("down", "straight", 1.0, 1.5, "S", 0.9, 1.6)


def ways_between(openings):
    structure = triangles(build_structure((WEST, EAST), openings))
    grid = grid_around(structure)
    free = ~occupied(structure, 0.1, 2.0, grid)
    return bool(reachable(free, grid.cell_of(1, 1))[grid.cell_of(3, 1)])


def floor_area(parts):
    corners = triangles(parts)
    flat = np.abs(corners[..., 2]).max(axis=1) < 1e-6
    a, b = corners[flat, 1] - corners[flat, 0], corners[flat, 2] - corners[flat, 0]
    return np.cross(a, b)[:, 2].clip(0).sum() / 2


def test_a_wall_separates_rooms_until_a_doorway_joins_them():
    assert not ways_between(())
    assert ways_between((Opening(2, 1, 2.1, 1.9),))
    assert not ways_between((Opening(2, 1, 2.1, 1.9, sill=0.95),))
    assert not ways_between((Opening(2, 1, 2.1, 1.9, pane=GREY),))
    assert not ways_between((Opening(2, 1, 2.1, 1.9, pane=GREY, kind="door"),))


def test_walls_face_into_their_room():
    corners = triangles(build_structure((WEST,), ()))
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    upright = np.ptp(corners[..., 2], axis=1) > 0.2
    inwards = (1, 1.5, 1.25) - corners.mean(axis=1)
    assert upright.sum() > 40
    assert ((normals * inwards).sum(axis=1) > 0)[upright].all()


def test_a_passage_is_as_wide_as_the_wall_and_has_no_frame():
    framed = build_structure((WEST, EAST), (Opening(2, 0.5, 2.1, 2.5),))
    open_up = (Opening(2, 0.0, 2.1, 3.0, head=2.5),)
    assert ways_between(open_up)
    through = triangles(build_structure((WEST, EAST), open_up))
    in_the_way = ((np.abs(through[..., 0] - 2.05) < 0.2) & (through[..., 2] > 0.2)).all(axis=1)
    normals = np.cross(through[:, 1] - through[:, 0], through[:, 2] - through[:, 0])
    assert not (np.abs(normals[in_the_way, 0]) > 1e-6).any()
    reach = [part.vertices[:, 2].max() for part in framed if np.allclose(part.rgba[:3], TRIM)]
    assert max(reach) > 2.0


def test_stairs_downwards_leave_a_hole_in_the_floor_and_those_upwards_do_not():
    whole = floor_area(build_structure((WEST,), ()))
    assert whole == pytest.approx(6.0, abs=0.1)
    hole = whole - floor_area(build_structure((WEST,), (), stairs=DOWN))
    assert hole == pytest.approx(0.9 * 1.6, abs=1e-4)
    up = Stairs("up", "straight", 1.0, 1.5, "S", 0.9, 1.6)
    assert floor_area(build_structure((WEST,), (), stairs=up)) == pytest.approx(whole)


def test_the_floor_s_pattern_goes_on_around_the_hole():
    for stairs in (None, DOWN):
        for part in build_structure((WEST,), (), stairs=stairs):
            on_floor = (np.abs(part.vertices[:, 2]) < 1e-6) & (part.normals[:, 2] > 0.99)
            east_south = part.vertices[on_floor, :2] * (1, -1)
            assert np.allclose(part.texcoords[on_floor], east_south, atol=1e-5)


def test_a_wall_s_pattern_goes_on_around_a_window():
    wall = (0.3, 0.4, 0.5)
    room = RectangularRoom("west", 0, 0, 2, 3, GREY, 1.0, wall, wall_tile=2.0)
    hole = Opening(0.5, 3, 1.2, 3.2, 0.9, 2.0, GREY, "window")
    (part,) = (p for p in build_structure((room,), (hole,)) if np.allclose(p.rgba[:3], wall))
    north = np.abs(part.vertices[:, 1] - 3) < 1e-6
    north &= np.abs(part.normals[:, 1]) > 0.9
    expected = np.column_stack([part.vertices[north, 0], -part.vertices[north, 2]]) / 2.0
    assert north.sum() > 20
    assert np.allclose(part.texcoords[north], expected, atol=1e-5)


def test_no_part_reaches_over_two_rooms():
    openings = (Opening(2, 1, 2.1, 1.9), Opening(0.5, 3, 1.2, 3.2, 0.9, 2.0, GREY, "window"))
    for part in build_structure((WEST, EAST), openings):
        x = part.vertices[:, 0]
        assert x.max() < 2.11 or x.min() > 1.99


def test_the_view_hangs_at_the_outer_face_of_a_window():
    view = (0.1, 0.2, 0.9)
    for y, outer in ((3.0, 3.2), (-0.2, -0.2)):
        hole = Opening(0.5, y, 1.2, y + 0.2, 0.9, 2.0, view, "window")
        parts = build_structure((WEST,), (hole,))
        (pane,) = (part for part in parts if np.allclose(part.rgba[:3], view))
        assert np.allclose(pane.vertices[:, 1], outer, atol=0.01)
        # Pictures are upright: their rows are counted from the top.
        high = pane.vertices[:, 2] > pane.vertices[:, 2].mean()
        assert pane.texcoords[high, 1].max() < pane.texcoords[~high, 1].min() + 1e-6


@pytest.mark.parametrize("family", FAMILIES)
def test_each_surface_is_on_one_side_of_the_split(family):
    training, held_out = members(family, False), members(family, True)
    assert sorted(training + held_out) == list(range(FAMILIES[family].count))
    assert 0.6 < len(training) / FAMILIES[family].count < 0.8


def test_no_picture_or_colour_is_on_both_sides():
    for family in ("paint", "fitted carpet", "stair metal"):
        looks = [
            {finish(family, np.random.default_rng(seed), held_out).surface for seed in range(40)}
            for held_out in (False, True)
        ]
        assert len(looks[0]) > 5
        assert not looks[0] & looks[1]


def test_a_surface_is_drawn_again_from_its_name_alone():
    first = finish("tiles", np.random.default_rng(3), False)
    again = finish("tiles", np.random.default_rng(3), False)
    assert first == again
    assert isinstance(first.surface, Path)
    assert first.surface.exists()
