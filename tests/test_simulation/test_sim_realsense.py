from types import SimpleNamespace

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.textures.patterns import wallpaper
from sim_stubs.realsense.camera import SimulatedRealSense
from sim_stubs.realsense.config import (
    ColourNoiseConfig,
    DepthNoiseConfig,
    InertialConfig,
    SimulatedRealSenseConfig,
)
from sim_stubs.world.body import WorldConfig
from sim_stubs.world.world import World
from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.simulated_clock import SimulatedClock

PAPER = wallpaper(1, (0.8, 0.8, 0.8), (0.4, 0.5, 0.6))
ROOM = RectangularRoom("room", 0, 0, 5, 3, (0.5, 0.4, 0.3), 1.0, PAPER)
HOUSE = House(
    (ROOM.room,), build_structure((ROOM,), ()), (), np.array([[2.5, 1.5, 2.3]]), (1.0, 1.5, 0.0)
)
STILL = WorldConfig(wheel_scale_noise=0.0, slip_noise=0.0)
NO_INERTIAL_NOISE = InertialConfig(
    gyro_noise=0.0, accel_noise=0.0, gyro_bias=0.0, gyro_scale=0.0, accel_bias=0.0
)
EXACT = SimulatedRealSenseConfig(
    rate=5.0,
    depth_noise=DepthNoiseConfig.none(),
    colour_noise=ColourNoiseConfig.none(),
    inertial=NO_INERTIAL_NOISE,
)


def clock_of(world):
    """Time that passes in the world."""
    clock = SimulatedClock()
    clock.attach(SimpleNamespace(publish=lambda: None, advance=world.advance))
    return clock


@pytest.fixture
def world():
    with World(HOUSE, STILL, seed=4) as world:
        yield world


def open_camera(world, config=EXACT):
    return SimulatedRealSense(world, clock_of(world), config)


def test_frames_come_at_their_rate(world):
    with open_camera(world) as camera:
        stamps = [camera.read().stamp for _ in range(11)]
    assert stamps[-1] - stamps[0] == pytest.approx(2.0, abs=0.016)
    assert np.diff(stamps) == pytest.approx(0.2, abs=0.016)


def test_a_caller_who_comes_late_gets_a_new_frame(world):
    clock = clock_of(world)
    camera = SimulatedRealSense(world, clock, EXACT)
    first = camera.read()
    clock.sleep(0.95)
    late = camera.read()
    assert late.stamp > first.stamp + 0.95
    assert camera.read().stamp <= late.stamp + 0.2 + 0.016


def test_no_frame_within_the_timeout_is_an_error_and_the_next_read_goes_on(world):
    camera = open_camera(world)
    with pytest.raises(DeviceTimeoutError, match=r"within 0.05 s"):
        camera.read(timeout=0.05)
    assert camera.read().stamp == pytest.approx(0.2, abs=0.016)


def test_without_noise_the_frame_is_what_the_world_renders(world):
    frame = open_camera(world).read()
    rgb, depth = world.render()
    assert np.array_equal(frame.rgb, rgb)
    assert np.array_equal(frame.depth, depth)
    assert frame.intrinsics == world.intrinsics


def test_imu_samples_have_their_rates_and_follow_without_gaps(world):
    camera = open_camera(world)
    frames = [camera.read() for _ in range(10)]
    gyro = np.concatenate([frame.imu.gyro_stamps for frame in frames])
    accel = np.concatenate([frame.imu.accel_stamps for frame in frames])
    assert np.diff(gyro) == pytest.approx(1 / 200)
    assert np.diff(accel) == pytest.approx(1 / 100)
    for frame in frames:
        assert frame.imu.gyro_stamps[-1] <= frame.stamp + 1e-9
        assert len(frame.imu.gyro) == len(frame.imu.gyro_stamps)


def test_a_camera_at_rest_feels_gravity_in_its_own_axes(world):
    imu = open_camera(world).read().imu
    tilt = 0.15
    expected = 9.80665 * np.array([0.0, -np.cos(tilt), -np.sin(tilt)])
    assert imu.accel == pytest.approx(np.tile(expected, (len(imu.accel), 1)))
    assert imu.gyro == pytest.approx(np.zeros_like(imu.gyro))


def test_the_gyroscope_measures_the_true_turn(world):
    camera = SimulatedRealSense(world, clock_of(world), EXACT)
    world.set_wheel_speeds(-0.1, 0.1)
    frames = [camera.read() for _ in range(10)]
    gyro = np.concatenate([frame.imu.gyro for frame in frames])
    # Left about the vertical is against the camera's y axis, which points down.
    up = -gyro[:, 1] * np.cos(0.15) - gyro[:, 2] * np.sin(0.15)
    turned = np.arctan2(world.T_world_base[1, 0], world.T_world_base[0, 0])
    assert up.sum() / 200 == pytest.approx(turned, abs=0.01)


def test_the_accelerometer_integrates_to_the_speed(world):
    camera = open_camera(world)
    world.set_wheel_speeds(0.3, 0.3)
    accel = np.concatenate([camera.read().imu.accel for _ in range(3)])
    forward = accel[:, 2] * np.cos(0.15) - accel[:, 1] * np.sin(0.15)
    assert forward.sum() / 100 == pytest.approx(0.3, abs=0.03)


def test_in_a_steady_curve_the_accelerometer_points_inwards(world):
    camera = open_camera(world)
    world.set_wheel_speeds(0.1, 0.2)
    for _ in range(3):
        camera.read()
    imu = camera.read().imu
    rate = 0.1 / 0.235
    # Leftwards is against the camera's x axis.
    assert imu.accel[:, 0] == pytest.approx(-0.15 * rate, abs=1e-3)


def test_a_seed_gives_the_same_noise_twice():
    def frames(seed):
        with World(HOUSE, STILL, seed=seed) as world:
            camera = open_camera(world, SimulatedRealSenseConfig())
            return [camera.read() for _ in range(2)]

    first, again, other = frames(1), frames(1), frames(2)
    for one, two in zip(first, again, strict=True):
        assert np.array_equal(one.rgb, two.rgb)
        assert np.array_equal(one.depth, two.depth)
        assert np.array_equal(one.imu.gyro, two.imu.gyro)
        assert np.array_equal(one.imu.accel, two.imu.accel)
    assert not np.array_equal(first[0].depth, other[0].depth)


def test_a_closed_camera_leaves_the_world_open(world):
    open_camera(world).close()
    world.render()


def test_turns_blur_the_picture_and_straight_ways_do_not(world):
    blur = ColourNoiseConfig.none().model_copy(update={"exposure_time": 0.02})
    camera = open_camera(world, EXACT.model_copy(update={"colour_noise": blur}))
    world.place(2.5, 1.5, 0.0)
    world.set_wheel_speeds(0.1, 0.1)
    assert np.array_equal(camera.read().rgb, world.render()[0])
    world.set_wheel_speeds(-0.12, 0.12)
    turning, sharp = camera.read().rgb.astype(float), world.render()[0].astype(float)
    assert np.abs(np.diff(turning, axis=1)).mean() < 0.8 * np.abs(np.diff(sharp, axis=1)).mean()


def test_the_noise_of_a_frame_depends_on_its_time_and_not_on_those_before_it():
    def last(stamps):
        with World(HOUSE, STILL, seed=3) as world:
            clock = clock_of(world)
            steady = ColourNoiseConfig(exposure_control=0.0)
            config = SimulatedRealSenseConfig(rate=5.0, colour_noise=steady)
            camera = SimulatedRealSense(world, clock, config)
            for stamp in stamps:
                clock.sleep(stamp - clock.now())
                frame = camera.read()
            return frame

    one, other = last([0.0, 0.4, 0.75]), last([0.75])
    assert one.stamp == other.stamp
    assert np.array_equal(one.rgb, other.rgb)
    assert np.array_equal(one.depth, other.depth)
