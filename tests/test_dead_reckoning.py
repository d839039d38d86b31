import numpy as np
import pytest

from mapping.dead_reckoning import DeadReckoning, GyroConfig
from vizbot.core.diff_drive import rolled
from vizbot.core.geometry import camera_mount, yaw_of
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

T_BASE_CAM = camera_mount(height=1.2, forward=0.0, tilt=0.3)
PERIOD, RATE = 0.1, 200.0
BIAS = 0.02
TRACK = 0.235


class Drive:
    """A robot whose wheels count 10 % more turn than there is, and whose gyroscope is biased."""

    def __init__(self, bias: float = BIAS, gyro: bool = True) -> None:
        self.reckoning = DeadReckoning(T_BASE_CAM, GyroConfig())
        self.rng = np.random.default_rng(3)
        self.stamp, self.bias, self.gyro = 10.0, bias, gyro
        self.T_wheels, self.T_true = np.eye(4), np.eye(4)
        self.now = self.reckoning.follow(self.frame(0.0), self.T_wheels)

    def frame(self, yaw_rate: float) -> RGBDFrame:
        imu = ImuSamples.none()
        if self.gyro:
            count = round(PERIOD * RATE)
            stamps = self.stamp + (np.arange(count) + 1 - count) / RATE
            up_cam = T_BASE_CAM[2, :3]
            rates = (yaw_rate + self.bias) * up_cam + self.rng.normal(0.0, 0.003, (count, 3))
            imu = ImuSamples(stamps, rates, np.zeros(0), np.zeros((0, 3)))
        camera = Intrinsics(2, 2, 1.0, 1.0, 0.5, 0.5)
        blank = np.zeros((2, 2, 3), np.uint8), np.zeros((2, 2), np.float32)
        return RGBDFrame(self.stamp, *blank, camera, imu)

    def go(self, seconds: float, speed: float, yaw_rate: float, wheels: bool = True) -> None:
        """Drive; without `wheels` somebody carries the robot."""
        for _ in range(round(seconds / PERIOD)):
            way, turn = speed * PERIOD, yaw_rate * PERIOD
            self.T_true = self.T_true @ rolled(
                way - turn * TRACK / 2, way + turn * TRACK / 2, TRACK
            )
            if wheels:
                told = 1.1 * turn
                step = rolled(way - told * TRACK / 2, way + told * TRACK / 2, TRACK)
                self.T_wheels = self.T_wheels @ step
            self.stamp += PERIOD
            self.now = self.reckoning.follow(self.frame(yaw_rate), self.T_wheels)

    def error(self) -> tuple[float, float]:
        """Distance [m] and angle [rad] from the truth."""
        T = np.linalg.inv(self.T_true) @ self.now.T_odom_base
        return float(np.linalg.norm(T[:3, 3])), abs(yaw_of(T))


def test_after_standing_the_gyroscope_says_how_far_wheels_that_slip_have_turned() -> None:
    drive = Drive()
    drive.go(1.0, 0.0, 0.0)
    drive.go(20.0, 0.3, 0.5)
    distance, angle = drive.error()
    assert angle < 0.02 and distance < 0.02
    assert abs(yaw_of(np.linalg.inv(drive.T_true) @ drive.T_wheels)) > 0.5


def test_without_a_gyroscope_the_wheels_say_everything() -> None:
    drive = Drive(gyro=False)
    start = drive.now
    drive.go(1.0, 0.0, 0.0)
    drive.go(5.0, 0.3, 0.5)
    np.testing.assert_allclose(drive.now.T_odom_base, drive.T_wheels, atol=1e-9)
    assert not drive.now.gyro_since(start)


def test_a_gyroscope_whose_bias_is_unknown_is_not_believed() -> None:
    drive = Drive(bias=0.3)
    start = drive.now
    drive.go(5.0, 0.3, 0.5)
    np.testing.assert_allclose(drive.now.T_odom_base, drive.T_wheels, atol=1e-9)
    assert not drive.now.gyro_since(start)


def test_once_the_bias_is_known_turns_are_the_gyroscopes() -> None:
    drive = Drive()
    drive.go(1.0, 0.0, 0.0)
    settled = drive.now
    drive.go(1.0, 0.3, 0.5)
    assert drive.now.gyro_since(settled)


def test_who_turns_the_robot_by_hand_does_not_teach_it_a_bias() -> None:
    drive = Drive()
    drive.go(1.0, 0.0, 0.0)
    drive.go(2.0, 0.0, 0.5, wheels=False)
    drive.go(1.0, 0.0, 0.0)
    drive.go(5.0, 0.3, 0.2)
    assert drive.error()[1] < 0.02


@pytest.mark.parametrize("kept", [0, 1, 5])
def test_a_frame_with_few_samples_is_carried_by_the_wheels(kept: int) -> None:
    drive = Drive()
    drive.go(1.0, 0.0, 0.0)
    before = drive.now
    frame = drive.frame(0.0)
    few = ImuSamples(frame.imu.gyro_stamps[:kept], frame.imu.gyro[:kept], *2 * (np.zeros(0),))
    torn = RGBDFrame(drive.stamp + PERIOD, frame.rgb, frame.depth, frame.intrinsics, few)
    T_wheels = drive.T_wheels @ rolled(0.02, 0.03, TRACK)
    now = drive.reckoning.follow(torn, T_wheels)
    assert not now.gyro_since(before)
    assert yaw_of(now.since(before)) == pytest.approx(0.01 / TRACK)
