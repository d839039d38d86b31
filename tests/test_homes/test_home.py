from math import hypot

import numpy as np
import pytest

from sim_stubs.homes.furniture.procedural import GOALS
from sim_stubs.homes.geometry.bounding_block import Block
from sim_stubs.homes.geometry.house import Room
from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.homes.goal_chair import DECOYS, FIRST_DISTANCE, GOAL
from sim_stubs.homes.home import home, home_and_space
from sim_stubs.homes.start_pose import CLEARANCE, start_for, things_named
from sim_stubs.scoring.success import distance_to
from vizbot.core.errors import ConfigError

pytestmark = pytest.mark.slow
SEEDS = (0, 1, 1000, 1001)


@pytest.fixture(scope="module")
def homes():
    return {seed: home(seed) for seed in SEEDS}


def test_a_home_has_its_rooms_and_their_furniture(homes):
    for house in homes.values():
        names = {room.name for room in house.rooms}
        assert names >= {"living room", "kitchen", "bathroom", "bedroom", "hallway"}
        labels = {it.label for it in house.instances}
        assert labels >= {"sofa", "bed", "toilet", "sink", "refrigerator", "window", "door"}
        assert len({it.name for it in house.instances}) == len(house.instances)
        assert len(house.lights) == len(house.rooms)


def test_no_two_things_are_in_one_place(homes):
    for seed, house in homes.items():
        blocks = [
            (it, Block.around(it))
            for it in house.instances
            if it.label not in ("window", "door", "stairs")
        ]
        for i, (one, block) in enumerate(blocks):
            for other, its_block in blocks[:i]:
                if one.on == other.name or other.on == one.name:
                    continue
                apart = not block.overlaps(its_block, slack=1e-3)
                assert apart or _askew(one, other), (seed, one.name, other.name)


def _askew(one, other):
    """Whether the rectangles of two pieces are apart though those along the axes are not."""
    for a, b in ((one.footprint, other.footprint), (other.footprint, one.footprint)):
        for edge in np.roll(a, -1, axis=0) - a:
            outwards = np.array([edge[1], -edge[0]])
            if (b @ outwards).min() > (a @ outwards).max() - 1e-6:
                return True
    return False


def test_furniture_stands_in_rooms_and_things_on_furniture_rest_on_it(homes):
    for seed, house in homes.items():
        by_name = {it.name: it for it in house.instances}
        for it in house.instances:
            if it.label in ("window", "door", "stairs"):
                continue
            room = house.room_at(it.x, it.y)
            assert room is not None, (seed, it.name)
            assert (it.footprint >= room.polygon.min(axis=0) - 0.01).all(), (seed, it.name)
            assert (it.footprint <= room.polygon.max(axis=0) + 0.01).all(), (seed, it.name)
            if it.on:
                below = by_name[it.on]
                assert Block.around(it).inside(Block.around(below).grown(0.03)), (seed, it.name)
                assert 0.2 < it.elevation <= below.elevation + below.piece.size[2] + 1e-6


def _below(it, space):
    """Cells of the plan in the rectangle around an instance."""
    return space.inside(Room(it.name, it.footprint))


@pytest.mark.parametrize("seed", [0, 1001, 1101])
def test_the_plan_that_comes_with_a_home_is_that_of_the_home(seed):
    house, space = home_and_space(seed)
    again = FreeSpace.from_house(house)
    assert np.array_equal(space.blocked, again.blocked)
    assert np.array_equal(space.clear, again.clear)
    assert np.array_equal(space.structure, again.structure)


def test_the_robot_gets_into_every_room(homes):
    for seed, house in homes.items():
        space = FreeSpace.from_house(house)
        reached = space.reached(*house.start[:2])
        stairs = [it for it in house.instances if it.label == "stairs"]
        for room in house.rooms:
            floor = space.inside(room)
            if any((floor & _below(it, space)).sum() > 0.6 * floor.sum() for it in stairs):
                continue  # a niche that the stairs fill
            free = (reached & floor).sum() * space.grid.resolution**2
            assert free > 1.0, (seed, room.name)


def test_every_goal_that_a_home_has_has_a_start(homes):
    for seed in (1, 1001):
        house = homes[seed]
        space = FreeSpace.from_house(house)
        for goal in GOALS:
            things, rooms = things_named(house, goal)
            if not things and not rooms:
                continue
            start = start_for(house, goal, np.random.default_rng(0))
            assert start is not None, (seed, goal)
            x, y, _ = start
            assert space.clearance(x, y) >= CLEARANCE
            assert all(distance_to(it, x, y) > FIRST_DISTANCE for it in things), (seed, goal)
            assert not any(room.contains(x, y) for room in rooms)


def test_the_yellow_chair_is_in_another_room_than_the_start_and_the_decoy_in_a_third(homes):
    places = set()
    for house in homes.values():
        (goal,) = [it for it in house.instances if it.label == GOAL]
        (decoy,) = [it for it in house.instances if it.label in [f"{c} chair" for c in DECOYS]]
        polygons = [
            id(house.room_at(x, y))
            for x, y in (house.start[:2], (goal.x, goal.y), (decoy.x, decoy.y))
        ]
        assert len(set(polygons)) == 3
        assert hypot(goal.x - house.start[0], goal.y - house.start[1]) > FIRST_DISTANCE
        places.add(house.room_at(goal.x, goal.y).name)
    assert len(places) >= 2


def test_a_seed_draws_the_same_home_twice(homes):
    again = home(1001)
    first = homes[1001]
    assert again.start == first.start
    assert [it.name for it in again.instances] == [it.name for it in first.instances]
    assert np.array_equal(triangles(again.parts()), triangles(first.parts()))
    assert homes[1000].start != first.start


def test_a_seed_that_draws_no_home_is_named(monkeypatch):
    monkeypatch.setattr("sim_stubs.homes.home._drawn", lambda seed, draw: None)
    with pytest.raises(ConfigError, match="world 1234: no home"):
        home(1234)


def test_some_furniture_is_painted(homes):
    def bright(it):
        colours = np.array([part.rgba[:3] for part in it.piece.parts])
        plain = all(part.texture is None for part in it.piece.parts)
        return plain and np.ptp(colours, axis=1).max() > 0.4

    instances = [it for house in homes.values() for it in house.instances]
    for label in ("sofa", "chair"):
        pieces = [bright(it) for it in instances if it.label == label]
        assert 0 < sum(pieces) < len(pieces)


@pytest.mark.long
@pytest.mark.parametrize("seed", [*range(0, 1000, 77), *range(1000, 2000, 77)])
def test_every_seed_gives_a_home_where_each_goal_can_be_looked_for(seed):
    house = home(seed)
    for goal in GOALS:
        if any(things_named(house, goal)):
            assert start_for(house, goal, np.random.default_rng(seed)) is not None, goal
