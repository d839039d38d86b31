from math import pi
from types import SimpleNamespace

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.walls import Opening, RectangularRoom, build_structure
from sim_stubs.homes.furniture.paint import painted_plain
from sim_stubs.homes.furniture.procedural import piece
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.solids import Piece, box, cylinder
from sim_stubs.scoring.success import (
    GoalScorer,
    distance_to,
    in_room,
    is_visible,
    judge,
    pixels_of,
    precise,
)
from sim_stubs.world.body import WorldConfig
from sim_stubs.world.world import World
from vizbot.core.geometry import yaw_of
from vizbot.core.observer import GoalReport, Outcome

GREY = (0.6, 0.6, 0.6)
ROOMS = (
    RectangularRoom("hallway", 0, 0, 4, 3, GREY, 1.0, GREY),
    RectangularRoom("bedroom", 4.1, 0, 8, 3, GREY, 1.0, GREY),
)
CHAIR = Piece("chair", "", np.array([0.46, 0.46, 0.8]),
              (box((0, 0, 0), (0.46, 0.46, 0.8), GREY),), "")  # fmt: skip
YELLOW = painted_plain(CHAIR, "yellow chair", (0.9, 0.8, 0.1))
BED = piece("bed", np.random.default_rng(0))
TABLE = Piece("dining table", "", np.array([1.0, 1.0, 0.7]), (
    box((0, 0, 0), (0.1, 0.1, 0.7), GREY),
    cylinder((0, 0, 0.7), 0.5, 0.04, GREY),
), "")  # fmt: skip
BASKET = Piece("laundry basket", "", np.array([0.4, 0.4, 0.6]),
               (box((0, 0, 0), (0.4, 0.4, 0.6), GREY),), "")  # fmt: skip


@pytest.fixture(scope="module")
def world():
    home = House(
        rooms=tuple(room.room for room in ROOMS),
        structure=build_structure(ROOMS, (Opening(4.0, 2.0, 4.1, 2.9),)),
        instances=(
            Instance("yellow chair#1", YELLOW, 3.6, 0.5, 0.0),
            Instance("chair#1", CHAIR, 7.5, 0.5, 0.0),
            Instance("bed#1", BED, 6.6, 1.9, pi / 2),
            Instance("dining table#1", TABLE, 1.0, 2.2, 0.0),
            Instance("laundry basket#1", BASKET, 0.4, 0.4, 0.0),
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


@pytest.mark.parametrize(
    ("text", "x", "stopped", "visible", "distance", "reason"),
    [
        ("yellow chair", 2.2, False, True, 1.4 - 0.23, "did not stop by itself"),
        ("yellow chair", 0.5, True, False, 3.1 - 0.23, "2.87 m away"),
        ("yellow chair", 4.5, True, False, 0.9 - 0.23, "not in sight"),
        ("piano", 2.2, True, False, None, "no piano in this world"),
    ],
    ids=["does not stop", "too far", "behind a wall", "not in the world"],
)
def test_who_does_not_stop_near_it_and_in_sight_has_not_arrived(
    world, text, x, stopped, visible, distance, reason
):
    found = verdict(world, text, x, 0.5, stopped=stopped)
    assert not found.success
    assert found.visible is visible
    assert found.distance == (distance and pytest.approx(distance, abs=0.01))
    assert found.reason == reason


def test_a_rehearsal_scores_each_goal_by_whether_the_robot_says_that_it_arrived(world):
    scorer = GoalScorer(world)
    world.place(2.2, 0.5, 0.0)
    for outcome in (Outcome.ARRIVED, Outcome.GAVE_UP, Outcome.EXPLORED):
        scorer.on_goal(GoalReport("yellow chair", outcome, "", ()))
    assert [verdict.success for verdict in scorer.verdicts] == [True, False, False]
    assert scorer.verdicts[1].reason == "did not stop by itself"


@pytest.mark.parametrize(("pixels", "visible"), [(5, False), (49, False), (50, True)])
def test_fifty_pixels_in_one_of_the_views_are_in_sight_and_fewer_are_not(pixels, visible):
    def segment_from(T_world_base):
        image = np.full((48, 64), -1, np.int32)
        image.flat[: pixels if yaw_of(T_world_base) < 0 else 0] = 1
        image.flat[1000:2000] = 0
        return image

    shown = SimpleNamespace(segment_from=segment_from, instances=(None, None))
    assert is_visible(shown, [1], np.eye(4)) is visible


def test_distance_is_to_the_thing_and_not_to_the_centre(world):
    # The bed lies with its foot to the east; its middle is over a metre from there.
    assert verdict(world, "bed", 7.75, 1.9).distance < 0.2


def test_distance_is_to_the_true_mesh_and_not_to_its_bounding_box(world):
    table = next(it for it in world.instances if it.label == "dining table")
    # A corner of the round table's bounding box.
    assert distance_to(table, 1.5, 1.7) == pytest.approx(0.5 * 2**0.5 - 0.5, abs=0.01)
    assert distance_to(table, 1.2, 2.1) == 0.0


@pytest.mark.parametrize(
    ("text", "x", "y", "success"),
    [
        ("Yellow  Chair", 2.2, 0.5, True),
        (" yellow chair ", 2.2, 0.5, True),
        ("a yellow chair", 2.2, 0.5, True),
        ("chair", 2.2, 0.5, True),
        ("chair", 7.5, 1.0, True),
        ("yellow chair", 7.5, 1.0, False),
        ("dinner table", 2.2, 0.9, True),
        ("dining tables", 2.2, 0.9, True),
        ("the dining table", 2.2, 0.9, True),
        ("laundry", 1.5, 0.5, True),
        ("laundry", 3.5, 1.5, False),
        ("a corridor", 3.0, 1.5, True),
    ],
)
def test_a_goal_may_be_spelt_otherwise_and_named_by_its_class_or_use(world, text, x, y, success):
    assert verdict(world, text, x, y).success is success


def test_a_room_is_reached_inside_its_floor(world):
    inside = verdict(world, "bedroom", 4.5, 1.5)
    assert inside.success
    assert inside.distance == 0.0
    assert verdict(world, "a corridor", 3.0, 1.5).success
    assert not verdict(world, "bedroom", 4.5, 1.5, stopped=False).success


def test_a_room_is_reached_by_looking_into_it_from_its_door(world):
    at_the_door = verdict(world, "bedroom", 3.75, 2.45)
    assert at_the_door.success
    assert at_the_door.distance == pytest.approx(0.35)
    behind_the_wall = verdict(world, "bedroom", 3.75, 0.5)
    assert behind_the_wall.reason == "not in sight"
    assert not behind_the_wall.visible
    assert verdict(world, "bedroom", 2.8, 2.45).reason == "1.30 m away"


@pytest.mark.parametrize(("east", "success"), [("hallway", True), ("study", False)])
def test_the_legs_of_a_hallway_are_looked_into_as_one(east, success):
    rooms = (
        RectangularRoom("kitchen", 0, 0, 6, 3, GREY, 1.0, GREY),
        RectangularRoom("hallway", 0, 3.1, 3, 5, GREY, 1.0, GREY),
        RectangularRoom(east, 3.1, 3.1, 6, 5, GREY, 1.0, GREY),
    )
    # Each shows a sixth of a picture, in any direction.
    hatches = (
        Opening(2.57, 3.0, 2.89, 3.1, head=0.5),
        Opening(3.21, 3.0, 3.53, 3.1, head=0.5),
    )
    home = House(
        rooms=tuple(room.room for room in rooms),
        structure=build_structure(rooms, hatches),
        instances=(),
        lights=np.array([[3.0, 1.5, 2.3]]),
        start=(3.05, 1.0, 0.0),
    )
    with World(home, WorldConfig()) as world:
        assert verdict(world, "hallway", 3.05, 2.15).success is success


def test_the_walls_of_a_room_are_the_room_s_and_what_is_beyond_is_not(world):
    [bedroom] = [room for room in world.house.rooms if room.name == "bedroom"]
    low, high = bedroom.polygon.min(axis=0), bedroom.polygon.max(axis=0)
    middle = (low + high) / 2
    for off, inside in ((-0.5, True), (0.04, True), (0.07, False), (0.5, False), (9.0, False)):
        points = np.array(
            [(low[0] - off, middle[1]), (high[0] + off, middle[1]),
             (middle[0], low[1] - off), (middle[0], high[1] + off)]
        )  # fmt: skip
        assert in_room(bedroom, points).tolist() == [inside] * 4


def test_a_point_names_what_it_is_near_to_and_the_room_it_is_in(world):
    assert precise(world, np.array([6.6, 1.9, 0.5]), "bed")
    assert precise(world, np.array([1.5, 1.7]), "dining table")
    assert not precise(world, np.array([5.0, 0.5]), "bed")
    assert precise(world, np.array([4.5, 0.5]), "bedroom")
    assert not precise(world, np.array([3.5, 0.5]), "bedroom")
    assert not precise(world, np.array([3.5, 0.5]), "piano")


def test_pixels_are_counted_for_each_instance_and_for_nothing_else():
    assert pixels_of(np.array([[-1, 0, 2], [2, 2, -1]]), 3).tolist() == [1, 0, 3]
    assert pixels_of(np.full((2, 2), -1), 2).tolist() == [0, 0]
