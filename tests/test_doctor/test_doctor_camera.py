"""What the doctor finds out about a camera by looking through it."""

from contextlib import nullcontext
from dataclasses import dataclass

import numpy as np
import pytest

from drivers.realsense.examination import CameraIdentity, cameras, examine_camera
from sim_stubs.realsense.software_device import SoftwareD435i
from vizbot import doctor
from vizbot.config import Config
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame
from vizbot.doctor import Grade


@dataclass
class StillCamera:
    """Ten frames a second that look at a wall with holes, and an IMU at rest."""

    clock: SimulatedClock
    period: float = 0.1
    holes: int = 2
    gyro_rate: int = 200
    accel_rate: int = 100
    bias: float = 0.005
    gravity: float = 9.8
    filter_cost: float = 0.0

    def read(self, timeout=1.0):
        before = self.clock.now()
        self.clock.sleep(self.period)
        now = self.clock.now()
        depth = np.full((4, 8), 1.5, np.float32)
        depth[:, : self.holes] = 0.0
        gyro = sampled(before, now, self.gyro_rate, [0.0, 0.6 * self.bias, 0.8 * self.bias])
        accel = sampled(before, now, self.accel_rate, [0.0, -self.gravity, 0.0])
        camera = Intrinsics(8, 4, 6.0, 6.0, 3.5, 1.5)
        return RGBDFrame(
            now, np.zeros((4, 8, 3), np.uint8), depth, camera, ImuSamples(*gyro, *accel)
        )


def sampled(before, now, rate, value):
    """Stamps and values of samples that are `rate` a second."""
    stamps = np.arange(np.ceil(before * rate), np.ceil(now * rate)) / max(rate, 1)
    return stamps, np.tile(np.array(value), (len(stamps), 1))


def test_a_camera_is_described_by_what_it_gives():
    clock = SimulatedClock()
    found = examine_camera(StillCamera(clock), clock)
    assert found.rate == pytest.approx(10.0, rel=0.1)
    assert found.holes == 0.25
    assert found.gyro_rate == pytest.approx(200.0, rel=0.01)
    assert found.accel_rate == pytest.approx(100.0, rel=0.01)
    assert found.gyro_bias == pytest.approx(0.005)
    assert found.gravity == pytest.approx(9.8)
    without = examine_camera(StillCamera(clock, gyro_rate=0, accel_rate=0), clock)
    assert without.gyro_rate == without.accel_rate == without.gravity == 0.0


@pytest.fixture
def diagnosed(monkeypatch):
    """What the doctor says of a still camera of these properties, by subject."""

    def run(usb="3.2", imu=True, **properties):
        def plug_in(_settings, clock):
            return nullcontext(StillCamera(clock, **properties))

        identity = CameraIdentity("D435I", "0123", "5.16.0.1", usb)
        monkeypatch.setattr("drivers.realsense.camera.RealSense", plug_in)
        monkeypatch.setattr("drivers.realsense.examination.cameras", lambda: [identity])
        config = Config.model_validate({"realsense": {"fps": 10, "imu": imu}})
        return {each.subject: each for each in doctor._camera(config, SimulatedClock())}

    return run


def test_a_sound_camera_is_good_in_every_respect(diagnosed):
    findings = diagnosed()
    subjects = ["camera", "camera's frames", "depth", "gyroscope", "accelerometer", "IMU"]
    assert list(findings) == subjects
    assert {each.verdict for each in findings.values()} == {Grade.GOOD}
    assert findings["camera"].found == "D435I, serial 0123, firmware 5.16.0.1, USB 3.2"
    assert findings["accelerometer"].found == "100/s of 100/s"


@pytest.mark.parametrize(
    ("fault", "subject", "found", "remedy"),
    [
        ({"usb": "2.1"}, "camera", "USB 2.1", "a USB 3 port and a USB 3 cable"),
        ({"period": 0.12}, "camera's frames", "8/s of 10/s", "close other programs"),
        ({"holes": 5}, "depth", "62 % of the pixels", "clean the lenses"),
        ({"gyro_rate": 170}, "gyroscope", "170/s of 200/s", "USB 3 port"),
        ({"gyro_rate": 0}, "gyroscope", "none", "use a D435i"),
        ({"imu": False}, "gyroscope", "none", "imu = true"),
        ({"accel_rate": 63}, "accelerometer", "63/s of 100/s", "what it has: 63, 100"),
        ({"accel_rate": 0}, "accelerometer", "0/s of 100/s", "USB 3 port"),
        ({"bias": 0.04}, "IMU", "0.0400 rad/s at rest", "keep the robot still"),
        ({"gravity": 9.2}, "IMU", "gravity 9.20 m/s^2", "calibrate the camera's IMU"),
        ({"gravity": 10.4}, "IMU", "gravity 10.40 m/s^2", "calibrate the camera's IMU"),
    ],
)
def test_what_is_poor_about_a_camera_is_told_with_its_remedy(
    diagnosed, fault, subject, found, remedy
):
    finding = diagnosed(**fault)[subject]
    assert finding.verdict is Grade.POOR
    assert found in finding.found and remedy in finding.remedy


@pytest.mark.parametrize(
    ("cost", "found"),
    [(0.0, []), (0.015, [(Grade.GOOD, "15.0 ms a frame, 15 % of its time")]),
     (0.06, [(Grade.POOR, "60.0 ms a frame, 60 % of its time")])],
)  # fmt: skip
def test_what_depth_filters_cost_is_measured_and_told(diagnosed, cost, found):
    findings = diagnosed(filter_cost=cost)
    told = [(each.verdict, each.found) for each in findings.values() if "filters" in each.subject]
    assert told == found


def test_cameras_that_are_plugged_in_are_listed():
    [found] = cameras(SoftwareD435i(serial="0123").plug_in())
    assert isinstance(found, CameraIdentity)
    assert found.serial == "0123" and found.usb.startswith("3")
