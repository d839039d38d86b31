"""An IMU that lies about the time or falls silent, through the SDK's software device."""

import numpy as np
import pytest

from sim_stubs.realsense.software_device import SoftwareD435i
from tests.helpers.d435i_frames import SERIAL, colour, depth_mm, opened, stamp_of

RATES = (0.1, 0.2, 0.3)


@pytest.fixture
def device():
    return SoftwareD435i(serial=SERIAL)


def read(camera, device, index, silent=()):
    """Frame `index`, with samples 1 ms before it of the sensors that are not silent."""
    stamp = stamp_of(index)
    if "gyroscope" not in silent:
        device.push_gyro(RATES, stamp - 0.001)
    if "accelerometer" not in silent:
        device.push_accel((0.0, -9.8, 0.0), stamp - 0.001)
    device.push_frame(colour(index), depth_mm(index), stamp)
    return camera.read(timeout=2.0)


@pytest.mark.parametrize("ahead", [5.0, 100.0])
def test_a_sample_from_the_future_does_not_hold_back_those_behind_it(device, ahead):
    with opened(device) as (camera, _, _):
        read(camera, device, 0)
        device.push_gyro((9.0, 9.0, 9.0), stamp_of(0) + ahead)
        device.push_accel((9.0, 9.0, 9.0), stamp_of(0) + ahead)
        for index in range(1, 4):
            imu = read(camera, device, index).imu
            np.testing.assert_allclose(imu.gyro, [RATES], atol=1e-6)
            np.testing.assert_allclose(imu.accel, [(0.0, -9.8, 0.0)], atol=1e-6)


def test_samples_that_are_hardly_younger_than_a_frame_come_with_the_next(device):
    with opened(device) as (camera, _, _):
        read(camera, device, 0)
        device.push_gyro((0.5, 0.5, 0.5), stamp_of(1) + 0.01)
        assert len(read(camera, device, 1).imu.gyro) == 0
        assert len(read(camera, device, 2).imu.gyro) == 3


@pytest.mark.parametrize("dead", ["gyroscope", "accelerometer"])
def test_a_sensor_that_falls_silent_while_images_go_on_is_logged_once_and_when_it_returns(
    device, caplog, dead
):
    with opened(device) as (camera, _, _):
        for index in range(10):
            read(camera, device, index)
        assert caplog.messages == []
        for index in range(10, 100):
            read(camera, device, index, silent=[dead])
        [told] = caplog.messages
        assert told.startswith(f"the camera's {dead} has been silent for 1.0 s")
        assert "plug it in again" in told
        for index in range(100, 110):
            read(camera, device, index)
        assert caplog.messages[1:] == [f"the camera's {dead} is heard again after 3.0 s"]


def test_a_camera_without_motion_is_not_logged(device, caplog):
    with opened(device) as (camera, _, _):
        for index in range(60):
            read(camera, device, index, silent=["gyroscope", "accelerometer"])
    assert caplog.messages == []
