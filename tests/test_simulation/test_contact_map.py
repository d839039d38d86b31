from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.solids import box, flat_panel
from sim_stubs.world.body import Outline
from sim_stubs.world.contact_map import CENTRE, ContactMap

GREY = (0.6, 0.6, 0.6)
ROOM = RectangularRoom("room", 0, 0, 6, 4, GREY, 1.0, GREY)
BODY = Outline(
    radius=0.175, wheel_base=0.235, mast_height=0.65, mast_forward=0.05, mast_radius=0.06
)


def touch(*parts, structure=None):
    structure = build_structure((ROOM,), ()) if structure is None else structure
    house = House((ROOM.room,), (*structure, *parts), (), np.zeros((0, 3)), (1.0, 1.0, 0.0))
    return ContactMap(house, BODY)


@pytest.fixture(scope="module")
def round_post():
    return touch(box((3.0, 2.0, 0), (0.02, 0.02, 0.3), GREY))


@given(bearing=st.floats(-pi, pi), yaw=st.floats(-pi, pi))
def test_the_bumper_tells_the_side_of_what_it_touches(round_post, bearing, yaw):
    reach = 0.175 + 0.005
    x, y = 3.0 - reach * np.cos(bearing + yaw), 2.0 - reach * np.sin(bearing + yaw)
    felt = round_post.contacts(x, y, yaw)
    post = 0.13  # half the diagonal of the post and of a cell, 21 mm, seen from 180 mm [rad]
    if CENTRE + post < bearing < pi / 2 - post:
        assert (felt.bump_left, felt.bump_right) == (True, False)
    if -pi / 2 + post < bearing < -CENTRE - post:
        assert (felt.bump_left, felt.bump_right) == (False, True)
    if abs(bearing) < np.radians(5):
        assert felt.bump_left
        assert felt.bump_right
    if abs(bearing) > pi / 2 + post:
        assert (felt.bump_left, felt.bump_right) == (False, False)


def test_the_gap_to_a_wall_is_exact_to_a_cell(round_post):
    for x in np.linspace(0.3, 1.0, 15):
        # The skirting is 12 mm thick.
        assert round_post.gap(x, 2.0, pi) == pytest.approx(x - 0.012 - 0.175, abs=0.011)


def test_what_is_between_base_and_mast_stops_the_layer_it_is_in():
    low = touch(box((3.0, 2.0, 0.03), (0.4, 0.4, 0.04), GREY))
    high = touch(box((3.0, 2.0, 0.3), (0.4, 0.4, 0.04), GREY))
    above = touch(box((3.0, 2.0, 0.8), (0.4, 0.4, 0.04), GREY))
    threshold = touch(box((3.0, 2.0, 0.0), (0.4, 0.4, 0.015), GREY))
    place = 2.8 - 0.15, 2.0, 0.0  # the base's rim reaches under, the mast does not
    assert low.gap(*place) < 0 < high.gap(*place)
    assert high.gap(2.8 - 0.1, 2.0, 0.0) < 0
    assert above.gap(3.0, 2.0, 0.0) > 1
    assert threshold.gap(3.0, 2.0, 0.0) > 1


def test_a_step_down_is_a_cliff_on_the_side_where_it_is():
    # The floor ends at x = 3, and 18 cm below it a stair goes on.
    ground = flat_panel((0, 0, 0), (3, 0, 0), (0, 4, 0), GREY)
    stair = flat_panel((3, 0, -0.18), (0.3, 0, 0), (0, 4, 0), GREY)
    edge = touch(structure=(ground, stair))
    assert edge.contacts(2.7, 2.0, 0.0).cliffs == (False, False, False, False)
    assert edge.contacts(2.88, 2.0, 0.0).cliffs == (False, True, True, False)
    assert edge.contacts(2.88, 2.0, -pi / 2).cliffs == (True, False, False, False)
    assert edge.contacts(2.88, 2.0, pi / 2).cliffs == (False, False, False, True)
    assert edge.contacts(2.95, 2.0, pi / 2).wheel_drops == (False, True)


def test_the_robot_can_stand_where_it_touches_nothing_and_does_not_hang_over():
    pit = House(
        (ROOM.room,),
        (
            flat_panel((0, 0, 0), (3, 0, 0), (0, 4, 0), GREY),
            box((1.0, 2.0, 0), (0.4, 0.4, 1), GREY),
        ),
        (),
        np.zeros((0, 3)),
        (2.0, 2.0, 0.0),
    )
    contact_map = ContactMap(pit, BODY)
    free, grid = contact_map.free()
    assert grid.resolution == pytest.approx(0.05)
    rows, columns = np.nonzero(free)
    standing = grid.pixels_to_xy(np.column_stack([columns, rows]))
    for x, y in standing[::7]:
        for yaw in (0.0, 2.0, 4.0):
            assert contact_map.gap(x, y, yaw) > -1e-6
            assert not any(contact_map.contacts(x, y, yaw).cliffs)
    assert standing[:, 0].max() == pytest.approx(3 - 0.175, abs=0.06)
    assert free.sum() * 0.05**2 == pytest.approx(2.65 * 3.65 - 0.75**2 + 0.04, abs=0.35)
