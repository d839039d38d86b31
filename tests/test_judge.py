from math import pi

import numpy as np
import pytest

from sim_stubs.house import House, Instance
from sim_stubs.judge import judge
from sim_stubs.shapes import piece, recoloured
from sim_stubs.walls import Opening, RectangularRoom, build_structure
from sim_stubs.world import World, WorldConfig

GREY = (0.6, 0.6, 0.6)
ROOMS = (
    RectangularRoom("west", 0, 0, 4, 3, GREY, 1.0, GREY),
    RectangularRoom("east", 4.1, 0, 8, 3, GREY, 1.0, GREY),
)
CHAIR = piece("chair", np.random.default_rng(0))
YELLOW = recoloured(CHAIR, "yellow chair", (0.9, 0.8, 0.1))
BED = piece("bed", np.random.default_rng(0))


@pytest.fixture(scope="module")
def world():
    home = House(
        rooms=tuple(room.room for room in ROOMS),
        structure=build_structure(ROOMS, (Opening(4.0, 2.0, 4.1, 2.9),)),
        instances=(
            Instance("yellow chair#1", YELLOW, 3.6, 0.5, 0.0),
            Instance("chair#1", CHAIR, 7.5, 0.5, 0.0),
            Instance("bed#1", BED, 6.6, 1.9, pi / 2),
        ),
        lights=np.array([[2.0, 1.5, 2.3]]),
        start=(1.0, 1.5, 0.0),
    )
    with World(home, WorldConfig()) as world:
        yield world


def verdict(world, text, x, y, yaw=0.0, stopped=True):
    world.place(x, y, yaw)
    return judge(world, text, stopped=stopped)


def test_stopped_near_and_in_sight_is_success_wherever_the_robot_looks(world):
    for yaw in (0.0, pi / 2, pi):
        found = verdict(world, "yellow chair", 2.2, 0.5, yaw)
        assert found.success
        assert found.visible
        assert found.reason == ""
        assert found.distance == pytest.approx(1.4 - 0.23, abs=0.01)


def test_who_does_not_stop_has_not_arrived(world):
    found = verdict(world, "yellow chair", 2.2, 0.5, stopped=False)
    assert not found.success
    assert found.visible
    assert found.reason == "did not stop by itself"


def test_too_far_is_no_success(world):
    found = verdict(world, "yellow chair", 0.5, 0.5)
    assert not found.success
    assert found.distance == pytest.approx(3.1 - 0.23, abs=0.01)
    assert found.reason == "2.87 m away"


def test_behind_a_wall_is_no_success(world):
    found = verdict(world, "yellow chair", 4.5, 0.5)
    assert found.distance < 2.0
    assert not found.visible
    assert not found.success
    assert found.reason == "not in sight"


def test_distance_is_to_the_footprint_and_not_to_the_centre(world):
    # The bed lies with its foot to the east; its middle is over a metre from there.
    found = verdict(world, "bed", 7.75, 1.9)
    assert found.distance < 0.2


@pytest.mark.parametrize("text", ["Yellow  Chair", " yellow chair "])
def test_the_goal_s_spelling_is_read_kindly(world, text):
    assert verdict(world, text, 2.2, 0.5).success


def test_any_chair_is_a_chair_but_not_any_chair_is_yellow(world):
    assert verdict(world, "chair", 2.2, 0.5).success
    assert verdict(world, "chair", 7.5, 1.0).success
    assert not verdict(world, "yellow chair", 7.5, 1.0).success


def test_what_the_world_has_not_is_no_success(world):
    found = verdict(world, "piano", 2.2, 0.5)
    assert not found.success
    assert found.distance is None
    assert found.reason == "no piano in this world"
