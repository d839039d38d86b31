"""Settings of odometry by images, wheels and gyroscope."""

from __future__ import annotations

from pydantic import Field

from vizbot.core.settings import Settings


class FeatureConfig(Settings):
    """Which corners are detected, and when two of them match."""

    count: int = Field(default=1000, ge=10, le=20000)
    """At most this number of corners is detected in an image [1]."""
    quality: float = Field(default=0.001, ge=1e-6, le=0.5)
    """The weakest corner has this fraction of the strongest one's response [1]."""
    contrast: int = Field(default=8, ge=0, le=255)
    """The brightest and the darkest pixel around a corner differ by at least this, above the noise
    [grey levels]."""
    spacing: float = Field(default=6.0, ge=0.0, le=100.0)
    """Two corners are at least this far apart [px]."""
    depth_spread: float = Field(default=0.05, ge=0.0, le=1.0)
    """Depths around a corner differ by at most this fraction; beyond, it lies on an edge [1]."""
    max_depth: float = Field(default=8.0, ge=0.5, le=65.0)
    """Depth beyond this does not count as measured [m]."""
    max_hamming: int = Field(default=60, ge=0, le=256)
    """Two descriptors of one corner differ in at most this number of 256 bits [1]."""
    ratio: float = Field(default=0.85, ge=0.1, le=1.0)
    """The best distance of descriptors is at most this share of the second best [1]."""


class MinimalPoseConfig(Settings):
    """Limits of the search for a minimal pose."""

    error: float = Field(default=4.0, ge=0.1, le=100.0)
    """A match agrees with a minimal pose where its reprojection error is at most this [px]."""
    iterations: int = Field(default=1000, ge=1, le=100000)
    """At most this number of minimal poses is tried [1]."""
    agreeing: int = Field(default=10, ge=3, le=1000)
    """A minimal pose is refined where at least this number of matches agrees with it [1]."""


class OdometryConfig(Settings):
    """When matched corners give a pose."""

    pixel_sigma: float = Field(default=1.0, ge=0.05, le=20.0)
    """A matched corner has this standard deviation [px]."""
    depth_sigma: float = Field(default=0.003, ge=1e-5, le=0.5)
    """Depth has this standard deviation at 1 m, which grows with the square of depth [m]."""
    minimal: MinimalPoseConfig = MinimalPoseConfig()
    """These settings limit the search for a first pose."""
    verify_radius: float = Field(default=10.0, ge=0.5, le=200.0)
    """The matches that verify and refine a minimal pose are looked for within this radius [px]."""
    sure_inliers: int = Field(default=60, ge=1, le=10000)
    """Further minimal poses are tried where fewer matches than this agree, since few matches that
    repeat, as tiles do, agree with several [1]."""
    attempts: int = Field(default=8, ge=1, le=1000)
    """At most this number of minimal poses is tried; the one with most agreeing matches is taken,
    less half its squared distance from the prediction in units of `motion_sigma` and `turn_sigma`
    [1]."""
    motion_sigma: float = Field(default=0.15, ge=0.001, le=10.0)
    """The predicted position has this standard deviation [m]."""
    turn_sigma: float = Field(default=0.1, ge=0.001, le=6.3)
    """The predicted angle has this standard deviation [rad]."""
    covariance_factor: float = Field(default=1.9, ge=0.1, le=100.0)
    """Covariances are multiplied by this, for matches do not err independently (measured in
    training homes) [1]."""
    min_error: float = Field(default=0.01, ge=0.0, le=1.0)
    """Matches err by at least this fraction of their noise; the image of a frozen camera repeats to
    the bit [1]."""
    min_inliers: int = Field(default=15, ge=4, le=1000)
    """At least this number of matches agrees with a pose [1]."""
    min_inlier_fraction: float = Field(default=0.5, ge=0.0, le=1.0)
    """At least this share of all matches agrees with a pose [1]."""


class GatingConfig(Settings):
    """How far images may contradict the other sources of motion."""

    sure_inliers: int = Field(default=30, ge=1, le=10000)
    """At least this number of matches must agree where the prediction is poor: to close a loop, to
    regain tracking, and to link a keyframe to others than the last [1]."""
    sure_fraction: float = Field(default=0.6, ge=0.0, le=1.0)
    """At least this share of all matches must agree where the prediction is poor: to close a loop,
    to regain tracking, and to link a keyframe to others than the last [1]."""
    wheel_gate: float = Field(default=0.1, ge=0.0, le=10.0)
    """Images may contradict dead reckoning by this at most [m, rad]."""
    wheel_gate_growth: float = Field(default=0.5, ge=0.0, le=10.0)
    """The limit `wheel_gate` grows by this fraction of the motion since images were believed
    [1]."""
    gyro_gate: float = Field(default=0.01, ge=0.0, le=3.2)
    """A turn by images since a keyframe may differ from the gyroscope's by this at most [rad]."""
    gyro_gate_growth: float = Field(default=0.02, ge=0.0, le=10.0)
    """The limit `gyro_gate` grows by this fraction of the angle [1]."""
    wheel_turn_gate: float = Field(default=0.03, ge=0.0, le=3.2)
    """A turn by wheels that do not slip differs from one by images by this at most [rad]."""
    wheel_turn_gate_growth: float = Field(default=0.15, ge=0.0, le=10.0)
    """The limit `wheel_turn_gate` grows by this fraction of the angle [1]."""
    wheel_only_error: float = Field(default=0.5, ge=0.0, le=10.0)
    """A wheel-only stretch errs by at most this fraction of its length; a larger error would take
    the next of two rooms that look the same for the first one [1]."""
    closure_gate: float = Field(default=1.0, ge=0.0, le=100.0)
    """A loop closure may move a keyframe by this at most [m, rad]."""
    closure_height: float = Field(default=0.03, ge=0.0, le=1.0)
    """A loop closure may move a keyframe up or down by this at most, with wheels on a floor [m]."""
    closure_tilt: float = Field(default=0.02, ge=0.0, le=1.0)
    """A loop closure may tilt a keyframe by this at most, with wheels on a floor; curtains repeat,
    and match after a larger step [rad]."""


class GyroFaultsConfig(Settings):
    """When the wheels alone rule the gyroscope out."""

    averaging_time: float = Field(default=1.0, ge=0.05, le=60.0)
    """Rates are averaged over this time, since wheels jitter from frame to frame [s]."""
    averages: int = Field(default=5, ge=1, le=1000)
    """The gyroscope is ruled out where this number of averages in a row differ from the wheels
    [1]."""
    gate: float = Field(default=0.03, ge=1e-4, le=3.0)
    """Gyroscope and wheels differ where their rates differ by more than this [rad/s]."""
    gate_growth: float = Field(default=0.1, ge=0.0, le=10.0)
    """The limit `gate` grows by this fraction of the rate of the wheels [1]."""
    standing_gate: float = Field(default=0.005, ge=1e-4, le=3.0)
    """The gyroscope differs from standing wheels where it shows more than this rate [rad/s]."""
    carried_rate: float = Field(default=0.1, ge=0.001, le=6.3)
    """A person turns the robot where it turns faster than this with standing wheels [rad/s]."""


class GyroVoteConfig(Settings):
    """When images and wheels together rule the gyroscope out."""

    turning_time: float = Field(default=1.0, ge=0.05, le=60.0)
    """One vote is about turns that last this time together [s]."""
    gate: float = Field(default=0.02, ge=1e-4, le=3.0)
    """The gyroscope is ruled out where its rate differs by more than this from images [rad/s]."""
    sigmas: float = Field(default=4.0, ge=0.1, le=100.0)
    """The gyroscope is ruled out where it differs from images by this many of their sigmas [1]."""
    max_wheel_share: float = Field(default=0.5, ge=0.01, le=10.0)
    """Wheels that vote against the gyroscope differ from images by at most this share of it [1]."""


class TurnCalibrationConfig(Settings):
    """Error model of a source of turns."""

    per_radian: float = Field(ge=0.0, le=1.0)
    """The scale has this standard deviation at first, as a fraction of the turn [1]."""
    per_metre: float = Field(ge=0.0, le=10.0)
    """The turn for each metre driven straight has this standard deviation at first [rad/m]."""
    wander: float = Field(default=0.0, ge=0.0, le=1.0)
    """The error walks at random by this each second, with a variance that is 0 until `reset_rate`
    sets it [rad/s/sqrt(s)]."""
    least: float = Field(default=0.001, ge=1e-6, le=1.0)
    """Scale and turn per metre keep at least this standard deviation [1, rad/m]."""
    gate: float = Field(default=3.0, ge=0.1, le=100.0)
    """A turn by images teaches nothing where it is off by more standard deviations [1]."""


class DeadReckoningConfig(Settings):
    """Use of the gyroscope, and of the wheels where there is none."""

    least_standing: float = Field(default=0.5, ge=0.01, le=60.0)
    """The bias is known after the robot has stood for this time [s]."""
    memory: float = Field(default=30.0, ge=0.1, le=3600.0)
    """The bias is averaged over this standing time; what is older fades [s]."""
    greatest_bias: float = Field(default=0.03, ge=1e-4, le=1.0)
    """The gyroscope has at most this bias [rad/s]."""
    greatest_change: float = Field(default=0.005, ge=1e-5, le=1.0)
    """The bias changes by at most this once it is known [rad/s]."""
    rest: float = Field(default=0.02, ge=1e-4, le=1.0)
    """At rest the gyroscope has at most this standard deviation, about any axis [rad/s]."""
    greatest_gap: float = Field(default=0.05, ge=0.001, le=1.0)
    """A turn by gyroscope is known where its samples are at most this far apart [s]."""
    noise_density: float = Field(default=2.5e-4, ge=1e-7, le=0.1)
    """The rate has this white noise (BMI055 data sheet: 0.014 degrees/s) [rad/s/sqrt(Hz)]."""
    gyro: TurnCalibrationConfig = TurnCalibrationConfig(per_radian=0.01, per_metre=0.0, wander=2e-5)
    """These settings are the errors of the gyroscope in its sensitivity (BMI055 data sheet: 1 %),
    and in its bias, which drifts by some 1e-3 rad/s in the first hour as it warms up."""
    wheels: TurnCalibrationConfig = TurnCalibrationConfig(per_radian=0.05, per_metre=0.03)
    """These settings are the errors of turns by wheels: of their distance, and difference in
    size."""
    wheel_noise: float = Field(default=0.01, ge=1e-5, le=1.0)
    """A turn by wheels between keyframes keeps this standard deviation [rad]."""
    gyro_faults: GyroFaultsConfig = GyroFaultsConfig()
    """These settings say when the wheels alone rule the gyroscope out."""
    gyro_vote: GyroVoteConfig = GyroVoteConfig()
    """These settings say when images and wheels together rule the gyroscope out."""
