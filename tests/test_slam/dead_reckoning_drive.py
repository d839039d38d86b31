"""A robot that drives by wheels and gyroscope, both of which are a little wrong."""

from __future__ import annotations

import numpy as np

from mapping.odometry.config import DeadReckoningConfig
from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.dead_reckoning import DeadReckoning
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.diff_drive import rolled
from vizbot.core.geometry import camera_mount, planar, yaw_of
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

T_BASE_CAM = camera_mount(height=1.2, forward=0.0, tilt=0.3)
PERIOD, RATE = 0.1, 200.0
BIAS = 0.02
TRACK = 0.235


def gyro_sigma(before: DeadReckonedPose, now: DeadReckonedPose) -> float:
    """Standard deviation of a turn by gyroscope: noise adds up at random, the bias does not."""
    noise = now.turn_variance - before.turn_variance
    by_bias = now.bias_sigma * (now.stamp - before.stamp)
    by_scale = now.scale_sigma * (now.turned - before.turned)
    return float(np.sqrt(noise + by_bias**2 + by_scale**2))


class Drive:
    """A robot whose wheels count 10 % more turn than there is, and whose gyroscope is biased."""

    def __init__(self, bias: float = BIAS, gyro: bool = True, scale: float = 1.0) -> None:
        self.dead_reckoning = DeadReckoning(T_BASE_CAM, DeadReckoningConfig())
        self.rng = np.random.default_rng(3)
        self.stamp, self.bias, self.gyro, self.scale = 10.0, bias, gyro, scale
        self.slip = 0.0
        self.T_wheels, self.T_true = np.eye(4), np.eye(4)
        self.now = self.dead_reckoning.update(self.frame(0.0), self.T_wheels)

    @classmethod
    def rested(cls) -> Drive:
        """A robot that has stood for 2 s, so that it knows its bias."""
        drive = cls()
        drive.go(2.0, 0.0, 0.0)
        return drive

    def frame(self, yaw_rate: float, roll_rate: float = 0.0) -> RGBDFrame:
        imu = ImuSamples.none()
        if self.gyro:
            count = round(PERIOD * RATE)
            stamps = self.stamp + (np.arange(count) + 1 - count) / RATE
            yaw_read = self.scale * yaw_rate + self.bias
            in_base = np.array([roll_rate, -0.4 * roll_rate, yaw_read])
            rates = in_base @ T_BASE_CAM[:3, :3] + self.rng.normal(0.0, 0.003, (count, 3))
            imu = ImuSamples(stamps, rates, np.zeros(0), np.zeros((0, 3)))
        camera = Intrinsics(2, 2, 1.0, 1.0, 0.5, 0.5)
        blank = np.zeros((2, 2, 3), np.uint8), np.zeros((2, 2), np.float32)
        return RGBDFrame(self.stamp, *blank, camera, imu)

    def next_frame(self) -> RGBDFrame:
        """That of a camera that rests, a period later."""
        self.stamp += PERIOD
        return self.frame(0.0)

    def go(self, seconds: float, speed: float, yaw_rate: float, wheels: bool = True) -> None:
        """Drive, shaking a little; without `wheels` a person moves the robot."""
        for i in range(round(seconds / PERIOD)):
            way, turn = speed * PERIOD, yaw_rate * PERIOD
            self.T_true = self.T_true @ rolled(
                way - turn * TRACK / 2, way + turn * TRACK / 2, TRACK
            )
            if wheels:
                counted = 1.1 * turn
                step = rolled(way - counted * TRACK / 2, way + counted * TRACK / 2, TRACK)
                x, y = (1.0 + self.slip) * step[:2, 3]
                self.T_wheels = self.T_wheels @ planar(x, y, (1.0 + self.slip) * counted)
            self.stamp += PERIOD
            shaking = 0.2 * (-1) ** i if speed else 0.0
            self.now = self.dead_reckoning.update(self.frame(yaw_rate, shaking), self.T_wheels)

    def error(self) -> tuple[float, float]:
        """Distance [m] and signed angle [rad] from the truth."""
        T = np.linalg.inv(self.T_true) @ self.now.T_odom_base
        return float(np.linalg.norm(T[:3, 3])), yaw_of(T)

    def look(self, seconds: float, speed: float, yaw_rate: float, off: float = 0.0) -> None:
        """Drive, and learn from the turn by images, which is `off` by an error [rad]."""
        before, T_before = self.now, self.T_true
        self.go(seconds, speed, yaw_rate)
        T_before_now = np.linalg.inv(T_before) @ self.T_true @ planar(0.0, 0.0, off)
        seen = np.linalg.inv(T_BASE_CAM) @ T_before_now @ T_BASE_CAM
        self.dead_reckoning.learn(before, RelativePose(seen, 1e-5 * np.eye(6), 99, 1.0))
