from math import pi

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.walls import Opening, RectangularRoom, build_structure
from sim_stubs.homes.furniture.procedural import piece
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.solids import Piece, box
from sim_stubs.scoring.shortest_path import nearest_path_length
from sim_stubs.scoring.success import GOALS, IN_COCO, goals_of, is_visible
from sim_stubs.world.body import WorldConfig
from sim_stubs.world.world import World
from vizbot.core.geometry import planar, yaw_of

GREY = (0.6, 0.6, 0.6)
ROOMS = (
    RectangularRoom("hallway", 0, 0, 6, 3, GREY, 1.0, GREY),
    RectangularRoom("kitchen", 6.1, 0, 10, 3, GREY, 1.0, GREY),
    RectangularRoom("study", 0, 3.1, 10, 6, GREY, 1.0, GREY),
)
DOORWAY = Opening(6.0, 2.0, 6.1, 2.9)


def thing(label, x, y, yaw=0.0, elevation=0.0):
    return Instance(f"{label}#1", piece(label, np.random.default_rng(0)), x, y, yaw, elevation)


# Nothing leads into the study.
HOME = House(
    rooms=tuple(room.room for room in ROOMS),
    structure=(
        *build_structure(ROOMS, (DOORWAY,)),
        box((2.5, 0.6, 0), (0.05, 1.2, 1.5), GREY),  # a screen
    ),
    instances=(
        thing("toilet", 5.0, 4.5),
        thing("sofa", 8.0, 0.5),
        thing("washing machine", 9.6, 2.5, -pi / 2),
        thing("refrigerator", 0.4, 0.4),
    ),
    lights=np.array([[3.0, 1.5, 2.3], [8.0, 1.5, 2.3]]),
    start=(1.0, 2.4, 0.0),
)


@pytest.fixture(scope="module")
def world():
    with World(HOME, WorldConfig(wheel_scale_noise=0.0, slip_noise=0.0)) as world:
        yield world


def test_the_goals_are_the_paper_s():
    assert len(GOALS) == len(set(GOALS)) == 16
    assert len(IN_COCO) == 8
    assert set(IN_COCO) < set(GOALS)


def test_goals_exist_where_the_robot_can_see_them_and_rooms_by_their_name(world):
    before = world.T_world_base
    # Not the toilet, behind walls without a door; the washing machine is laundry.
    assert goals_of(world) == ("sofa", "refrigerator", "laundry", "kitchen", "hallway")
    assert np.array_equal(world.T_world_base, before)


def behind_a_screen(gap):
    """A small room with a toilet at the end of an alley too narrow for the robot, 0.3 m wide."""
    room = RectangularRoom("study", 0, 0, 3.2, 2, GREY, 1.0, GREY)
    toilet = Piece("toilet", "", np.array([0.2, 0.2, 0.4]),
                   (box((0, 0, 0), (0.2, 0.2, 0.4), GREY),), "")  # fmt: skip
    screens = (
        box((2.25, 0.325, 0), (1.9, 0.05, 1.6), GREY),
        box((1.3, 0.15 + gap / 2, 0), (0.05, 0.3 - gap, 1.6), GREY),
    )
    return House(
        rooms=(room.room,),
        structure=(*build_structure((room,), ()), *screens),
        instances=(Instance("toilet#1", toilet, 3.0, 0.15, 0.0),),
        lights=np.array([[1.5, 1.0, 2.3]]),
        start=(0.5, 1.5, 0.0),
    )


@pytest.mark.parametrize(("gap", "goals"), [(0.0, ()), (0.2, ("toilet",))])
def test_what_is_seen_from_one_corner_alone_is_a_goal_and_what_is_from_nowhere_is_not(gap, goals):
    with World(behind_a_screen(gap), WorldConfig()) as world:
        assert goals_of(world) == goals


def with_a_tv_at(height):
    """A room of 5 m by 3 m with a small television on its east wall, its foot at a height [m]."""
    room = RectangularRoom("study", 0, 0, 5, 3, GREY, 1.0, GREY)
    tv = Piece("tv", "", np.array([0.6, 0.1, 0.3]), (box((0, 0, 0), (0.6, 0.1, 0.3), GREY),), "")
    return House(
        rooms=(room.room,),
        structure=build_structure((room,), ()),
        instances=(Instance("tv#1", tv, 4.9, 1.5, -pi / 2, height),),
        lights=np.array([[2.5, 1.5, 2.3]]),
        start=(1.0, 1.5, 0.0),
    )


@pytest.mark.parametrize(("height", "goals"), [(1.0, ("tv",)), (1.3, ())])
def test_what_the_judge_sees_from_no_place_within_its_reach_is_no_goal(height, goals):
    with World(with_a_tv_at(height), WorldConfig()) as world:
        assert is_visible(world, [0], planar(1.0, 1.5, 0.0))  # from almost 4 m
        assert goals_of(world) == goals


def test_the_shortest_path_ends_within_reach_in_sight(world):
    world.place(1.0, 2.4, 0.0)
    # Straight ahead through the doorway, up to 2 m in front of the washing machine.
    washer = nearest_path_length(world, "laundry")
    assert washer == pytest.approx(9.6 - 0.33 - 2.0 - 1.0, abs=0.2)
    # The sofa is nearer to the hallway's end than 2 m, but behind the wall.
    world.place(5.7, 0.4, 0.0)
    assert nearest_path_length(world, "sofa") > 1.5


@pytest.mark.parametrize(
    ("goal", "way"),
    [("kitchen", 5.1), ("hallway", 0.0), ("toilet", None), ("study", None), ("piano", None)],
)
def test_the_shortest_path_to_a_room_ends_on_its_floor_and_there_may_be_none(world, goal, way):
    world.place(1.0, 2.4, 0.0)
    assert nearest_path_length(world, goal) == (way and pytest.approx(way, abs=0.1))


def test_ways_lead_around_obstacles_and_are_hardly_too_long(world):
    world.place(1.9, 0.3, 0.0)
    around = 0.35 + np.hypot(0.9 + 0.175, 0.6)
    straight = np.hypot(6.1 - 2.5, 0.6)
    length = nearest_path_length(world, "kitchen")
    assert 0.98 * (around + straight - 0.35) < length < 1.06 * (around + straight)


def test_a_robot_that_touches_something_has_a_way_all_the_same(world):
    world.place(1.0, 2.9, pi / 2)
    assert nearest_path_length(world, "kitchen") == pytest.approx(5.1, abs=0.3)
    assert yaw_of(world.T_world_base) == pytest.approx(pi / 2)
