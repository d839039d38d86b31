"""Replays of recorded laps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray

from drivers.tum_sequence import RecordedSequence
from mapping.tum import read_trajectory
from vizbot.core.types import SE3, ImuSamples, RGBDFrame

SENSORS = ("gyroscope", "accelerometer")
"""Sensors whose samples lie in files beside the images."""


@dataclass(frozen=True, slots=True, eq=False)
class ReplayFrame:
    """One frame of a recording, with its poses.

    Attributes:
        frame: The frame, with the IMU samples since the last frame.
        T_odom_base: Pose of the base by its wheels.
        T_world_cam: True pose of the camera, for scoring alone.
        faulty: Whether a fault acts on it, or on the motion since the last frame.
    """

    frame: RGBDFrame
    T_odom_base: SE3
    T_world_cam: SE3
    faulty: bool = False


def replay(folder: Path) -> Iterator[ReplayFrame]:
    """The frames of a recording, in order.

    Raises:
        ConfigError: the recording is incomplete.
    """
    recording, last = _Recording.read(folder), -np.inf
    with RecordedSequence(folder) as camera:
        for i, stamp in enumerate(recording.stamps):
            yield recording.frame(i, camera.frame(i), recording.samples(last, stamp))
            last = stamp


def to_and_fro(folder: Path) -> Iterator[ReplayFrame]:
    """The frames of a recording to its end, backwards to its start, and so on without a jump.

    Raises:
        ConfigError: the recording is incomplete.
    """
    recording = _Recording.read(folder)
    bias = recording.gyro_bias()
    with RecordedSequence(folder) as camera:
        index, step, now, imu = 0, 1, float(recording.stamps[0]), ImuSamples.none()
        while True:
            yield recording.frame(index, replace(camera.frame(index), stamp=now), imu)
            if not 0 <= index + step < len(recording.stamps):
                step = -step
            early, late = sorted((recording.stamps[index], recording.stamps[index + step]))
            if step > 0:
                imu = recording.samples(early, late)
            else:
                imu = _reversed(recording.samples(early, late, side="left"), late, bias)
            imu = delayed(imu, now - (early if step > 0 else 0.0))
            index, now = index + step, now + float(late - early)


@dataclass(frozen=True, slots=True, eq=False)
class _Recording:
    """The data of a recording beside its images.

    Attributes:
        stamps: Stamps of the frames (F,) [s].
        Ts_odom_base: Poses of the base by its wheels (F, 4, 4).
        Ts_world_cam: True poses of the camera (F, 4, 4).
        gyro: Stamps and rates (N, 4) [s, rad/s].
        accel: Stamps and accelerations (M, 4) [s, m/s^2].
    """

    stamps: NDArray[np.float64]
    Ts_odom_base: NDArray[np.float64]
    Ts_world_cam: NDArray[np.float64]
    gyro: NDArray[np.float64]
    accel: NDArray[np.float64]

    @classmethod
    def read(cls, folder: Path) -> Self:
        stamps, Ts_odom_base = read_trajectory(folder / "odometry.txt")
        _, Ts_world_cam = read_trajectory(folder / "groundtruth.txt")
        gyro, accel = (np.loadtxt(folder / f"{kind}.txt").reshape(-1, 4) for kind in SENSORS)
        return cls(stamps, Ts_odom_base, Ts_world_cam, gyro, accel)

    def frame(self, index: int, image: RGBDFrame, imu: ImuSamples) -> ReplayFrame:
        return ReplayFrame(
            replace(image, imu=imu), self.Ts_odom_base[index], self.Ts_world_cam[index]
        )

    def samples(
        self, start: float, end: float, side: Literal["left", "right"] = "right"
    ) -> ImuSamples:
        """Samples after `start` up to `end`; with `side` left, from `start` to before `end`."""
        return ImuSamples(
            *_between(self.gyro, start, end, side), *_between(self.accel, start, end, side)
        )

    def gyro_bias(self) -> NDArray[np.float64]:
        """Mean rates (3,) of the gyroscope until the robot sets out [rad/s]."""
        stands = np.isclose(self.Ts_odom_base, self.Ts_odom_base[0]).all(axis=(1, 2))
        until = self.stamps[-1 if stands.all() else stands.argmin() - 1]
        return np.asarray(self.gyro[self.gyro[:, 0] <= until, 1:].mean(axis=0))


def delayed(imu: ImuSamples, period: float) -> ImuSamples:
    """Samples as they are, but `period` later [s]."""
    return replace(
        imu, gyro_stamps=imu.gyro_stamps + period, accel_stamps=imu.accel_stamps + period
    )


def _reversed(imu: ImuSamples, end: float, bias: NDArray[np.float64]) -> ImuSamples:
    """Samples of the reversed motion; their stamps count backwards from `end`."""
    return ImuSamples(
        (end - imu.gyro_stamps)[::-1],
        (2 * bias - imu.gyro)[::-1],
        (end - imu.accel_stamps)[::-1],
        imu.accel[::-1],
    )


def _between(
    samples: NDArray[np.float64], start: float, end: float, side: Literal["left", "right"]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stamps (N,) and values (N, 3) of samples (M, 4)."""
    first, last = np.searchsorted(samples[:, 0], (start, end), side=side)
    return samples[first:last, 0], samples[first:last, 1:]
