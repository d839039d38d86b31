"""What the doctor finds out about a camera by looking through it."""

from dataclasses import dataclass

import numpy as np
import pytest

from drivers.realsense_examination import CameraIdentity, cameras, examine_camera
from sim_stubs.clock import SimulatedClock
from sim_stubs.realsense_device import SoftwareD435i
from vizbot import doctor
from vizbot.config import Config
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame
from vizbot.doctor import Verdict


@dataclass
class StillCamera:
    """Ten frames a second that look at a wall with holes, and an IMU."""

    clock: SimulatedClock
    imu: bool = True
    filter_cost: float = 0.0

    def close(self):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *exc):
        self.close()

    def read(self, timeout=1.0):
        self.clock.sleep(0.1)
        depth = np.full((4, 8), 1.5, np.float32)
        depth[:, :2] = 0.0
        now, samples = self.clock.now(), np.arange(20)
        stamps = now - samples[::-1] / 200.0
        gyro, accel = np.tile([0.0, 0.003, 0.004], (20, 1)), np.tile([0.0, -9.8, 0.0], (20, 1))
        imu = ImuSamples(stamps, gyro, stamps, accel) if self.imu else ImuSamples.none()
        camera = Intrinsics(8, 4, 6.0, 6.0, 3.5, 1.5)
        return RGBDFrame(now, np.zeros((4, 8, 3), np.uint8), depth, camera, imu)


def test_a_camera_is_described_by_what_it_gives():
    clock = SimulatedClock()
    found = examine_camera(StillCamera(clock), clock)
    assert found.rate == pytest.approx(10.0, rel=0.1)
    assert found.holes == 0.25
    assert found.gyro_rate == pytest.approx(200.0, rel=0.1)
    assert found.gyro_bias == pytest.approx(0.005)
    assert found.gravity == pytest.approx(9.8)
    assert examine_camera(StillCamera(clock, imu=False), clock).gyro_rate == 0.0


@pytest.mark.parametrize(
    ("cost", "found"),
    [(0.0, []), (0.005, [(Verdict.GOOD, "5.0 ms a frame, 15 % of its time")]),
     (0.02, [(Verdict.POOR, "20.0 ms a frame, 60 % of its time")])],
)  # fmt: skip
def test_what_depth_filters_cost_is_measured_and_told(monkeypatch, cost, found):
    def still_camera(_settings, clock):
        return StillCamera(clock, filter_cost=cost)

    monkeypatch.setattr("drivers.realsense.RealSense", still_camera)
    findings = list(doctor._camera(Config(), SimulatedClock()))
    told = [(each.verdict, each.found) for each in findings if each.subject == "depth filters"]
    assert told == found


def test_cameras_that_are_plugged_in_are_listed():
    device = SoftwareD435i(serial="0123")
    [found] = cameras(device.plug_in())
    assert isinstance(found, CameraIdentity)
    assert found.serial == "0123" and found.usb.startswith("3")
