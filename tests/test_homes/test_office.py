import numpy as np
import pytest

from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.homes.office import GOALS, office
from sim_stubs.homes.textures.surfaces import finish
from sim_stubs.world.body import WorldConfig
from sim_stubs.world.world import World

pytestmark = pytest.mark.slow  # where no furniture is kept yet, that of two offices is simplified


@pytest.fixture(scope="module")
def offices():
    return {seed: office(seed) for seed in range(2)}


def goals(house):
    found = {label: [it for it in house.instances if it.label == label] for label in GOALS}
    assert all(len(instances) == 1 for instances in found.values())
    return [instances[0] for instances in found.values()]


def test_it_has_one_of_each_goal_in_different_rooms(offices):
    plans = set()
    for house in offices.values():
        rooms = [house.room_at(goal.x, goal.y) for goal in goals(house)]
        assert len({id(room) for room in rooms}) == 3
        plans.add(tuple((round(goal.x), round(goal.y)) for goal in goals(house)))
    assert len(plans) > 1


def test_the_robot_gets_from_its_start_into_every_room_and_near_every_goal(offices):
    for house in offices.values():
        space = FreeSpace.from_house(house)
        reached = space.reached(*house.start[:2])
        for room in house.rooms:
            assert (reached & space.inside(room)).sum() * space.grid.resolution**2 > 3.0, room.name
        rows, columns = np.nonzero(reached)
        xy = space.grid.pixels_to_xy(np.column_stack([columns, rows]))
        for goal in goals(house):
            assert np.linalg.norm(xy - (goal.x, goal.y), axis=1).min() < 1.0, goal.name


def test_no_goal_is_in_sight_of_the_start(offices):
    for house in offices.values():
        with World(house, WorldConfig()) as world:
            wanted = {i for i, it in enumerate(house.instances) if it.label in GOALS}
            for turn in np.linspace(0, 2 * np.pi, 8, endpoint=False):
                assert not wanted & set(np.unique(world.segment(turn)).tolist())


def test_every_goal_can_be_seen_from_before_it(offices):
    with World(offices[0], WorldConfig()) as world:
        for goal in goals(offices[0]):
            index = offices[0].instances.index(goal)
            world.place(goal.x + 1.8, goal.y, np.pi)
            assert (world.segment() == index).sum() > 500, goal.name


def test_furniture_stands_in_rooms_and_apart(offices):
    for house in offices.values():
        boxes = []
        for instance in house.instances:
            assert house.room_at(instance.x, instance.y) is not None, instance.name
            if instance.elevation == 0.0:
                low, high = instance.footprint.min(axis=0), instance.footprint.max(axis=0)
                boxes.append((instance.name, low + 0.02, high - 0.02))
        for i, (name, low, high) in enumerate(boxes):
            for other, low2, high2 in boxes[i + 1 :]:
                overlap = (low < high2).all() and (low2 < high).all()
                # Chairs are pushed under tables.
                assert not overlap or "chair" in name + other or "stool" in name + other, (
                    name,
                    other,
                )


def test_a_seed_draws_the_same_office_twice(offices):
    again = office(1)
    assert again.start == offices[1].start
    assert np.array_equal(triangles(again.parts()), triangles(offices[1].parts()))


def test_its_entrance_and_what_its_windows_show_are_held_out(offices):
    rng = np.random.default_rng(0)
    shown = {part.texture for house in offices.values() for part in house.structure}
    for family in ("door", "outdoors"):
        assert shown & {finish(family, rng, held_out=True).surface for _ in range(99)}, family
        assert not shown & {finish(family, rng, held_out=False).surface for _ in range(99)}, family
