from math import pi

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim_stubs.homes.floor_plan.walls import Opening, RectangularRoom, build_structure
from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.solids import flat_panel, triangles
from sim_stubs.homes.home import home as furnished_home
from sim_stubs.world.lighting import Lighting, lamp_weights
from sim_stubs.world.renderer import Renderer
from sim_stubs.world.visibility import opaque_walls
from sim_stubs.world.world import MOUNT
from sim_stubs.world.world_plan import D435I_COLOUR
from vizbot.core.geometry import planar

GREY = (0.5, 0.5, 0.5)


@pytest.fixture(scope="module")
def home():
    return furnished_home(1000)


def eyes(home, count, seed=0):
    """Poses all over the home at heights up to the ceiling, looking anywhere."""
    rng = np.random.default_rng(seed)
    corners = np.concatenate([room.polygon for room in home.rooms])
    for _ in range(count):
        x, y = rng.uniform(corners.min(axis=0), corners.max(axis=0))
        T_world_cam = planar(x, y, rng.uniform(-pi, pi)) @ MOUNT
        T_world_cam[2, 3] = rng.uniform(0.1, 2.4)
        T_world_cam[:3, :3] @= Rotation.from_rotvec(rng.uniform(-0.6, 0.6, 3)).as_matrix()
        yield T_world_cam


@pytest.mark.slow
def test_what_is_not_drawn_would_not_have_been_seen(home):
    drawn = 0
    with (
        Renderer(home, D435I_COLOUR) as culled,
        Renderer(home, D435I_COLOUR, cull=False) as whole,
    ):
        for T_world_cam in eyes(home, 25):
            for one, other in zip(
                culled.render(T_world_cam), whole.render(T_world_cam), strict=True
            ):
                assert np.array_equal(one, other)
            assert np.array_equal(culled.segment(T_world_cam), whole.segment(T_world_cam))
            drawn += int((culled._model.geom_group == 0).sum())
        assert drawn < 0.2 * 25 * culled._model.ngeom


@pytest.mark.slow
def test_a_picture_does_not_depend_on_those_before_it(home):
    places = list(eyes(home, 6))
    with Renderer(home, D435I_COLOUR) as renderer:
        forwards = [renderer.render(T)[0] for T in places]
        backwards = [renderer.render(T)[0] for T in reversed(places)]
    assert all(np.array_equal(a, b) for a, b in zip(forwards, reversed(backwards), strict=True))


def test_a_wall_is_opaque_but_for_its_doorway():
    rooms = [
        RectangularRoom("west", 0, 0, 4, 3, GREY, 1.0, GREY),
        RectangularRoom("east", 4.1, 0, 8, 3, GREY, 1.0, GREY),
    ]
    structure = build_structure(rooms, (Opening(4.0, 2.0, 4.1, 2.9),))
    walls = opaque_walls(triangles(structure), 2.5)
    between = walls[np.ptp(walls[..., 0], axis=1) < 1e-6]
    west_side = between[np.abs(between[:, 0, 0] - 4.0) < 0.005]
    spans = np.sort(np.sort(west_side[..., 1], axis=1), axis=0)
    assert spans == pytest.approx(np.array([[0.0, 2.0], [2.9, 3.0]]), abs=0.04)
    assert (spans[:, 0] > [0.0, 2.9]).all()
    assert (spans[:, 1] < [2.0, 3.0]).all()
    # Seen from the west: the way from end to end has it to its left.
    assert (west_side[:, 0, 1] < west_side[:, 1, 1]).all()


@pytest.mark.parametrize("height", [0.05, 2.3])
def test_what_does_not_reach_from_floor_to_top_hides_nothing(height):
    wall = flat_panel((1, 0, 0), (2, 0, 0), (0, 0, height), GREY)
    assert len(opaque_walls(triangles([wall]), 2.5)) == 0
    assert len(opaque_walls(triangles([wall]), height)) == 1


def test_seven_lamps_burn_at_most_and_none_goes_out_at_once():
    lamps = np.random.default_rng(0).uniform((0, 0, 2.3), (15, 10, 2.4), (12, 3))
    way = np.linspace((1, 1, 0.6), (14, 9, 0.6), 1000)
    weights = np.array([lamp_weights(lamps, position) for position in way])
    assert ((weights > 0).sum(axis=1) <= 7).all()
    assert (weights.max(axis=0) > 0.5).sum() > 7
    assert np.abs(np.diff(weights, axis=0)).max() < 0.05
    assert (lamp_weights(lamps[:7], way[0]) == 1).all()


def test_lighting_sets_brightness_and_warmth():
    room = RectangularRoom("room", 0, 0, 4, 3, GREY, 1.0, GREY)
    house = House((room.room,), build_structure((room,), ()), (), np.array([[2, 1.5, 2.3]]),
                  (1, 1, 0))  # fmt: skip
    means = []
    for lighting in (Lighting(), Lighting(0.7), Lighting(1.0, 4000.0)):
        with Renderer(house, D435I_COLOUR, lighting) as renderer:
            rgb, _ = renderer.render(planar(1, 1, 0.3) @ MOUNT)
            means.append(rgb.mean(axis=(0, 1)))
    neutral, dim, warm = means
    assert dim / neutral == pytest.approx(np.full(3, 0.7), abs=0.02)
    assert warm[0] / warm[2] > 1.15 * neutral[0] / neutral[2]


def test_homes_differ_in_lighting_by_their_seed():
    drawn = [Lighting.drawn(np.random.default_rng(seed)) for seed in (1, 1, 2)]
    assert drawn[0] == drawn[1] != drawn[2]
