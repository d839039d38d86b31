"""Dead reckoning by wheels and gyroscope: distances by wheels, turns by gyroscope.

Wheels slip in turns, a gyroscope does not. Its error is its bias, a rate that it reads at rest. The
bias is learned whenever the wheels stand still, as they do for a moment before a run starts, and
its drift is learned from images. So are the scales of gyroscope and wheels in turns.
"""

from __future__ import annotations

from dataclasses import replace

import gtsam
import numpy as np
from numpy.typing import NDArray

from mapping.odometry.config import DeadReckoningConfig, TurnCalibrationConfig
from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.gyro_faults import GyroFaults, GyroVote
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.geometry import invert, planar, yaw_of
from vizbot.core.types import SE3, ImuSamples, RGBDFrame


class DeadReckoning:
    """Integrates distances by wheels and turns by gyroscope."""

    def __init__(self, T_base_cam: SE3, config: DeadReckoningConfig) -> None:
        self._config = config
        self._T_base_cam = T_base_cam
        self._noise = gtsam.PreintegratedRotationParams()
        self._noise.setBodyPSensor(gtsam.Pose3(T_base_cam))
        self._noise.setGyroscopeCovariance(config.noise_density**2 * np.eye(3))
        self._bias = np.zeros(3)
        self._standing_time = 0.0
        self._stands = False
        self._gyro = TurnCalibration(config.gyro)
        self._wheels = TurnCalibration(config.wheels)
        self._faults = GyroFaults(config.gyro_faults)
        self._vote = GyroVote(config.gyro_vote)
        self._T_odom_base = np.eye(4)
        self._now: DeadReckonedPose | None = None
        self._trusted: DeadReckonedPose | None = None

    def update(self, frame: RGBDFrame, T_odom_base: SE3) -> DeadReckonedPose:
        """Add the motion up to `frame`.

        Args:
            frame: Newer than any before; its IMU samples give the turn since the frame before.
            T_odom_base: Dead reckoning by the wheels alone.
        """
        before, T_odom_before, self._T_odom_base = self._now, self._T_odom_base, T_odom_base
        if before is None:
            self._now = DeadReckonedPose(
                T_odom_base, T_odom_base, 0, frame.stamp, 0.0, 0.0, 0.0, 0.0
            )
            return self._now
        step, without = invert(T_odom_before) @ T_odom_base, before.frames_without_gyro
        period = frame.stamp - before.stamp
        stood, self._stands = self._stands, bool(np.allclose(step, np.eye(4), atol=1e-9))
        measured = _complete(frame.imu, before.stamp, frame.stamp, self._config.greatest_gap)
        if measured and stood and self._stands:
            self._learn_bias(frame.imu, before.stamp, frame.stamp)
        self._gyro.predict(max(period, 0.0))  # a clock that was set back reduces no variance
        turn = self._wheels.corrected(yaw_of(step), float(step[0, 3]), 0.0)
        by_wheels = _turning(step, turn)
        step, variance, faulty = by_wheels, 0.0, False
        bias_sigma, scale_sigma = self._gyro.sigma(0.0, 0.0, 1.0), self._gyro.sigma(1.0, 0.0, 0.0)
        if measured and self._knows_bias:
            turn, variance = self._turned(frame.imu, before.stamp, frame.stamp)
            step = _turning(step, turn)
            faulty = self._finds_fault(before, frame.imu, turn, yaw_of(by_wheels), period)
        else:
            self._faults.reset()
            without += not measured or not self._stands
        self._now = DeadReckonedPose(
            before.T_odom_base @ step,
            before.T_wheels_base @ by_wheels,
            without,
            frame.stamp,
            before.turn_variance + variance,
            bias_sigma,
            scale_sigma,
            before.turned + yaw_of(step),
        )
        if faulty:
            self._now = self._revised(self._now)
        return self._now

    def learn(self, before: DeadReckonedPose | None, seen: RelativePose | None) -> None:
        """Learn the errors of gyroscope and wheels in turns from a motion by images.

        Args:
            before: Dead reckoning at a keyframe; None, or of the same frame, teaches nothing.
            seen: The newest frame in that keyframe by images; None teaches nothing.
        """
        now, T = self._now, self._T_base_cam
        if before is None or now is None or seen is None or before.stamp == now.stamp:
            return
        T_before_now = T @ seen.T_keyframe_cam @ invert(T)
        variance = seen.heading_variance(T)
        by_wheels, by_gyro = now.by_wheels_since(before), now.since(before)
        has_gyro = now.gyro_since(before)
        turn, wheels_off = yaw_of(by_wheels), yaw_of(invert(T_before_now) @ by_wheels)
        noise = variance + self._config.wheel_noise**2
        self._wheels.learn(turn, float(by_wheels[0, 3]), 0.0, wheels_off, noise)
        if has_gyro:
            turn, off = now.turned - before.turned, yaw_of(invert(T_before_now) @ by_gyro)
            noise = variance + now.turn_variance - before.turn_variance
            period = now.stamp - before.stamp
            self._gyro.learn(turn, 0.0, period, off, noise)
            if abs(off) < abs(wheels_off):
                self._faults.reset()
            if self._vote.outvotes(off, wheels_off, period, variance):
                self._discard_bias()

    @property
    def _knows_bias(self) -> bool:
        return self._standing_time >= self._config.least_standing

    def _turned(self, imu: ImuSamples, start: float, end: float) -> tuple[float, float]:
        """Turn of the base [rad] and its variance by noise (Forster et al. 2017, section VI)."""
        integrated = gtsam.PreintegratedAhrsMeasurements(self._noise, self._bias)
        for rate, period in zip(*_rates(imu, start, end), strict=True):
            integrated.integrateMeasurement(rate, period)
        # Not the yaw: on a rough floor the robot also turns to and fro about other axes.
        turn = float(gtsam.Rot3.Logmap(integrated.deltaRij())[2])
        variance = float(integrated.preintMeasCov()[2, 2])
        return self._gyro.corrected(turn, 0.0, end - start), variance

    def _finds_fault(
        self, before: DeadReckonedPose, imu: ImuSamples, gyro: float, wheels: float, period: float
    ) -> bool:
        """Whether the gyroscope was wrong about the turn since `_trusted`, and the wheels right."""
        if self._stands and not self._at_rest(imu):
            self._faults.reset()
            return False
        if self._faults.is_unsuspicious:
            self._trusted = before
        return self._faults.finds_fault(gyro, wheels, period, self._stands)

    def _revised(self, now: DeadReckonedPose) -> DeadReckonedPose:
        """Dead reckoning by the wheels since the gyroscope became faulty; its bias is discarded."""
        assert self._trusted is not None
        self._discard_bias()
        return replace(
            now,
            T_odom_base=self._trusted.T_odom_base @ now.by_wheels_since(self._trusted),
            frames_without_gyro=now.frames_without_gyro + 1,
        )

    def _discard_bias(self) -> None:
        """Ignore the gyroscope until its bias is learned again while the robot stands."""
        self._faults.reset()
        self._vote.reset()
        self._standing_time, self._bias = 0.0, np.zeros(3)

    def _at_rest(self, imu: ImuSamples) -> bool:
        return bool(imu.gyro.std(axis=0).max() <= self._config.rest)

    def _learn_bias(self, imu: ImuSamples, start: float, end: float) -> None:
        """Learn the bias while the wheels stand, unless a person moves the robot."""
        config, period = self._config, end - start
        rates, periods = _rates(imu, start, end)
        change = periods @ rates / period - self._bias
        if np.abs(change).max() > (
            config.greatest_change if self._knows_bias else config.greatest_bias
        ):
            return
        if not self._at_rest(imu):
            return
        if self._knows_bias and self._learn_at_rest(imu, start, end):
            change *= period / config.memory
            self._bias = self._bias + change
            self._gyro.shift_rate(float((self._T_base_cam[:3, :3] @ change)[2]))
            return
        if self._knows_bias:
            self._standing_time = 0.0  # the former bias no longer holds
            self._vote.reset()
        self._standing_time += period
        self._bias = self._bias + change * (period / self._standing_time)
        self._gyro.reset_rate(config.noise_density / float(np.sqrt(self._standing_time)))

    def _learn_at_rest(self, imu: ImuSamples, start: float, end: float) -> bool:
        """Update the bias while the wheels stand; whether its former value explains the samples."""
        turned, variance = self._turned(imu, start, end)
        return self._gyro.learn(0.0, 0.0, end - start, turned, variance)


class TurnCalibration:
    """A Kalman filter of the errors for each radian, metre and second of a source of turns.

    A gyroscope's sensitivity is off by up to some percent, its bias drifts as it warms up, wheels
    wear and sink into carpets. These errors persist: a pose graph that takes them for noise turns
    with them, one way all the time.
    """

    def __init__(self, config: TurnCalibrationConfig) -> None:
        self._config = config
        self._error = np.zeros(3)
        self._covariance = np.diag((config.per_radian**2, config.per_metre**2, 0.0))

    def corrected(self, turn: float, distance: float, period: float) -> float:
        """Correct a turn [rad] that was measured over a signed distance [m] and a time [s]."""
        return float(turn - self._error @ (turn, distance, period))

    def sigma(self, turn: float, distance: float, period: float) -> float:
        """Standard deviation of a corrected turn [rad]."""
        over = np.array((turn, distance, period))
        least = self._config.least * np.abs(over[:2]).sum()
        return float(np.hypot(np.sqrt(over @ self._covariance @ over), least))

    def reset_rate(self, sigma: float) -> None:
        """Set the error for each second to 0, with a standard deviation [rad/s]."""
        self._error[2] = 0.0
        self._covariance[2], self._covariance[:, 2] = 0.0, 0.0
        self._covariance[2, 2] = sigma**2

    def shift_rate(self, taken_out: float) -> None:
        """Reduce the error for each second by what is corrected elsewhere from now on [rad/s]."""
        self._error[2] -= taken_out

    def predict(self, period: float) -> None:
        """Let the error for each second drift for a time [s]."""
        self._covariance[2, 2] += self._config.wander**2 * period

    def learn(
        self, turn: float, distance: float, period: float, off: float, variance: float
    ) -> bool:
        """Update with the error of a turn unless it is implausible; whether it is plausible.

        Args:
            turn: The corrected turn [rad].
            distance: Driven meanwhile, signed [m].
            period: Duration of the turn [s].
            off: The corrected turn less a better measurement of it [rad].
            variance: Of `off`, by noise alone [rad^2].
        """
        over = np.array((turn, distance, period))
        spread = self._covariance @ over
        expected = float(over @ spread) + variance
        if off**2 > self._config.gate**2 * expected:
            return False
        self._error = self._error + spread * (off / expected)
        self._covariance = self._covariance - np.outer(spread, spread) / expected
        return True


def _turning(step: SE3, turn: float) -> SE3:
    """The same motion with another turn: on an arc, whose chord points half as far aside."""
    x, y, _ = (planar(0.0, 0.0, 0.5 * (turn - yaw_of(step))) @ step)[:3, 3]
    return planar(x, y, turn)


def _complete(imu: ImuSamples, start: float, end: float, greatest_gap: float) -> bool:
    """Whether finite gyroscope samples cover the time between two stamps without longer gaps."""
    within = (imu.gyro_stamps > start) & (imu.gyro_stamps < end)
    stamps = np.concatenate([[start], imu.gyro_stamps[within], [end]])
    whole = within.any() and np.isfinite(imu.gyro).all()
    return bool(whole and np.diff(stamps).max() <= greatest_gap)


def _rates(
    imu: ImuSamples, start: float, end: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean rates (N, 3) in `cam` [rad/s] between samples, and their durations (N,) [s]."""
    within = (imu.gyro_stamps > start) & (imu.gyro_stamps < end)
    rates = imu.gyro[within]
    rates = np.concatenate([rates[:1], rates, rates[-1:]])
    periods = np.diff(np.concatenate([[start], imu.gyro_stamps[within], [end]]))
    return 0.5 * (rates[1:] + rates[:-1]), periods
