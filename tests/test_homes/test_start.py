import numpy as np
import pytest

from sim_stubs.homes.floor_plan.walls import Opening, RectangularRoom, build_structure
from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.furniture.paint import painted_plain
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.homes.start_pose import CLEARANCE, distances, start_for, things_named

GREY = (0.5, 0.5, 0.5)
ROOMS = (
    RectangularRoom("kitchen", 0, 0, 3, 4, GREY, 1.0, GREY),
    RectangularRoom("hallway", 3.1, 0, 9, 4, GREY, 1.0, GREY),
    RectangularRoom("study", 9.1, 0, 12, 4, GREY, 1.0, GREY),
)
DOORWAY = Opening(3.0, 1, 3.1, 2)


def a(label, x, y):
    return Instance(f"{label}#1", procedural.piece(label, np.random.default_rng(0)), x, y, 0.0)


def house(*instances):
    """Two rooms joined by a doorway; the third is walled off."""
    structure = build_structure(ROOMS, (DOORWAY,))
    rooms = tuple(room.room for room in ROOMS)
    return House(rooms, structure, instances, np.array([(6, 2, 2.3)]), (6.0, 2.0, 0.0))


@pytest.mark.parametrize("text", ["sofa", "a couch", "Sofas", "Find the sofa!"])
def test_a_start_is_far_from_the_goal_free_and_within_reach(text):
    home = house(a("sofa", 1.2, 2.0), a("chair", 7.0, 2.0))
    space = FreeSpace.from_house(home)
    reached = space.reached(*home.start[:2])
    rng = np.random.default_rng(1)
    for _ in range(20):
        x, y, _ = start_for(home, text, rng)
        assert distances(np.array([[x, y]]), home.instances[0]) > 3.0
        assert space.clearance(x, y) > CLEARANCE
        assert reached[space.grid.cell_of(x, y)]
        assert home.room_at(x, y).name == "hallway"


def test_a_start_is_outside_the_room_asked_for():
    home = house()
    rng = np.random.default_rng(1)
    assert all(start_for(home, "kitchen", rng)[0] > 6.0 for _ in range(20))
    assert all(start_for(home, "corridor", rng)[0] < 3.1 - 1.5 for _ in range(20))


def test_no_start_is_none():
    chair = a("chair", 0.0, 0.0).piece
    places = [(1.5, 2.0), (4.5, 3.6), (7.5, 3.6), (7.5, 0.4)]
    everywhere = [Instance(f"chair#{i}", chair, x, y, 0.0) for i, (x, y) in enumerate(places)]
    assert start_for(house(everywhere[0]), "chair", np.random.default_rng(0)) is not None
    assert start_for(house(*everywhere), "chair", np.random.default_rng(0)) is None


def test_what_is_named_is_found_by_class_synonym_and_group():
    home = house(a("office chair", 7, 2), a("washing machine", 1, 1))
    assert [it.label for it in things_named(home, "chair")[0]] == ["office chair"]
    assert [it.label for it in things_named(home, "laundry")[0]] == ["washing machine"]
    assert [room.name for room in things_named(home, "lounge")[1]] == []
    assert [room.name for room in things_named(home, "the hallway")[1]] == ["hallway"]


def test_the_yellow_chair_is_asked_for_where_the_house_starts():
    chair = a("chair", 7, 3.5).piece
    home = house(Instance("yellow chair#1", painted_plain(chair, "yellow chair", GREY), 1, 1, 0))
    assert start_for(home, "yellow chair", np.random.default_rng(0)) == home.start
    assert start_for(home, "chair", np.random.default_rng(0)) == home.start
