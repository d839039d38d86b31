"""A RealSense that freezes, vanishes, or mixes up its frames, through the SDK's software device.

What that device cannot do is put between driver and SDK: a hardware reset that works, and the
SDK's error texts. These tests are marked as unverified on hardware.
"""

import time

import numpy as np
import pytest

from drivers.realsense.sdk import rs
from sim_stubs.realsense.software_device import SoftwareD435i
from tests.helpers.d435i_frames import SERIAL, START, colour, depth_mm, opened, stamp_of
from tests.helpers.failing import raising
from vizbot.core.errors import DeviceError, DeviceTimeoutError

SHORT = 0.05
UNPLUGGED = "Device disconnected. Failed to reconnect: No device connected5000"


@pytest.fixture
def device():
    return SoftwareD435i(serial=SERIAL)


def push(device, index, seconds=0.0):
    """Frame `index`, so much later, with an IMU sample 1 ms before it."""
    stamp = stamp_of(index) + seconds
    device.push_gyro((0.1, 0.2, 0.3), stamp - 0.001)
    device.push_accel((0.0, -9.8, 0.0), stamp - 0.001)
    device.push_frame(colour(index), depth_mm(index), stamp)


def read(camera, device, index, seconds=0.0):
    push(device, index, seconds)
    return camera.read(timeout=2.0)


def wait_in_vain(camera, clock, seconds):
    """Read once and then after each of so many seconds; the messages."""
    told = []
    for second in range(seconds + 1):
        clock.sleep(1.0 if second else 0.0)
        with pytest.raises(DeviceTimeoutError) as silence:
            camera.read(timeout=SHORT)
        told.append(str(silence.value))
    assert not any("\n" in line for line in told)
    return told


def test_a_frozen_camera_is_opened_anew_and_goes_on(device, caplog):
    with opened(device) as (camera, clock, _):
        before = read(camera, device, 0)
        told = wait_in_vain(camera, clock, 2)
        assert told[0].startswith(f"RealSense {SERIAL}: no frame within 0.05 s; check")
        after = read(camera, device, 1, seconds=2.0)
        assert after.stamp == pytest.approx(before.stamp + 2.0 + 1 / 30, abs=1e-6)
        np.testing.assert_array_equal(after.rgb, colour(1))
    noticed, recovered = caplog.messages
    assert noticed.endswith("opening its streams anew")
    assert "frames again after" in recovered and "by opening its streams anew" in recovered


def test_a_camera_that_freezes_again_is_recovered_from_the_first_step_on(device, caplog):
    with opened(device) as (camera, clock, _):
        read(camera, device, 0)
        for seconds in (3.0, 6.0):
            wait_in_vain(camera, clock, 3)
            read(camera, device, 1, seconds)
    told = [message.split(": ", 1)[1].split(" after ")[0] for message in caplog.messages]
    again = ["no frame for 2.0 s: opening its streams anew", "frames again"]
    assert told == again + again


def test_imu_samples_of_a_gap_are_not_handed_over(device):
    with opened(device) as (camera, clock, _):
        before = read(camera, device, 0)
        device.push_gyro((9.0, 9.0, 9.0), before.stamp + 0.1)
        wait_in_vain(camera, clock, 2)
        device.push_gyro((9.0, 9.0, 9.0), before.stamp - 0.1)
        after = read(camera, device, 1, seconds=2.0)
        np.testing.assert_allclose(after.imu.gyro, [[0.1, 0.2, 0.3]], atol=1e-6)
        assert before.stamp < after.imu.gyro_stamps[0] <= after.stamp


def test_imu_samples_on_another_clock_are_left_out(device):
    with opened(device) as (camera, _, _):
        for index in range(3):  # as a camera's first ones, before the SDK knows the host's time
            device.push_gyro((9.0, 9.0, 9.0), 5.0 + index)
            frame = read(camera, device, index)
            np.testing.assert_allclose(frame.imu.gyro, [[0.1, 0.2, 0.3]], atol=1e-6)
            assert frame.imu.gyro_stamps[0] == pytest.approx(frame.stamp - 0.001, abs=1e-4)


def test_a_camera_that_is_only_late_is_left_alone(device, caplog):
    with opened(device) as (camera, clock, _):
        read(camera, device, 0)
        wait_in_vain(camera, clock, 1)
        assert read(camera, device, 1, seconds=1.0)
    assert [m for m in caplog.messages if "opening" in m] == []


def test_a_camera_that_vanishes_is_waited_for_and_opened_when_it_returns(device, caplog):
    with opened(device) as (camera, clock, context):
        before = read(camera, device, 0)
        device.unplug()
        began = time.monotonic()
        told = wait_in_vain(camera, clock, 10)
        assert time.monotonic() - began < 3.0  # the SDK would wait for 15 s
        assert "unplugged; check its USB 3 cable" in told[-1]
        assert list(context.query_devices()) == []
        device.plug_in(context)
        wait_in_vain(camera, clock, 2)
        assert read(camera, device, 1, seconds=12.0).stamp > before.stamp
    assert "frames again after" in caplog.messages[-1]


def test_a_camera_that_is_not_listed_is_let_go_and_never_started(device, monkeypatch, caplog):
    with opened(device) as (camera, clock, _):
        read(camera, device, 0)
        with monkeypatch.context() as absent:
            absent.setattr("drivers.realsense.camera.cameras_by_serial", lambda context: {})
            absent.delattr("drivers.realsense.camera.RealSenseStreams")
            told = wait_in_vain(camera, clock, 10)
        assert all("unplugged" in line for line in told)
        assert "letting go of streams whose camera has gone" in caplog.text
        wait_in_vain(camera, clock, 2)
        assert read(camera, device, 1, seconds=12.0)


def test_a_camera_that_stays_away_is_given_up(device):
    with opened(device, reconnect_timeout=5.0) as (camera, clock, _):
        read(camera, device, 0)
        device.unplug()
        wait_in_vain(camera, clock, 4)
        clock.sleep(1.0)
        for _ in range(2):
            with pytest.raises(DeviceError, match=r"no frame for 5 s.*then launch again") as error:
                camera.read(timeout=SHORT)
            assert not isinstance(error.value, DeviceTimeoutError)


def test_a_reader_that_was_away_for_long_does_not_give_the_camera_up(device):
    with opened(device) as (camera, clock, _):
        read(camera, device, 0)
        clock.sleep(600.0)
        wait_in_vain(camera, clock, 2)
        assert read(camera, device, 1, seconds=602.0)


def test_closing_ends_a_recovery(device):
    with opened(device) as (camera, clock, _):
        read(camera, device, 0)
        wait_in_vain(camera, clock, 3)
        camera.close()
        with pytest.raises(DeviceError, match="already closed") as error:
            camera.read()
        assert not isinstance(error.value, DeviceTimeoutError)


def test_a_reset_that_the_device_refuses_is_logged_and_recovery_goes_on(device, caplog):
    with opened(device) as (camera, clock, _):
        read(camera, device, 0)
        wait_in_vain(camera, clock, 4)
        assert "a hardware reset failed (hardware_reset is not implemented" in caplog.text
        wait_in_vain(camera, clock, 4)
        assert read(camera, device, 1, seconds=8.0)


def test_unverified_on_hardware_a_reset_is_the_last_step_and_its_camera_is_opened(
    device, monkeypatch, caplog
):
    resets = []
    monkeypatch.setattr(rs.device, "hardware_reset", lambda camera: resets.append(clock.now()))
    with opened(device) as (camera, clock, _):
        before = read(camera, device, 0)
        wait_in_vain(camera, clock, 3)
        assert resets == []
        wait_in_vain(camera, clock, 1)
        assert resets == [pytest.approx(4.0, abs=0.1)]
        wait_in_vain(camera, clock, 4)
        assert read(camera, device, 1, seconds=8.0).stamp > before.stamp
    steps = [message for message in caplog.messages if "no frame for" in message]
    assert [step.split(": ")[-1] for step in steps] == [
        "opening its streams anew",
        "a hardware reset",
        "opening its streams anew",
    ]


def test_unverified_on_hardware_a_clock_that_begins_anew_after_a_reset_is_shifted(device):
    with opened(device) as (camera, clock, _):
        before = read(camera, device, 0)
        wait_in_vain(camera, clock, 2)
        after = read(camera, device, 0, seconds=7.0 - START)
        assert after.stamp == pytest.approx(before.stamp + clock.now(), abs=0.1)
        clock.sleep(1.0)
        later = read(camera, device, 0, seconds=8.0 - START)
        assert later.stamp == pytest.approx(after.stamp + 1.0, abs=1e-3)
        np.testing.assert_allclose(later.imu.gyro_stamps, [later.stamp - 0.001], atol=1e-4)


@pytest.mark.parametrize(
    "text", [UNPLUGGED, "Frame didn't arrive within 5000", "xioctl(VIDIOC_DQBUF) failed"]
)
def test_unverified_on_hardware_an_error_of_the_sdk_is_one_line_and_the_camera_opened_anew(
    device, monkeypatch, text
):
    with opened(device) as (camera, _, _):
        before = read(camera, device, 0)
        with monkeypatch.context() as broken:
            broken.setattr(
                "drivers.realsense.streams.RealSenseStreams.wait", raising(RuntimeError(text))
            )
            with pytest.raises(DeviceTimeoutError) as error:
                camera.read(timeout=SHORT)
        assert f"lost ({text})" in str(error.value) and "\n" not in str(error.value)
        with pytest.raises(DeviceTimeoutError):
            camera.read(timeout=SHORT)  # opens it anew
        assert read(camera, device, 1, seconds=1.0).stamp > before.stamp


@pytest.mark.parametrize("text", ["No device connected", "failed to set power state"])
def test_unverified_on_hardware_an_opening_that_fails_is_tried_again(
    device, monkeypatch, caplog, text
):
    with opened(device) as (camera, clock, _):
        read(camera, device, 0)
        with monkeypatch.context() as broken:
            broken.setattr("drivers.realsense.camera.RealSenseStreams", raising(RuntimeError(text)))
            wait_in_vain(camera, clock, 2)
        assert f"opening its streams anew failed ({text})" in caplog.text
        wait_in_vain(camera, clock, 1)
        assert read(camera, device, 1, seconds=5.0)


def test_unverified_on_hardware_streams_of_a_camera_that_is_gone_close_without_an_error(
    device, monkeypatch
):
    failed = []

    def failing(method):
        def fail(*arguments):
            method(*arguments)  # so that the software device can be opened again
            failed.append(method)
            raise RuntimeError("failed to set power state")

        return fail

    for kind, name in ((rs.sensor, "stop"), (rs.sensor, "close"), (rs.pipeline, "stop")):
        monkeypatch.setattr(kind, name, failing(getattr(kind, name)))
    for index in range(2):
        with opened(device) as (camera, _, _):
            assert read(camera, device, index)
    assert len(failed) == 6


def test_images_that_do_not_belong_together_are_left_out(device, caplog):
    with opened(device) as (camera, _, _):
        read(camera, device, 0)
        device.push_color(colour(1), stamp_of(1))  # its depth was lost: the SDK repeats the last
        device.push_depth(depth_mm(2), stamp_of(2))
        with pytest.raises(DeviceTimeoutError, match="colour and depth are 33 ms apart"):
            camera.read(timeout=0.25)
        device.push_color(colour(2), stamp_of(2))
        frame = camera.read(timeout=2.0)
        assert frame.stamp == pytest.approx(stamp_of(2), abs=1e-6)
        np.testing.assert_allclose(frame.depth, depth_mm(2) / 1000.0, atol=1e-6)
    assert len([m for m in caplog.messages if "apart" in m]) == 1


def test_frames_out_of_order_are_left_out(device, caplog):
    with opened(device) as (camera, _, _):
        read(camera, device, 5)
        push(device, 3)
        with pytest.raises(DeviceTimeoutError, match="out of order"):
            camera.read(timeout=0.25)
        assert read(camera, device, 6).stamp == pytest.approx(stamp_of(6), abs=1e-6)


def test_colour_that_stands_still_is_named(device):
    with opened(device) as (camera, _, _):
        read(camera, device, 0)
        for index in range(1, 12):  # the SDK waits for its partner for a while
            device.push_depth(depth_mm(index), stamp_of(index))
        with pytest.raises(DeviceTimeoutError, match="colour stands still"):
            camera.read(timeout=0.25)


def test_a_clock_that_is_set_while_it_streams_does_not_carry_the_frames_away(device, caplog):
    with opened(device) as (camera, clock, _):
        before = read(camera, device, 0)
        clock.sleep(0.1)
        after = read(camera, device, 0, seconds=3600.1)
        assert after.stamp == pytest.approx(before.stamp + 0.1, abs=0.01)
        assert len(after.imu.gyro_stamps) == 0
    assert "its clock jumped by +3600" in caplog.text
