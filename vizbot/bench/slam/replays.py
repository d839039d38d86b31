"""Recordings of laps, replayed as often as needed."""

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
"""Each has a file of its samples beside the images."""


@dataclass(frozen=True, slots=True, eq=False)
class ReplayFrame:
    """One frame of a recording, with what else was known then.

    Attributes:
        frame: With the samples of gyroscope and accelerometer since the one before.
        T_odom_base: By the wheels.
        T_world_cam: The truth, for scoring alone.
    """

    frame: RGBDFrame
    T_odom_base: SE3
    T_world_cam: SE3


def replay(folder: Path) -> Iterator[ReplayFrame]:
    """The moments of a recording, in order.

    Raises:
        ConfigError: it is not whole.
    """
    tape, last = _Recording.read(folder), -np.inf
    with RecordedSequence(folder) as camera:
        for i, stamp in enumerate(tape.stamps):
            yield tape.moment(i, camera.frame(i), tape.samples(last, stamp))
            last = stamp


def to_and_fro(folder: Path) -> Iterator[ReplayFrame]:
    """A recording to its end, backwards to its start, and so on for ever, without a jump.

    Raises:
        ConfigError: it is not whole.
    """
    tape = _Recording.read(folder)
    bias = tape.gyro_bias()
    with RecordedSequence(folder) as camera:
        at, step, now, imu = 0, 1, float(tape.stamps[0]), ImuSamples.none()
        while True:
            yield tape.moment(at, replace(camera.frame(at), stamp=now), imu)
            if not 0 <= at + step < len(tape.stamps):
                step = -step
            early, late = sorted((tape.stamps[at], tape.stamps[at + step]))
            if step > 0:
                imu = tape.samples(early, late)
            else:
                imu = _reversed(tape.samples(early, late, side="left"), late, bias)
            shift = now - (early if step > 0 else 0.0)
            imu = replace(
                imu, gyro_stamps=imu.gyro_stamps + shift, accel_stamps=imu.accel_stamps + shift
            )
            at, now = at + step, now + float(late - early)


@dataclass(frozen=True, slots=True, eq=False)
class _Recording:
    """What a recording holds beside its images.

    Attributes:
        stamps: (F,) of the frames [s].
        Ts_odom_base: (F, 4, 4).
        Ts_world_cam: (F, 4, 4).
        gyro: (N, 4) stamps, rates.
        accel: (M, 4) stamps, accelerations.
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

    def moment(self, index: int, frame: RGBDFrame, imu: ImuSamples) -> ReplayFrame:
        seen = replace(frame, imu=imu)
        return ReplayFrame(seen, self.Ts_odom_base[index], self.Ts_world_cam[index])

    def samples(
        self, start: float, end: float, side: Literal["left", "right"] = "right"
    ) -> ImuSamples:
        """After `start`, up to `end`; with `side` left from `start` to before `end`."""
        return ImuSamples(
            *_between(self.gyro, start, end, side), *_between(self.accel, start, end, side)
        )

    def gyro_bias(self) -> NDArray[np.float64]:
        """What the gyroscope reads (3,) until the robot sets out [rad/s]."""
        stands = np.isclose(self.Ts_odom_base, self.Ts_odom_base[0]).all(axis=(1, 2))
        until = self.stamps[-1 if stands.all() else stands.argmin() - 1]
        return np.asarray(self.gyro[self.gyro[:, 0] <= until, 1:].mean(axis=0))


def _reversed(imu: ImuSamples, end: float, bias: NDArray[np.float64]) -> ImuSamples:
    """What turned one way turns the other; stamps tell how long before `end` they were."""
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
