from math import hypot, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_stubs import shapes
from sim_stubs.flat import flat
from sim_stubs.goal_chair import FIRST_DISTANCE
from sim_stubs.house import Instance
from sim_stubs.occupancy_slice import clearance, grid_around, occupied, reachable
from sim_stubs.solids import triangles
from sim_stubs.walls import Opening, RectangularRoom, build_structure

GREY = (0.5, 0.5, 0.5)
EAST = RectangularRoom("east", 2.1, 0, 4, 3, GREY, 1.0, GREY)
WEST = RectangularRoom("west", 0, 0, 2, 3, GREY, 1.0, GREY)
STOOL = shapes.piece("chair", np.random.default_rng(0))


@pytest.fixture(scope="module")
def flats():
    return {seed: flat(seed) for seed in range(10)}


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


def test_the_flat_has_a_home_s_rooms_and_its_furniture_stands_in_them(flats):
    home = flats[0]
    names = {room.name for room in home.rooms}
    assert names >= {"living room", "kitchen", "bathroom", "bedroom", "hallway"}
    for instance in home.instances:
        room = home.room_at(instance.x, instance.y)
        assert room is not None, instance.name
        low, high = instance.footprint.min(axis=0), instance.footprint.max(axis=0)
        assert (low > room.polygon.min(axis=0) - 0.01).all(), instance.name
        assert (high < room.polygon.max(axis=0) + 0.01).all(), instance.name
    assert len({instance.name for instance in home.instances}) == len(home.instances)


def test_the_goal_is_in_another_room_and_the_decoy_in_a_third(flats):
    places = set()
    for home in flats.values():
        (goal,) = [i for i in home.instances if i.label == "yellow chair"]
        (decoy,) = [
            i for i in home.instances if i.label.endswith(" chair") and i.label.split()[0]
            in ("red", "blue", "green", "purple")
        ]  # fmt: skip
        rooms = [home.room_at(*home.start[:2]), *(home.room_at(i.x, i.y) for i in (goal, decoy))]
        assert len({room.name for room in rooms}) == 3
        assert hypot(goal.x - home.start[0], goal.y - home.start[1]) > FIRST_DISTANCE
        places.add(rooms[1].name)
    assert len(places) >= 3


def test_the_robot_gets_from_its_start_into_every_room_and_to_the_goal(flats):
    for home in flats.values():
        everything = triangles(home.parts())
        grid = grid_around(everything, 0.02)
        free = clearance(occupied(everything, 0.02, 0.65, grid), grid) > 0.175
        rows, columns = np.nonzero(reachable(free, grid.cell_of(*home.start[:2])))
        xy = grid.to_xy(np.column_stack([columns, rows]))
        for room in home.rooms:
            low, high = room.polygon.min(axis=0), room.polygon.max(axis=0)
            inside = ((xy > low) & (xy < high)).all(axis=1)
            assert inside.mean() > 0.02, room.name
        (goal,) = [i for i in home.instances if i.label == "yellow chair"]
        assert np.linalg.norm(xy - (goal.x, goal.y), axis=1).min() < 1.0


def test_a_seed_draws_the_same_flat_twice(flats):
    again = flat(3)
    assert again.start == flats[3].start
    assert np.array_equal(triangles(again.parts()), triangles(flats[3].parts()))
    assert flats[3].start != flats[4].start


def test_furniture_of_another_size_is_scaled_into_its_place():
    def giant(label, rng):
        model = shapes.piece(label, rng)
        parts = tuple(
            type(part)(part.vertices * 2, part.normals, part.texcoords, part.faces, part.rgba, None)
            for part in model.parts
        )
        return type(model)(label, "giant", model.size * 2, parts, "")

    home = flat(0, giant)
    (sofa,) = [i for i in home.instances if i.label == "sofa"]
    assert sofa.piece.size[0] <= 2.0 + 1e-9
    assert triangles(sofa.piece.parts)[..., 0].max() <= 1.0 + 1e-5
