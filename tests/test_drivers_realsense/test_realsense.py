"""The RealSense driver through the real SDK: recordings and live software devices."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from drivers.realsense.camera import RealSense
from drivers.realsense.config import RealSenseConfig
from drivers.realsense.playback import RealSenseRecording
from sim_stubs.realsense.software_device import DEPTH, SensorPoses, SoftwareD435i
from tests.helpers.d435i_frames import (
    ANY,
    FRAMES,
    LIVE,
    R_QUARTER,
    SERIAL,
    START,
    colour,
    depth_mm,
    in_another_process,
    push_frames,
    read_all,
    stamp_of,
)
from vizbot.core.clock import WallClock
from vizbot.core.errors import ConfigError


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("realsense") / "home.db3"
    device = SoftwareD435i(poses=SensorPoses(R_depth_imu=R_QUARTER))
    with device.record(path):
        push_frames(device, range(FRAMES))
    return path


@pytest.fixture(scope="module")
def frames(recording):
    with RealSenseRecording(ANY, recording) as camera:
        return read_all(camera)


@pytest.mark.slow
def test_a_recording_comes_back_frame_exact(frames):
    assert len(frames) == FRAMES
    for index, frame in enumerate(frames):
        assert frame.stamp == pytest.approx(stamp_of(index), abs=1e-6)
        np.testing.assert_array_equal(frame.rgb, colour(index))
        np.testing.assert_allclose(frame.depth, depth_mm(index) / 1000.0, atol=1e-6)
    assert frames[0].rgb.dtype == np.uint8
    assert frames[0].depth.dtype == np.float32


def test_intrinsics_are_those_of_the_colour_camera(frames):
    intrinsics = frames[0].intrinsics
    assert (intrinsics.width, intrinsics.height) == (640, 480)
    found = intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy
    assert found == (610.0, 610.0, 322.0, 243.0)


def test_the_imu_of_a_recording_is_complete_and_in_order(frames):
    gyro = np.concatenate([frame.imu.gyro for frame in frames])
    accel = np.concatenate([frame.imu.accel for frame in frames])
    gyro_stamps = np.concatenate([frame.imu.gyro_stamps for frame in frames])
    accel_stamps = np.concatenate([frame.imu.accel_stamps for frame in frames])
    # The first component, which counts the samples, is the second one in the axes of the camera.
    np.testing.assert_array_equal(gyro[:, 1], np.arange(len(gyro)))
    np.testing.assert_array_equal(accel[:, 1], np.arange(len(accel)))
    seconds = stamp_of(FRAMES - 1) - START + 0.01
    assert len(gyro) == pytest.approx(200 * seconds, abs=2)
    assert len(accel) == pytest.approx(100 * seconds, abs=2)
    np.testing.assert_allclose(np.diff(gyro_stamps), 0.005, atol=1e-5)
    np.testing.assert_allclose(np.diff(accel_stamps), 0.01, atol=1e-5)


def test_imu_samples_are_turned_into_the_axes_of_the_camera(frames):
    np.testing.assert_allclose(frames[0].imu.gyro[1], R_QUARTER @ (1.0, 1.0, 2.0), atol=1e-6)


def test_a_frame_carries_the_imu_samples_since_the_one_before(frames):
    for before, frame in itertools.pairwise(frames):
        for stamps in (frame.imu.gyro_stamps, frame.imu.accel_stamps):
            assert len(stamps) > 0
            assert before.stamp < stamps[0]
            assert stamps[-1] <= frame.stamp


@pytest.mark.slow
def test_a_recording_plays_the_same_every_time(recording, frames):
    for _ in range(3):
        with RealSenseRecording(ANY, recording) as camera:
            again = read_all(camera)
        assert [f.stamp for f in again] == [f.stamp for f in frames]
        assert [len(f.imu.gyro) for f in again] == [len(f.imu.gyro) for f in frames]


def test_reading_on_after_the_end_gives_none(recording):
    with RealSenseRecording(ANY, recording) as camera:
        read_all(camera)
        assert camera.read() is None
        assert camera.read() is None


def test_without_imu_a_recording_gives_images_alone(recording):
    with RealSenseRecording(RealSenseConfig(imu=False), recording) as camera:
        frames = read_all(camera)
    assert len(frames) == FRAMES
    assert sum(len(frame.imu.gyro) for frame in frames) == 0


@pytest.mark.parametrize("start", [0.0, START])
def test_a_recording_whose_imu_never_spoke_plays_and_its_stamps_may_start_at_zero(tmp_path, start):
    device = SoftwareD435i()
    with device.record(tmp_path / "silent.db3"):
        for index in range(10):
            device.push_frame(colour(index), depth_mm(index), start + index / 30)
    with RealSenseRecording(ANY, tmp_path / "silent.db3") as camera:
        stamps = [frame.stamp for frame in read_all(camera)]
    np.testing.assert_allclose(stamps, start + np.arange(10) / 30, rtol=0, atol=1e-6)


@pytest.mark.slow
def test_a_recording_can_be_closed_at_any_point(recording):
    for count in range(4):
        camera = RealSenseRecording(ANY, recording)
        for _ in range(count):
            assert camera.read() is not None
        camera.close()
        camera.close()


def test_a_program_that_forgets_to_close_ends_well(recording):
    run = in_another_process(
        f"""
from pathlib import Path
from drivers.realsense.config import RealSenseConfig
from drivers.realsense.playback import RealSenseRecording
camera = RealSenseRecording(RealSenseConfig(), Path({str(recording)!r}))
print(camera.read().stamp)
"""
    )
    assert run.returncode == 0, run.stderr
    assert float(run.stdout) == pytest.approx(START)


@pytest.mark.parametrize("baseline", [0.0, 0.015])
def test_depth_is_moved_to_the_colour_camera(baseline):
    T_color_depth = np.eye(4)
    T_color_depth[0, 3] = baseline
    device = SoftwareD435i(
        depth=DEPTH, serial=SERIAL, poses=SensorPoses(T_color_depth=T_color_depth)
    )
    context = device.plug_in()
    with RealSense(LIVE, WallClock(), context) as camera:
        device.push_frame(colour(0), depth_mm(0), START)
        depth = camera.read().depth
    # Outer edges of the box, columns 200 and 340 of the depth image, half a pixel out, at 1 m.
    left, right = (
        ((edge - 0.5 - DEPTH.cx) / DEPTH.fx + baseline) * 610.0 + 322.0 for edge in (200, 340)
    )
    box = np.flatnonzero(depth[243] == np.float32(1.0))
    assert box[0] == pytest.approx(left, abs=1.5)
    assert box[-1] == pytest.approx(right, abs=1.5)
    assert depth[243, 560] == np.float32(2.0)


def test_a_torn_recording_is_refused_in_one_line(recording, tmp_path):
    torn = tmp_path / "torn.db3"
    torn.write_bytes(recording.read_bytes()[:-5000])
    with pytest.raises(ConfigError, match=r"torn\.db3: cut short") as error:
        RealSenseRecording(ANY, torn)
    assert "\n" not in str(error.value)


def test_what_the_sdk_refuses_is_one_line_too(tmp_path):
    bag = tmp_path / "odd.bag"
    bag.write_bytes(b"#ROSBAG V2.0\n" + b"index_pos=" + (64).to_bytes(8, "little") + bytes(64))
    with pytest.raises(ConfigError, match=r"odd\.bag: cannot be played") as error:
        RealSenseRecording(ANY, bag)
    assert "\n" not in str(error.value)


def test_a_recording_that_fails_leaves_no_file(tmp_path):
    device = SoftwareD435i()
    with pytest.raises(ZeroDivisionError), device.record(tmp_path / "home.db3"):
        device.push_frame(colour(0), depth_mm(0), START)
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == []


def test_the_sdk_imports_where_the_system_has_no_libusb():
    # The system's library, where there is one, is made unfindable for the preload; the linker then
    # takes the one from the wheel, and the process maps no other.
    code = """
import ctypes
load = ctypes.CDLL
def hide(name, *arguments, **options):
    if name == "libusb-1.0.so.0":
        raise OSError("hidden")
    return load(name, *arguments, **options)
ctypes.CDLL = hide
from drivers.realsense.sdk import rs
assert rs.context
maps = open("/proc/self/maps").read().split()
print(*{path for path in maps if "libusb" in path}, sep=";")
"""
    run = in_another_process(code)
    assert run.returncode == 0, run.stderr
    assert [Path(path).parent.name for path in run.stdout.strip().split(";")] == ["libusb_package"]
