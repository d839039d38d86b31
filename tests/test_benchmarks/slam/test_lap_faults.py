"""Sensors that fail in the middle of a recording."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.slam import sensor_faults
from benchmarks.slam.replays import ReplayFrame
from benchmarks.slam.sensor_faults import DISTANCE, Span, WhiteWall
from vizbot.config import Config
from vizbot.core.geometry import planar, yaw_of
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

CAMERA = Intrinsics(64, 48, 60.0, 60.0, 31.5, 23.5)
MOUNT = Config().mount.T_base_cam
DURING = Span(1.0, 2.0)


def moments(count=15, rate=5.0):
    """A robot that goes ahead by 0.1 m and turns by 0.02 rad from frame to frame."""
    T = np.eye(4)
    for i in range(count):
        stamp = 100.0 + i / rate
        imu = ImuSamples(
            np.array([stamp]), np.full((1, 3), 0.5), np.array([stamp]), np.ones((1, 3))
        )
        rgb = np.full((48, 64, 3), 120, np.uint8)
        frame = RGBDFrame(stamp, rgb, np.full((48, 64), 2.0, np.float32), CAMERA, imu)
        yield ReplayFrame(frame, T, T @ MOUNT)
        T = T @ planar(0.1, 0.0, 0.02)


def with_fault(fault):
    return list(fault(moments()))


def steps(run):
    """Way [m] and turn [rad] between moments by the wheels."""
    moved = [np.linalg.inv(a.T_odom_base) @ b.T_odom_base for a, b in pairwise(run)]
    return np.array([[T[0, 3], yaw_of(T)] for T in moved])


def test_in_the_dark_colour_is_noise_and_depth_is_there():
    run = with_fault(sensor_faults.dark(DURING))
    assert [moment.frame.rgb.mean() < 10 for moment in run] == [5 <= i < 10 for i in range(15)]
    assert all((moment.frame.depth == 2).all() for moment in run)


def before_wall(*Ts_world_cam, fault=None):
    """What a white wall shows to a camera at these poses, 0.2 s apart."""
    run = [
        replace(moment, T_world_cam=T)
        for moment, T in zip(moments(len(Ts_world_cam)), Ts_world_cam, strict=True)
    ]
    fault = fault or sensor_faults.white_wall(Span(0.0, 9.0))
    return [moment.frame for moment in fault(run)]


def shifted(x, z=0.0):
    """A camera to the right [m] and ahead [m] of the origin."""
    T = np.eye(4)
    T[0, 3], T[2, 3] = x, z
    return T


def test_a_white_wall_is_bright_and_measured_close_before_the_camera():
    run, untouched = with_fault(sensor_faults.white_wall(DURING)), list(moments())
    for i, (moment, before) in enumerate(zip(run, untouched, strict=True)):
        same = (
            (moment.frame.rgb == before.frame.rgb).all(),
            (moment.frame.depth == before.frame.depth).all(),
        )
        assert same == ((False, False) if 5 <= i < 10 else (True, True))
    first = run[5].frame
    assert 170 < first.rgb.mean() < 250
    assert (first.depth > 0).all()
    assert np.median(first.depth) == pytest.approx(DISTANCE, rel=0.05)


def test_a_white_wall_is_another_experiment_than_darkness():
    wall, dark = (
        with_fault(fault(DURING))[5].frame
        for fault in (sensor_faults.white_wall, sensor_faults.dark)
    )
    assert wall.rgb.mean() - dark.rgb.mean() > 150
    assert np.abs(wall.depth - dark.depth).min() > 1.0


def test_a_wall_has_shading_a_shadow_a_switch_and_a_skirting_board():
    camera = Intrinsics(640, 480, 617.0, 617.0, 319.5, 239.5)
    wall = WhiteWall(np.eye(4), np.array([0.1, -0.05]), -0.15)
    unseen = np.zeros((480, 640, 3), np.uint8), np.zeros((480, 640), np.float32)
    frame = RGBDFrame(0.0, *unseen, camera, ImuSamples.none())
    grey = wall.seen(frame, np.eye(4), np.random.default_rng(0)).rgb.mean(axis=2)

    def bright(x, y, size=0.008):
        """Mean brightness around a place on the wall [m]."""
        u, v, half = (round(f) for f in (617 * x / 0.6 + 319.5, 617 * y / 0.6 + 239.5, 617 * size))
        return grey[v - half : v + half + 1, u - half : u + half + 1].mean()

    assert bright(0.0, 0.05) - bright(0.28, 0.05) > 5
    assert bright(-0.02, 0.05) - bright(-0.25, 0.05) > 20
    assert bright(0.1, -0.05) - bright(0.1, 0.05) > 5
    column = grey[:, 250:390].mean(axis=1)
    edge = round(617 * 0.16 / 0.6 + 239.5)
    assert np.argmin(column) == pytest.approx(edge, abs=2)
    assert column[edge + 15] - column[edge - 15] > 5


def test_a_wall_stands_still_while_the_camera_moves_little():
    ahead, closer = before_wall(shifted(0.0), shifted(0.0, 0.2))
    assert np.median(ahead.depth) == pytest.approx(0.6, rel=0.05)
    assert np.median(closer.depth) == pytest.approx(0.4, rel=0.05)
    step = 0.6 * 5 / CAMERA.fx
    still, moved = (frame.rgb.astype(float) for frame in before_wall(shifted(0.0), shifted(step)))
    still, moved = (rgb / rgb.mean() for rgb in (still, moved))
    assert np.abs(still[:, 5:] - moved[:, :-5]).mean() < 0.5 * np.abs(still - moved).mean()


def test_another_wall_stands_before_a_camera_that_has_moved_on():
    frames = before_wall(shifted(0.0), shifted(0.0, 0.3))
    assert [np.median(frame.depth) for frame in frames] == pytest.approx([0.6, 0.6], rel=0.05)
    for turn, is_new in ((0.3, False), (0.6, True)):
        T = np.eye(4)
        T[:3, :3] = Rotation.from_euler("y", turn).as_matrix()
        columns = before_wall(np.eye(4), T)[1].depth.mean(axis=0)
        assert (np.ptp(columns) < 0.05) == is_new


def test_each_replay_has_walls_of_its_own():
    fault = sensor_faults.white_wall(Span(0.0, 9.0))
    for T in (shifted(0.0), shifted(0.0, 0.2)):
        (frame,) = before_wall(T, fault=fault)
        assert np.median(frame.depth) == pytest.approx(0.6, rel=0.05)


def test_slipping_wheels_count_more_than_the_robot_moves_and_stay_off():
    run = with_fault(sensor_faults.slipping(DURING, 0.2))
    slipped = np.array([4 <= i < 9 for i in range(14)])
    assert steps(run)[slipped] == pytest.approx(np.tile([0.12, 0.024], (5, 1)))
    assert steps(run)[~slipped] == pytest.approx(np.tile([0.1, 0.02], (9, 1)))
    truth = list(moments())
    assert all((a.T_world_cam == b.T_world_cam).all() for a, b in zip(run, truth, strict=True))


def test_stuck_wheels_say_that_the_robot_stands():
    run = with_fault(sensor_faults.wheels_stuck(DURING))
    assert steps(run)[4:9] == pytest.approx(np.zeros((5, 2)), abs=1e-12)


def test_a_gyroscope_falls_silent_or_lies_for_a_while():
    silent = with_fault(sensor_faults.gyro_off(DURING))
    assert [len(moment.frame.imu.gyro) for moment in silent] == [1] * 5 + [0] * 5 + [1] * 5
    lying = with_fault(sensor_faults.gyro_biased(DURING, 0.1))
    read = [moment.frame.imu.gyro[0, 2] for moment in lying]
    assert read == pytest.approx([0.5] * 5 + [0.6] * 5 + [0.5] * 5)


def test_a_kidnapped_robot_feels_nothing_of_it():
    run = list(sensor_faults.kidnapped(DURING)(moments()))
    assert len(run) == 10
    felt = steps(run)
    assert felt[4] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert np.delete(felt, 4, axis=0) == pytest.approx(np.tile([0.1, 0.02], (8, 1)))
    carried = run[5].T_world_cam[:2, 3] - run[4].T_world_cam[:2, 3]
    assert np.linalg.norm(carried) > 0.5


@pytest.mark.parametrize(
    "fault",
    [
        sensor_faults.dark(DURING),
        sensor_faults.white_wall(DURING),
        sensor_faults.slipping(DURING, 0.2),
        sensor_faults.wheels_stuck(DURING),
        sensor_faults.gyro_off(DURING),
        sensor_faults.gyro_biased(DURING, 0.1),
    ],
)
def test_frames_know_whether_the_fault_acts_on_them(fault):
    assert [moment.faulty for moment in with_fault(fault)] == [5 <= i < 10 for i in range(15)]


def test_being_carried_ends_with_the_first_frame_thereafter():
    run = with_fault(sensor_faults.kidnapped(DURING))
    assert [moment.faulty for moment in run] == [i == 5 for i in range(10)]


def test_the_corridor_is_the_fault_between_two_homes():
    run = list(sensor_faults.twins(moments(), moments(), 4.0, Config(), 7))
    assert [moment.faulty for moment in run] == [15 <= i < len(run) - 15 for i in range(len(run))]


def test_through_the_corridor_the_gyroscope_reads_what_it_read_at_rest():
    standing = [replace(moment, T_odom_base=np.eye(4)) for moment in moments()]
    run = list(sensor_faults.twins(standing, moments(), 4.0, Config(), 7))
    for moment in run[15:-15]:
        imu = moment.frame.imu
        assert imu.gyro == pytest.approx(standing[1].frame.imu.gyro)
        assert imu.gyro_stamps == pytest.approx([moment.frame.stamp])


def test_two_homes_that_look_the_same_lie_a_dark_corridor_apart():
    run = list(sensor_faults.twins(moments(), moments(), 4.0, Config(), 7))
    stamps = np.array([moment.frame.stamp for moment in run])
    assert np.diff(stamps) == pytest.approx(np.full(len(run) - 1, 0.2))
    lit = [moment.frame.rgb.mean() > 100 for moment in run]
    assert lit == [True] * 15 + [False] * (len(run) - 30) + [True] * 15
    true = np.linalg.inv(run[14].T_world_cam) @ run[-16].T_world_cam
    assert np.linalg.norm(true[:3, 3]) == pytest.approx(4.0)
    for first, again in zip(run[:15], run[-15:], strict=True):
        apart = again.T_world_cam[:2, 3] - first.T_world_cam[:2, 3]
        assert np.linalg.norm(apart) > 2.0
        imu = again.frame.imu
        assert np.abs(imu.gyro_stamps - again.frame.stamp).max() < 1e-6


@pytest.mark.parametrize(
    ("scale", "slip", "wheel"), [(0.003, 0.0, 0.012), (0.0, 0.003, 0.006), (0.0, 0.0, 0.0)]
)
def test_wheels_err_in_the_corridor_as_the_simulated_ones_do(scale, slip, wheel):
    config = Config.model_validate({"world": {"wheel_scale_noise": scale, "slip_noise": slip}})
    counted = []
    for seed in range(30):
        run = list(sensor_faults.twins(moments(2), moments(2), 4.0, config, seed))
        T = np.linalg.inv(run[1].T_odom_base) @ run[-3].T_odom_base
        counted.append((T[0, 3], yaw_of(T)))
    forward, turned = np.array(counted).T
    # Of 4 m each wheel is off by `wheel` [m] (standard deviation); their difference turns.
    assert turned.std() == pytest.approx(np.sqrt(2) * wheel / 0.235, rel=0.3, abs=1e-9)
    assert forward == pytest.approx(np.full(30, 4.0), abs=5 * wheel + 1e-9)


def test_no_image_of_the_twin_repeats_bit_for_bit():
    run = list(sensor_faults.twins(moments(), moments(), 4.0, Config(), 7))
    made = [moment.frame for moment in run[14:]]
    for image in ("rgb", "depth"):
        assert len({getattr(frame, image).tobytes() for frame in made}) == len(made)
    first, again = run[0].frame, run[-15].frame
    assert np.abs(again.rgb.astype(float) - first.rgb).mean() < 10
    assert np.median(again.depth) == pytest.approx(np.median(first.depth), rel=0.1)


def test_holes_of_depth_stay_where_they_are_in_the_twin():
    def holed():
        for moment in moments():
            depth = moment.frame.depth.copy()
            depth[10:20, 30:50] = 0.0
            yield replace(moment, frame=replace(moment.frame, depth=depth))

    last = list(sensor_faults.twins(holed(), holed(), 4.0, Config(), 7))[-1].frame
    hole = np.zeros(last.depth.shape, bool)
    hole[10:20, 30:50] = True
    assert ((last.depth == 0) == hole).all()


def test_a_twin_is_the_same_again_with_its_seed_and_another_with_another():
    once, again, other = (
        list(sensor_faults.twins(moments(), moments(), 4.0, Config(), seed))[-1]
        for seed in (7, 7, 8)
    )
    assert (once.frame.rgb == again.frame.rgb).all()
    assert (once.T_odom_base == again.T_odom_base).all()
    assert (once.frame.depth != other.frame.depth).any()
    assert (once.T_odom_base != other.T_odom_base).any()
