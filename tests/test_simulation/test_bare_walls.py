"""Homes with bare walls: only what a camera sees of them differs from the plain ones."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.episodes.episode import Episode, seed_of_home
from benchmarks.episodes.homes import house_of, start_of
from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.mirror import Mirror
from sim_stubs.homes.geometry.solids import Piece, box
from sim_stubs.homes.home import home
from sim_stubs.homes.start_pose import start_for
from sim_stubs.world.bare import bare
from sim_stubs.world.contact_map import ContactMap
from sim_stubs.world.renderer import Renderer
from sim_stubs.world.world import MOUNT
from sim_stubs.world.world_name import plan_world
from sim_stubs.world.world_plan import D435I_COLOUR
from sim_stubs.world.world_spec import is_bare, require_world, seed_of
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import planar
from vizbot.rehearsal.config import RehearsalConfig

SEED = 1100
GREY, RED = (0.5, 0.5, 0.5), (0.9, 0.1, 0.1)
LENGTH, WIDTH, HEIGHT = 4.0, 3.0, 2.5
GLASS = LENGTH - 0.01
"""Where the plane of the mirror is, before the east wall [m]."""
MIRROR = Mirror(np.array([GLASS, 2.2, 0.1]), np.array([0.0, -1.4, 0.0]), np.array([0.0, 0.0, 1.7]))


@pytest.fixture(scope="module")
def plain():
    return home(SEED)


@pytest.fixture(scope="module")
def bared(plain):
    return bare(plain)


def room(*things, mirror=MIRROR):
    """One grey room with a mirror at its east wall, and red posts x, y in it."""
    walls = RectangularRoom("hallway", 0, 0, LENGTH, WIDTH, GREY, 1.0, GREY)
    post = Piece(
        "post", "post", np.array([0.2, 0.2, 1.2]), (box((0, 0, 0), (0.2, 0.2, 1.2), RED),), ""
    )
    posts = tuple(Instance(f"post#{i}", post, x, y, 0.0) for i, (x, y) in enumerate(things))
    lights = np.array([[2.0, 1.5, 2.3]])
    structure = build_structure((walls,), (), HEIGHT)
    return House((walls.room,), structure, posts, lights, (1.0, 1.5, 0.0), mirror)


def pictured(house, x, y, yaw=0.0):
    with Renderer(house, D435I_COLOUR) as renderer:
        return renderer.render(planar(x, y, yaw) @ MOUNT)


def rays(x, y, yaw=0.0):
    """The eye, and the direction (H, W, 3) of each pixel with unit depth, in the world."""
    T_world_cam = planar(x, y, yaw) @ MOUNT
    camera = D435I_COLOUR
    columns, rows = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    in_cam = np.stack(
        [
            (columns - camera.cx) / camera.fx,
            (rows - camera.cy) / camera.fy,
            np.ones(columns.shape),
        ],
        axis=-1,
    )
    return T_world_cam[:3, 3], in_cam @ T_world_cam[:3, :3].T


def mirrored_depth(eye, directions):
    """Depth of the empty room behind the looking glass, and which pixels look well into it and
    at it or its very edge.

    The room is unfolded: past the plane of the mirror lies its image, as long as the room is.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        glass = (GLASS - eye[0]) / directions[..., 0]
        at = eye + glass[..., None] * directions
        inside, near = (
            (glass > 0)
            & (abs(at[..., 1] - 1.5) < 0.7 + edge)
            & (abs(at[..., 2] - 0.95) < 0.85 + edge)
            for edge in (-0.01, 0.01)
        )
        low, high = np.array([GLASS, 0.0, 0.0]), np.array([2 * GLASS, WIDTH, HEIGHT])
        ends = np.where(directions > 0, high, low)
        return ((ends - eye) / directions).min(axis=-1), inside, near


@pytest.mark.parametrize("place", [(1.0, 1.5, 0.0), (2.6, 0.8, 0.5), (3.2, 2.4, -0.9)])
def test_a_mirror_has_the_depth_of_what_it_shows(place):
    _, depth = pictured(room(), *place)
    expected, inside, near = mirrored_depth(*rays(*place))
    assert inside.sum() > 5_000
    # A wall ahead is nearly exact; where a surface lies aslant half a pixel is some centimetres.
    assert np.quantile(abs(depth - expected)[inside], 0.25) < 3e-3
    assert np.quantile(abs(depth - expected)[inside], 0.99) < 0.06
    _, wall = pictured(room(mirror=None), *place)
    assert (depth - wall)[inside].min() > 0.05
    assert np.array_equal(depth[~near], wall[~near])


def test_a_mirror_shows_what_is_on_the_left_on_the_left():
    rgb, depth = pictured(room((0.5, 2.0)), 1.5, 1.5)  # the post stands behind the robot
    red = (rgb[..., 0] > 60) & (rgb[..., 1] < 0.5 * rgb[..., 0])
    assert red.sum() > 200
    assert np.nonzero(red)[1].mean() < D435I_COLOUR.cx - 20
    # Its near side is 0.6 m from the west wall; there and back from the glass to the eye.
    assert np.median(depth[red]) == pytest.approx((GLASS - 0.6) + (GLASS - 1.55), abs=0.08)


def test_what_stands_before_a_mirror_hides_it():
    place = (1.0, 1.5)
    (rgb, depth), (_, alone) = pictured(room((3.0, 1.5)), *place), pictured(room(), *place)
    column, row = round(D435I_COLOUR.cx), round(D435I_COLOUR.cy)
    assert rgb[row, column, 0] > 2 * rgb[row, column, 1]
    assert depth[row, column] == pytest.approx(2.9 - 1.05, abs=0.05)
    assert alone[row, column] > 1.2 * (GLASS - 1.05)


@pytest.mark.slow
def test_what_is_not_drawn_into_a_mirror_would_not_have_been_seen(bared):
    mirror = bared.mirror
    yaw = np.arctan2(*-mirror.normal[1::-1])
    with (
        Renderer(bared, D435I_COLOUR) as culled,
        Renderer(bared, D435I_COLOUR, cull=False) as whole,
        Renderer(replace(bared, mirror=None), D435I_COLOUR) as blind,
    ):
        for away in (0.6, 1.5, 2.8):
            x, y = (mirror.corner + mirror.along / 2 + away * mirror.normal)[:2]
            T_world_cam = planar(x, y, yaw) @ MOUNT
            (rgb, depth), (same, deep) = culled.render(T_world_cam), whole.render(T_world_cam)
            assert np.array_equal(rgb, same)
            assert np.array_equal(depth, deep)
            assert (depth > blind.render(T_world_cam)[1] + 0.5).mean() > 0.02


@pytest.mark.slow
def test_pictures_are_gone_and_doors_are_white(plain, bared):
    gone = {it.name for it in plain.instances} - {it.name for it in bared.instances}
    assert gone == {it.name for it in plain.instances if it.label == "picture"} != set()
    doors = [it for it in bared.instances if it.label == "door"]
    assert doors
    for part in (part for door in doors for part in door.piece.parts):
        assert part.texture is None
        assert part.rgba.tolist() == pytest.approx([0.9, 0.9, 0.9, 1.0])


@pytest.fixture(params=["room", pytest.param("home", marks=pytest.mark.slow)])
def furnished(request):
    """A room with a picture at a wall, a door and a post in it, and a whole home."""
    if request.param == "home":
        return request.getfixturevalue("plain")
    house = room((0.2, 1.5), (2.0, 2.8), (1.0, 1.0), mirror=None)
    picture, door, post = (
        replace(it, piece=replace(it.piece, label=label))
        for it, label in zip(house.instances, ("picture", "door", "post"), strict=True)
    )
    return replace(house, instances=(replace(picture, elevation=1.3), door, post))


def test_bare_walls_change_nothing_that_a_robot_touches(furnished):
    plain, bared = furnished, bare(furnished)
    outline = RehearsalConfig().world.outline(float(MOUNT[2, 3]), float(MOUNT[0, 3]))
    (one, grid), (other, same) = (
        ContactMap(plain, outline).free(),
        ContactMap(bared, outline).free(),
    )
    assert np.array_equal(one, other)
    assert np.array_equal(grid.origin, same.origin)
    assert bared.structure is plain.structure
    assert bared.rooms is plain.rooms
    assert bared.lights is plain.lights
    assert bared.start == plain.start
    stays = [it for it in plain.instances if it.label != "picture"]
    assert 0 < len(stays) < len(plain.instances)
    for before, after in zip(stays, bared.instances, strict=True):
        assert after is before or after.label == "door"
        assert np.array_equal(after.T_world_piece, before.T_world_piece)
        assert np.array_equal(after.piece.size, before.piece.size)


@pytest.mark.slow
def test_a_plain_home_mirrors_nothing(plain):
    assert plain.mirror is None
    assert plan_world(str(SEED)).house.mirror is None


@pytest.mark.slow
def test_a_bare_home_is_entered_where_the_plain_one_is(plain):
    named = f"{SEED}+bare"
    planned = plan_world(named, "sofa")
    assert planned.house.start == plan_world(str(SEED), "sofa").house.start
    assert planned.house.mirror is not None
    assert planned.seed == SEED
    assert "walls are bare" in planned.notice
    assert house_of(named).mirror is not None
    assert seed_of_home(named) == SEED
    assert start_of(Episode(named, ("sofa",))) == planned.house.start
    rng = np.random.default_rng((SEED, 3))
    assert planned.house.start == start_for(plain, "sofa", rng)


def test_a_bare_home_is_named_by_its_seed():
    assert seed_of("1140+bare") == 1140
    assert is_bare("1140+bare")
    assert not is_bare("1140")
    require_world("1140+bare")


@pytest.mark.parametrize(
    ("world", "says"),
    [
        ("1140+bear", r"'\+bear' changes no home; give 1140, or 1140\+bare"),
        ("1140+", r"'\+' changes no home"),
        ("1140+BARE", "changes no home"),
        ("1140+bare+bare", "changes no home"),
        ("office+bare", r"\+bare is for the home of a seed, as in 1100\+bare"),
        ("home.sh3d+bare", "is for the home of a seed"),
        ("1" * 19 + "+bare", "18 digits at most"),
    ],
)
def test_a_wrong_modifier_of_a_world_is_one_line(world, says):
    with pytest.raises(ConfigError, match=says) as raised:
        require_world(world)
    assert "\n" not in str(raised.value)
