import os
import subprocess
import sys
from math import pi

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.solids import box, flat_panel
from sim_stubs.scoring.success import distance_to
from sim_stubs.world.body import Contacts, WorldConfig
from sim_stubs.world.world import World
from sim_stubs.world.world_name import open_world
from tests.helpers.checkout import ROOT
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.core.geometry import back_project, planar, transform, yaw_of

GREY = (0.6, 0.6, 0.6)
ROOM = RectangularRoom("room", 0, 0, 4, 3, (0.5, 0.4, 0.3), 1.0, GREY)
EXACT = WorldConfig(wheel_scale_noise=0.0, slip_noise=0.0)


def house(*parts, start=(1.0, 1.5, 0.0), instances=()):
    structure = (*build_structure((ROOM,), ()), *parts)
    return House((ROOM.room,), structure, instances, np.array([[2.0, 1.5, 2.3]]), start)


def driven(world, left, right, seconds):
    world.set_wheel_speeds(left, right)
    for _ in range(round(seconds / 0.015)):
        world.advance(0.015)
    return world


@pytest.fixture
def room():
    with World(house(), EXACT) as world:
        yield world


def test_the_body_goes_where_its_wheels_roll(room):
    driven(room, 0.2, 0.2, 3.0)
    T = room.T_world_base
    # 2 m/s^2 up to 0.2 m/s take 0.1 s, in which half of the way is lost.
    assert T[:2, 3] == pytest.approx([1.0 + 0.2 * 3.0 - 0.01, 1.5], abs=2e-4)
    assert room.wheel_travel == pytest.approx((0.59, 0.59), abs=2e-4)
    assert room.contacts.cliffs == (False, False, False, False)


def test_opposite_wheels_turn_on_the_spot(room):
    driven(room, -0.1, 0.1, 3.0)
    expected = (room.wheel_travel[1] - room.wheel_travel[0]) / 0.235
    assert yaw_of(room.T_world_base) == pytest.approx(expected)
    assert room.T_world_base[:2, 3] == pytest.approx([1.0, 1.5], abs=1e-9)


def test_a_wall_stops_the_body_while_the_wheels_go_on(room):
    driven(room, 0.3, 0.3, 12.0)
    x, y = room.T_world_base[:2, 3]
    assert x == pytest.approx(4.0 - 0.012 - 0.175, abs=0.02)
    assert y == pytest.approx(1.5, abs=1e-6)
    assert room.wheel_travel[0] == pytest.approx(0.3 * 12.0, abs=0.05)
    assert room.contacts.bump_left
    assert room.contacts.bump_right
    assert room.collisions == 1
    driven(room, -0.1, -0.1, 1.0)
    assert not room.contacts.bump_left
    assert not room.contacts.bump_right
    assert room.T_world_base[0, 3] < x - 0.05


@pytest.mark.parametrize(("side", "pressed"), [(0.12, (True, False)), (-0.12, (False, True))])
def test_the_bumper_says_on_which_side_it_touches(side, pressed):
    post = box((2.0, 1.5 + side, 0), (0.04, 0.04, 0.3), GREY)
    with World(house(post), EXACT) as world:
        driven(world, 0.2, 0.2, 8.0)
        assert (world.contacts.bump_left, world.contacts.bump_right) == pressed
        assert world.T_world_base[0, 3] < 2.0


def test_a_touch_from_behind_blocks_but_presses_nothing(room):
    driven(room, -0.3, -0.3, 6.0)
    assert room.T_world_base[0, 3] == pytest.approx(0.012 + 0.175, abs=0.02)
    assert not room.contacts.bump_left
    assert not room.contacts.bump_right
    assert room.collisions == 1


def test_the_base_passes_under_a_table_that_its_mast_does_not():
    top = box((2.5, 1.5, 0.4), (0.8, 0.8, 0.04), GREY)
    with World(house(top), EXACT) as world:
        driven(world, 0.3, 0.3, 8.0)
        # The mast stands 5 cm ahead of the axle and is 12 cm thick.
        assert world.T_world_base[0, 3] == pytest.approx(2.1 - 0.05 - 0.06, abs=0.02)
        assert world.contacts.bump_left
    low_mast = planar(0.05, 0, 0)
    low_mast[2, 3] = 0.2
    with World(house(top), EXACT, T_base_cam=low_mast) as world:
        driven(world, 0.3, 0.3, 8.0)
        assert world.T_world_base[0, 3] > 3.0


def test_the_floor_ends_at_a_cliff_and_a_wheel_over_it_drops():
    platform = flat_panel((0, 0, 0), (2, 0, 0), (0, 3, 0), GREY)
    pit = House((ROOM.room,), (platform,), (), np.array([[1.0, 1.5, 2.0]]), (1.0, 1.5, 0.0))
    with World(pit, EXACT) as world:
        assert world.contacts.cliffs == (False, False, False, False)
        world.place(1.90, 1.5, 0.0)
        assert world.contacts.cliffs == (False, True, True, False)
        world.place(1.90, 1.5, pi / 2)
        assert world.contacts.cliffs == (False, False, False, True)
        assert world.contacts.wheel_drops == (False, True)
        driven(world, 0.2, 0.2, 1.0)
        assert world.T_world_base[:2, 3] == pytest.approx([1.90, 1.5])


def test_a_body_put_into_an_obstacle_can_leave_it(room):
    room.place(3.9, 1.5, 0.0)
    assert room.contacts.bump_left
    driven(room, -0.2, -0.2, 3.0)
    assert room.T_world_base[0, 3] < 3.6


def test_wheels_slip_by_the_seed():
    def ends(seed):
        with World(house(), WorldConfig(), seed=seed) as world:
            return driven(world, 0.2, 0.2, 5.0).T_world_base

    first = ends(1)
    assert np.array_equal(first, ends(1))
    assert not np.array_equal(first, ends(2))
    assert first[0, 3] == pytest.approx(1.99, abs=0.05)


def test_the_motion_record_adds_up_to_the_motion(room):
    driven(room, 0.1, 0.2, 2.0)
    seconds, speed, yaw_rate = room.drain_motion().T
    assert seconds.sum() == pytest.approx(2.0, abs=0.015)
    assert (yaw_rate * seconds).sum() == pytest.approx(yaw_of(room.T_world_base))
    assert (speed * seconds).sum() == pytest.approx(sum(room.wheel_travel) / 2, rel=1e-3)
    assert len(room.drain_motion()) == 0


def test_depth_is_metric_and_registered_to_the_truth(room):
    room.place(2.0, 1.5, 0.4)
    rgb, depth = room.render()
    assert rgb.shape == (480, 640, 3)
    points = transform(room.T_world_base @ room.T_base_cam, back_project(depth, room.intrinsics))
    ceiling = np.abs(points[..., 2] - 2.5) < 1e-2
    assert not ceiling.all()
    # Everything in an empty room lies on floor, wall or skirting, which is 12 mm thick.
    off_walls = np.minimum(points[..., 0], 4 - points[..., 0])
    off_walls = np.minimum(off_walls, np.minimum(points[..., 1], 3 - points[..., 1]))
    off = np.minimum(off_walls, np.abs(points[..., 2]))
    assert (depth > 0).all()
    assert off.max() < 0.0125
    assert np.median(np.abs(off)) < 1e-4


def test_segmentation_shows_an_instance_where_it_stands():
    chair = procedural.piece("chair", np.random.default_rng(0))
    at = Instance("chair#1", chair, 2.5, 1.5, 0.0)
    with World(house(instances=(at,)), EXACT) as world:
        shown = world.segment() == 0
        _, depth = world.render()
        assert shown.sum() > 5000
        assert 1.0 < np.median(depth[shown]) < 1.7
        assert 200 < np.nonzero(shown)[1].mean() < 440
        assert not (world.segment(turn=pi) == 0).any()


def test_the_plan_from_above_looks_through_the_ceiling():
    red = box((1.0, 0.75, 0), (1.0, 0.6, 0.4), (0.9, 0.05, 0.05))
    with World(house(red), EXACT) as world:
        plan = world.top_view().astype(int)
        rows, columns = np.nonzero((plan[..., 0] > 60) & (plan[..., 0] > 3 * plan[..., 1]))
        assert len(rows) > 500
        assert rows.mean() > plan.shape[0] / 2
        assert columns.mean() < plan.shape[1] / 2


@pytest.mark.slow
def test_pictures_do_not_change_between_two_worlds_of_one_seed():
    pictures = []
    for _ in range(2):
        with open_world("2", WorldConfig()) as world:
            pictures.append(world.render())
    assert np.array_equal(pictures[0][0], pictures[1][0])
    assert np.array_equal(pictures[0][1], pictures[1][1])
    assert 60 < pictures[0][0].mean() < 200


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1000])
def test_the_goal_cannot_be_seen_from_the_start(seed):
    with open_world(str(seed), WorldConfig(), text="yellow chair") as world:
        goal = [i.label for i in world.instances].index("yellow chair")
        for turn in np.arange(12) * pi / 6:
            assert not (world.segment(float(turn)) == goal).any()


@pytest.mark.slow
def test_a_world_starts_far_from_what_it_will_be_asked_for():
    with open_world("1000", WorldConfig(), text="the couch") as world:
        x, y = world.T_world_base[:2, 3]
        sofas = [i for i in world.instances if i.label == "sofa"]
        assert sofas and all(distance_to(sofa, x, y) > 3.0 for sofa in sofas)
        assert world.contacts == Contacts()
        assert world.notice == "world 1000: a home with held-out furniture, floors and walls"


@pytest.mark.slow
def test_a_goal_that_the_start_is_not_far_from_is_told():
    with open_world("1000", WorldConfig(), text="red unicorn") as world:
        about, start = world.notice.splitlines()
        assert "held-out" in about
        assert "called 'red unicorn'" in start and "starts anywhere" in start
        assert tuple(world.T_world_base[:2, 3]) == world.house.start[:2]


UNKNOWN = r"unknown world .*; give a seed"


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        *((spec, UNKNOWN) for spec in ("attic", "-1", "", "1.5", "²")),
        pytest.param(
            5000 * "1", r"world 111111111\.\.\.: a seed has 18 digits at most", id="digits"
        ),
    ],
)
def test_an_unknown_world_is_one_line(spec, said):
    with pytest.raises(ConfigError, match=said) as raised:
        open_world(spec, WorldConfig())
    assert "\n" not in str(raised.value)


def test_a_closed_world_says_so():
    world = World(house(), EXACT)
    world.close()
    world.close()
    with pytest.raises(DeviceError, match="closed"):
        world.render()


def test_a_world_that_nobody_closed_spoils_no_other():
    abandoned = World(house(), EXACT)
    abandoned.render()
    with World(house(), EXACT) as world:
        before = world.render()
        del abandoned
        after = world.render()
    assert np.array_equal(before[0], after[0])
    assert np.array_equal(before[1], after[1])
    assert before[0].std() > 10


def test_a_machine_without_opengl_is_told_what_to_install(monkeypatch):
    from sim_stubs.world import renderer

    monkeypatch.setattr(renderer, "_CHOSEN", {})
    monkeypatch.setattr(renderer.ctypes.util, "find_library", lambda name: None)
    with pytest.raises(DeviceError, match="apt-get install libegl1 libgl1"):
        renderer._platform()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "value"),
    [("MUJOCO_GL", "glfw"), ("MUJOCO_GL", "osmesa"), ("PYOPENGL_PLATFORM", "osmesa"),
     ("MUJOCO_GL", "\x1b[31mred")],
)  # fmt: skip
def test_a_variable_that_makes_rendering_fail_is_named_to_be_unset(tmp_path, name, value):
    command = [sys.executable, "-m", "vizbot", "stub", "realsense", "--world", "3"]
    unset = {key: each for key, each in os.environ.items() if "GL" not in key}
    done = subprocess.run(
        [*command, "--out", "home.db3", "--seconds", "0.1"],
        env=unset | {name: value, "PYTHONPATH": str(ROOT)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode == 0:
        pytest.skip(f"this machine renders with {name}={value}")
    line = done.stderr.splitlines()[-1]
    shown = value if value.isprintable() else ascii(value)
    assert f"with {name}={shown}, which is set here" in line and line.endswith(f"unset {name}")
    assert line.isprintable()
