"""The RealSense driver with live software devices."""

import time

import numpy as np
import pytest

from drivers.realsense.camera import RealSense
from drivers.realsense.config import RealSenseConfig
from drivers.realsense.sdk import rs
from sim_stubs.realsense.software_device import SoftwareD435i
from tests.helpers.d435i_frames import ANY, LIVE, SERIAL, START, colour, depth_mm, opened, stamp_of
from tests.helpers.failing import raising
from vizbot.core.clock import WallClock
from vizbot.core.errors import DeviceError, DeviceTimeoutError


@pytest.fixture
def plugged():
    """A software camera and the context that lists it."""
    device = SoftwareD435i(serial=SERIAL)
    return device, device.plug_in()


def test_a_live_camera_gives_frames_and_imu(plugged):
    device, context = plugged
    with RealSense(LIVE, WallClock(), context) as camera:
        stamps = []
        for index in range(5):
            device.push_gyro((0.1, 0.2, 0.3), stamp_of(index) - 0.005)
            device.push_gyro((0.1, 0.2, 0.3), stamp_of(index) + 0.005)
            device.push_accel((0.0, -9.8, 0.0), stamp_of(index) - 0.001)
            device.push_frame(colour(index), depth_mm(index), stamp_of(index))
            frame = camera.read(timeout=2.0)
            np.testing.assert_array_equal(frame.rgb, colour(index))
            np.testing.assert_allclose(frame.depth, depth_mm(index) / 1000.0, atol=1e-6)
            np.testing.assert_allclose(frame.imu.accel, [[0.0, -9.8, 0.0]], atol=1e-6)
            stamps.extend(frame.imu.gyro_stamps)
    # All but the one that is younger than the last frame.
    assert len(stamps) == 9
    assert np.all(np.diff(stamps) > 0)


def test_without_a_serial_the_first_camera_is_taken(plugged):
    device, context = plugged
    with RealSense(RealSenseConfig(first_frame_timeout=2.0), WallClock(), context) as camera:
        device.push_frame(colour(0), depth_mm(0), START)
        assert camera.read() is not None


def test_a_camera_that_stalls_is_a_timeout(plugged):
    device, context = plugged
    with RealSense(LIVE, WallClock(), context) as camera:
        device.push_frame(colour(0), depth_mm(0), START)
        camera.read()
        with pytest.raises(
            DeviceTimeoutError, match=rf"RealSense {SERIAL}: no frame within 0\.1 s"
        ):
            camera.read(timeout=0.1)
        device.push_frame(colour(1), depth_mm(1), stamp_of(1))
        assert camera.read(timeout=2.0).stamp == pytest.approx(stamp_of(1))


def test_the_first_frame_is_waited_for_longer(plugged):
    _, context = plugged
    config = RealSenseConfig(serial=SERIAL, first_frame_timeout=0.3)
    with RealSense(config, WallClock(), context) as camera:
        begin = time.monotonic()
        with pytest.raises(DeviceTimeoutError):
            camera.read(timeout=0.01)
        assert time.monotonic() - begin > 0.25


@pytest.mark.parametrize(
    ("seconds", "warnings"), [({"system_time": 9}, 1), ({"hardware_clock": 4, "global_time": 9}, 0)]
)
def test_stamps_that_stay_on_another_clock_are_logged_once(caplog, seconds, warnings):
    device = SoftwareD435i(serial=SERIAL)
    with opened(device) as (camera, clock, _):
        for domain in (name for name, count in seconds.items() for _ in range(count)):
            device.domain = getattr(rs.timestamp_domain, domain)
            device.push_frame(colour(0), depth_mm(0), START + clock.now())
            camera.read()
            clock.sleep(1.0)
    told = [line for line in caplog.messages if "stamped in system_time, not in global" in line]
    assert len(told) == len(caplog.messages) == warnings


def test_without_a_camera_the_remedy_is_named_at_once():
    context = rs.context()
    if list(context.query_devices()):
        pytest.skip("a RealSense camera is connected")
    begin = time.monotonic()
    with pytest.raises(DeviceError, match=r"no RealSense camera found.*USB 3.*udev"):
        RealSense(ANY, WallClock(), context)
    assert time.monotonic() - begin < 1.0


def test_a_serial_that_is_not_there_names_those_that_are(plugged):
    _, context = plugged
    begin = time.monotonic()
    with pytest.raises(DeviceError, match=f"RealSense 123: not found.*{SERIAL}.*set serial"):
        RealSense(RealSenseConfig(serial="123"), WallClock(), context)
    assert time.monotonic() - begin < 1.0


def test_a_mode_that_the_camera_lacks_is_named(plugged):
    _, context = plugged
    with pytest.raises(DeviceError, match="1280x720 at 30/s"):
        RealSense(RealSenseConfig(serial=SERIAL, width=1280, height=720), WallClock(), context)


def test_a_camera_in_use_is_refused(plugged):
    _, context = plugged
    with (
        RealSense(LIVE, WallClock(), context),
        pytest.raises(DeviceError, match="close other programs"),
    ):
        RealSense(LIVE, WallClock(), context)


def test_opening_that_fails_half_way_leaves_nothing_open(plugged, monkeypatch):
    device, context = plugged
    with monkeypatch.context() as broken:
        broken.setattr(
            "drivers.realsense.streams.RealSenseImu", raising(RuntimeError("no motion today"))
        )
        with pytest.raises(DeviceError, match="no motion today"):
            RealSense(LIVE, WallClock(), context)
    with RealSense(LIVE, WallClock(), context) as camera:
        device.push_frame(colour(0), depth_mm(0), START)
        assert camera.read() is not None
