"""What faults do to the simulated camera, seen from the robot's side of it."""

from dataclasses import dataclass

import numpy as np
import pytest

from sim_stubs.faults.catalogue import FaultSchedule, parse_faults
from sim_stubs.faults.faulty_camera import FaultyCamera
from sim_stubs.world.body import FreeFloor
from sim_stubs.world.box_room import CAMERA, BoxCamera
from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.geometry import camera_mount, planar
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import ImuSamples, RGBDFrame


@dataclass
class Eye:
    """A camera in the bare room, with faults."""

    clock: SimulatedClock
    camera: FaultyCamera


def open_eye(faults, T_world_base=None):
    clock = SimulatedClock()
    floor = FreeFloor(T_world_base=T_world_base)
    room = BoxCamera(floor, clock, camera_mount(0.6, 0.05, 0.15), 5.0)
    schedule = FaultSchedule(parse_faults(faults), clock.now, 0)
    return Eye(clock, FaultyCamera(room, clock, schedule, 0))


def test_the_bare_room_has_a_floor_and_walls():
    frame = open_eye("bump@99", planar(8.0, 0.0, 0.0)).camera.read()
    assert frame.depth.shape == (CAMERA.height, CAMERA.width)
    middle = frame.depth[:, CAMERA.width // 2]
    # Level with the lens the wall is 1.95 m before it; in the lowest row the floor is nearer.
    assert middle[36] == pytest.approx(1.95 * np.cos(0.15), abs=0.03)
    assert 0.5 < middle[-1] < 1.2


def test_a_frozen_camera_times_out_and_then_sees_again():
    eye = open_eye("camera-frozen@1+2")
    while eye.clock.now() < 0.99:
        eye.camera.read()
    with pytest.raises(DeviceTimeoutError, match="sends no frames"):
        eye.camera.read()
    assert eye.clock.now() == pytest.approx(2.0, abs=0.05)
    assert eye.camera.read().stamp == pytest.approx(3.0, abs=0.25)


def test_with_the_cable_out_the_inertial_samples_are_lost():
    eye = open_eye("camera-vanishes@1+2")
    stamps, samples = [], []
    while len(stamps) < 10:
        try:
            frame = eye.camera.read()
        except DeviceTimeoutError:
            continue
        stamps.append(frame.stamp)
        samples.append(frame.imu.gyro_stamps)
    gap = int(np.argmax(np.diff(stamps)))
    assert stamps[gap + 1] - stamps[gap] > 1.8
    assert samples[gap + 1].min() > stamps[gap + 1] - 0.25


def test_faults_of_a_recording_go_by_its_own_time():
    clock = SimulatedClock()  # nobody lets time pass

    class Tape:
        intrinsics = CAMERA

        def __init__(self):
            self.stamp = 1000.0

        def read(self, timeout):
            self.stamp += 0.5
            depth = np.ones((4, 4), np.float32)
            rgb = np.zeros((4, 4, 3), np.uint8)
            return RGBDFrame(self.stamp, rgb, depth, CAMERA, ImuSamples.none())

    planned = parse_faults("black-depth@2+1,camera-frozen@4+1")
    schedule = FaultSchedule(planned, lambda: camera.elapsed, 0)
    camera = FaultyCamera(Tape(), clock, schedule, 0, recorded=True)
    frames = [camera.read() for _ in range(10)]
    elapsed = np.array([frame.stamp for frame in frames]) - 1000.5
    black = np.array([not frame.depth.any() for frame in frames])
    assert elapsed[black].tolist() == [2.0, 2.5]
    assert np.diff(elapsed).max() == pytest.approx(1.5)
    assert ((elapsed < 4.0) | (elapsed >= 5.0)).all()


def test_what_a_bad_camera_shows():
    assert not open_eye("black-depth").camera.read().depth.any()
    assert open_eye("overexposed").camera.read().rgb.min() == 255
    holes = np.mean([(open_eye("depth-holes").camera.read().depth == 0.0).mean()])
    assert holes == pytest.approx(0.6, abs=0.15)
    assert len(open_eye("imu-gap").camera.read().imu.gyro) == 0


def test_half_the_rate_loses_no_inertial_samples():
    eye = open_eye("half-rate")
    frames = [eye.camera.read() for _ in range(4)]
    np.testing.assert_allclose(np.diff([frame.stamp for frame in frames]), 0.4, atol=0.02)
    assert {len(frame.imu.gyro) for frame in frames} == {16}
    stamps = np.concatenate([frame.imu.gyro_stamps for frame in frames])
    assert (np.diff(stamps) > 0.0).all()


def test_images_without_their_depth_do_not_come():
    eye = open_eye("unpaired-frames")
    gaps = np.diff([eye.camera.read().stamp for _ in range(12)])
    assert gaps.min() < 0.25
    assert gaps.max() > 0.35


def test_a_clock_that_jumps_and_jumps_back_costs_no_time(caplog):
    eye = open_eye("stamps-jump@1+1")
    frames = [eye.camera.read() for _ in range(15)]
    stamps = np.array([frame.stamp for frame in frames])
    lost = np.diff(stamps) > 0.3  # one, to tell a jump back from a frame that was stuck somewhere
    assert lost.sum() == 1
    np.testing.assert_allclose(np.diff(stamps)[lost], 0.4, atol=0.04)
    np.testing.assert_allclose(np.diff(stamps)[~lost], 0.2, atol=0.04)
    for frame in frames:
        assert (np.abs(frame.imu.gyro_stamps - frame.stamp) < 0.25).all()
    assert caplog.text.count("its clock jumped by") == 2
