import numpy as np
import pytest

from sim_stubs.homes.floor_plan.staircase import placed, staircase
from sim_stubs.homes.floor_plan.stairs import Stairs
from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.world.body import WorldConfig
from sim_stubs.world.contact_map import ContactMap

GREY = (0.5, 0.5, 0.5)
ROOM = RectangularRoom("hallway", 0, 0, 5, 6, GREY, 1.0, GREY)
FACINGS = ("N", "E", "S", "W")
SIZES = {"straight": (0.95, 3.0), "quarter-turn": (2.3, 2.4), "spiral": (1.6, 1.6)}


def place(kind, shape, facing, open_sides=()):
    return Stairs(kind, shape, 2.5, 3.0, facing, *SIZES[shape], open_sides)


def world_with(stairs, seed=0):
    instance = staircase(stairs, 2.5, np.random.default_rng(seed), held_out=False)
    house = House(
        (ROOM.room,),
        build_structure((ROOM,), (), 2.5, stairs),
        (instance,),
        np.zeros((1, 3)),
        (0.5, 0.5, 0.0),
    )
    return ContactMap(house, WorldConfig().outline(height=0.6, forward=0.05))


def front_of(stairs):
    x0, y0, x1, y1 = stairs.bounds
    way = {"N": (0, 1), "S": (0, -1), "E": (1, 0), "W": (-1, 0)}[stairs.facing]
    middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    return middle + np.array(way) * (x1 - x0, y1 - y0) / 2, np.array(way, float)


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("facing", FACINGS)
def test_stairs_fill_their_place_and_rise_to_the_ceiling(shape, facing):
    for seed in range(4):
        stairs = place("up", shape, facing)
        instance = staircase(stairs, 2.5, np.random.default_rng(seed), held_out=False)
        corners = triangles(instance.parts()).reshape(-1, 3)
        x0, y0, x1, y1 = stairs.bounds
        assert (corners.min(axis=0) > (x0 - 0.08, y0 - 0.08, -0.01)).all()
        assert (corners.max(axis=0)[:2] < (x1 + 0.08, y1 + 0.08)).all()
        assert np.ptp(corners[:, 0]) > 0.85 * (x1 - x0)
        assert np.ptp(corners[:, 1]) > 0.85 * (y1 - y0)
        assert corners[:, 2].max() >= 2.5 - 1e-3
        assert instance.label == "stairs"


@pytest.mark.parametrize("facing", FACINGS)
def test_who_steps_onto_stairs_downwards_meets_a_cliff_and_no_obstacle(facing):
    stairs = place("down", "straight", facing, ("left",))
    world = world_with(stairs)
    edge, way = front_of(stairs)
    heading = float(np.arctan2(-way[1], -way[0]))
    assert not any(world.contacts(*(edge + 0.5 * way), heading).cliffs)
    assert any(world.contacts(*(edge + 0.1 * way), heading).cliffs)
    assert world.gap(*(edge + 0.05 * way), heading) > 0.0
    assert world.wheel_drops(*(edge - 0.2 * way), heading) == (True, True)


@pytest.mark.parametrize("facing", FACINGS)
def test_an_open_side_of_a_stairwell_has_a_railing_that_a_bumper_feels(facing):
    for seed in range(4):
        world = world_with(place("down", "straight", facing, ("left",)), seed)
        # Left of someone who steps down, a hand's breadth beyond the railing.
        left = {"N": (1, 0), "S": (-1, 0), "E": (0, -1), "W": (0, 1)}[facing]
        beside = np.array([2.5, 3.0]) + np.array(left) * (0.95 / 2 + 0.16)
        opposite = np.array([2.5, 3.0]) - np.array(left) * (0.95 / 2 + 0.16)
        assert world.gap(*beside, 0.0) < 0.0
        assert world.gap(*opposite, 0.0) > 0.0


def test_stairs_downwards_lead_down_at_least_one_and_a_half_metres_and_are_closed():
    for depth in (2.3, 2.7, 3.2):
        stairs = Stairs("down", "straight", 2.5, 3.0, "S", 0.9, depth)
        instance = staircase(stairs, 2.5, np.random.default_rng(0), held_out=False)
        corners = triangles(instance.parts())
        assert corners[..., 2].min() < -1.5
        assert corners[..., 2].max() == pytest.approx(0.0, abs=1e-5)
        treads = np.ptp(corners[..., 2], axis=1) < 1e-6
        heights = np.unique(corners[treads][..., 2].round(3))
        assert np.diff([*heights, 0.0]).max() < 0.2
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        for axis, low, high in ((0, 2.05, 2.95), (1, 3 - depth / 2, 3 + depth / 2)):
            for at in (low, high):
                on_it = np.abs(corners[..., axis] - at).max(axis=1) < 1e-4
                inwards = np.sign(2.5 - at) if axis == 0 else np.sign(3.0 - at)
                assert on_it.any()
                assert (normals[on_it, axis] * inwards > 0).all()


@pytest.mark.parametrize("facing", FACINGS)
def test_the_floor_before_stairs_is_their_approach(facing):
    stairs = place("up", "straight", facing)
    edge, way = front_of(stairs)
    x0, y0, x1, y1 = stairs.approach
    x, y = edge + 0.4 * way
    assert x0 < x < x1
    assert y0 < y < y1


def test_a_model_of_someone_else_is_put_on_the_floor_of_the_place():
    model = staircase(place("up", "spiral", "S"), 2.5, np.random.default_rng(0), False).piece
    instance = placed(place("up", "spiral", "E"), model)
    assert (instance.x, instance.y, instance.elevation) == (2.5, 3.0, 0.0)


def test_stairs_of_benchmark_homes_are_of_other_materials():
    looks = [set(), set()]
    for seed in range(30):
        for held_out in (False, True):
            stairs = place("up", "straight", "S")
            piece = staircase(stairs, 2.5, np.random.default_rng(seed), held_out).piece
            looks[held_out] |= {part.texture or part.rgba.tobytes() for part in piece.parts}
    assert not looks[0] & looks[1]
