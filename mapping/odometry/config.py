"""Settings of odometry by images, wheels and gyroscope."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class FeatureConfig(BaseModel):
    """Which corners are detected, and when two of them match."""

    model_config = SETTINGS
    count: int = Field(default=1000, ge=10, le=20000)
    """Number of corners per image at most [1]."""
    quality: float = Field(default=0.001, ge=1e-6, le=0.5)
    """Response of the weakest corner, as a fraction of the strongest one's [1]."""
    contrast: int = Field(default=8, ge=0, le=255)
    """Least difference of the brightest and darkest pixel around a corner, above the noise [grey
    levels]."""
    spacing: float = Field(default=6.0, ge=0.0, le=100.0)
    """Least distance between two corners [px]."""
    depth_spread: float = Field(default=0.05, ge=0.0, le=1.0)
    """Largest relative difference of depths around a corner [1]; beyond, it lies on an edge."""
    max_depth: float = Field(default=8.0, ge=0.5, le=65.0)
    """Largest depth that counts as measured [m]."""
    max_hamming: int = Field(default=60, ge=0, le=256)
    """Largest number of 256 bits in which two descriptors of one corner differ [1]."""
    ratio: float = Field(default=0.85, ge=0.1, le=1.0)
    """Largest ratio of the best distance of descriptors to the second best [1]."""


class MinimalPoseConfig(BaseModel):
    """Limits of the search for a minimal pose."""

    model_config = SETTINGS
    error: float = Field(default=4.0, ge=0.1, le=100.0)
    """Largest reprojection error of a match that agrees [px]."""
    iterations: int = Field(default=1000, ge=1, le=100000)
    """Number of minimal poses tried at most [1]."""
    agreeing: int = Field(default=10, ge=3, le=1000)
    """Least number of matches that agree with a minimal pose for it to be refined [1]."""


class OdometryConfig(BaseModel):
    """When matched corners give a pose."""

    model_config = SETTINGS
    pixel_sigma: float = Field(default=1.0, ge=0.05, le=20.0)
    """Standard deviation of a matched corner [px]."""
    depth_sigma: float = Field(default=0.003, ge=1e-5, le=0.5)
    """Standard deviation of depth at 1 m [m]; a stereo camera's grows with the square of depth."""
    minimal: MinimalPoseConfig = MinimalPoseConfig()
    """Search for a first pose."""
    verify_radius: float = Field(default=10.0, ge=0.5, le=200.0)
    """Radius of the search [px] for the matches that verify and refine a minimal pose."""
    sure_inliers: int = Field(default=60, ge=1, le=10000)
    """Number of agreeing matches below which further minimal poses are tried [1]: few matches that
    repeat, as tiles do, agree with several."""
    attempts: int = Field(default=8, ge=1, le=1000)
    """Number of minimal poses tried at most [1]. The one with most agreeing matches is taken, less
    half its squared distance from the prediction in units of `motion_sigma` and `turn_sigma`."""
    motion_sigma: float = Field(default=0.15, ge=0.001, le=10.0)
    """Standard deviation of the predicted position [m]."""
    turn_sigma: float = Field(default=0.1, ge=0.001, le=6.3)
    """Standard deviation of the predicted angle [rad]."""
    unmodelled: float = Field(default=1.9, ge=0.1, le=100.0)
    """Factor on covariances, for matches do not err independently (measured in training homes)
    [1]."""
    least_error: float = Field(default=0.01, ge=0.0, le=1.0)
    """Least error of matches as a fraction of their noise [1]: a frozen image repeats to the
    bit."""
    min_inliers: int = Field(default=15, ge=4, le=1000)
    """Least number of matches that agree with a pose [1]."""
    min_inlier_fraction: float = Field(default=0.5, ge=0.0, le=1.0)
    """Least share of all matches that agree with a pose [1]."""


class GatingConfig(BaseModel):
    """How far images may contradict the other sources of motion."""

    model_config = SETTINGS
    sure_inliers: int = Field(default=30, ge=1, le=10000)
    """Least number of agreeing matches where the prediction is poor [1]: to close a loop, to regain
    tracking, and to link a keyframe to others than the last."""
    sure_fraction: float = Field(default=0.6, ge=0.0, le=1.0)
    """Least share of all matches that agree, likewise [1]."""
    wheel_gate: float = Field(default=0.1, ge=0.0, le=10.0)
    """Most that images may contradict dead reckoning [m, rad]."""
    wheel_gate_growth: float = Field(default=0.5, ge=0.0, le=10.0)
    """Growth of `wheel_gate` with the motion since images were last believed, as a fraction [1]."""
    gyro_gate: float = Field(default=0.01, ge=0.0, le=3.2)
    """Most that a turn by images may differ from the gyroscope's since a keyframe [rad]."""
    gyro_gate_growth: float = Field(default=0.02, ge=0.0, le=10.0)
    """Growth of `gyro_gate` with the angle, as a fraction [1]."""
    wheel_turn_gate: float = Field(default=0.03, ge=0.0, le=3.2)
    """Most that a turn by wheels that do not slip differs from one by images [rad]."""
    wheel_turn_gate_growth: float = Field(default=0.15, ge=0.0, le=10.0)
    """Growth of `wheel_turn_gate` with the angle, as a fraction [1]."""
    spin: float = Field(default=0.5, ge=0.0, le=10.0)
    """Largest error of a wheel-only stretch, as a fraction of its length [1]. A larger one would
    take the next of two rooms that look the same for the first one."""
    closure_gate: float = Field(default=1.0, ge=0.0, le=100.0)
    """Most that a loop closure may move a keyframe [m, rad]."""
    closure_height: float = Field(default=0.03, ge=0.0, le=1.0)
    """Most that a loop closure may move a keyframe up or down, with wheels on a floor [m]."""
    closure_tilt: float = Field(default=0.02, ge=0.0, le=1.0)
    """Most that a loop closure may tilt a keyframe, with wheels on a floor [rad]: curtains repeat,
    and match after such a step."""


class GyroFaultsConfig(BaseModel):
    """When the wheels alone rule the gyroscope out."""

    model_config = SETTINGS

    span: float = Field(default=1.0, ge=0.05, le=60.0)
    """Time over which rates are averaged, since wheels jitter from frame to frame [s]."""
    spans: int = Field(default=5, ge=1, le=1000)
    """Number of such spans in a row that must differ for the gyroscope to be ruled out [1]."""
    gate: float = Field(default=0.03, ge=1e-4, le=3.0)
    """Difference of rates from which gyroscope and wheels differ [rad/s]."""
    gate_growth: float = Field(default=0.1, ge=0.0, le=10.0)
    """Growth of `gate` with the rate of the wheels, as a fraction [1]."""
    standing_gate: float = Field(default=0.005, ge=1e-4, le=3.0)
    """The same difference while the wheels stand still [rad/s]."""
    carried: float = Field(default=0.1, ge=0.001, le=6.3)
    """Rate above which, while the wheels stand still, a person turns the robot [rad/s]."""


class GyroVoteConfig(BaseModel):
    """When images and wheels together rule the gyroscope out."""

    model_config = SETTINGS

    span: float = Field(default=1.0, ge=0.05, le=60.0)
    """Total duration of the turns that one vote is about [s]."""
    gate: float = Field(default=0.02, ge=1e-4, le=3.0)
    """Difference of rates between gyroscope and images from which it is ruled out [rad/s]."""
    sigmas: float = Field(default=4.0, ge=0.1, le=100.0)
    """The same difference in standard deviations of the turn by images [1]."""
    share: float = Field(default=0.5, ge=0.01, le=10.0)
    """Most that wheels may differ from images, as a share of what the gyroscope does [1]."""


class TurnCalibrationConfig(BaseModel):
    """Error model of a source of turns."""

    model_config = SETTINGS

    per_radian: float = Field(ge=0.0, le=1.0)
    """Initial standard deviation of the scale, as a fraction of the turn [1]."""
    per_metre: float = Field(ge=0.0, le=10.0)
    """Initial standard deviation of the turn for each metre driven straight [rad/m]."""
    wander: float = Field(default=0.0, ge=0.0, le=1.0)
    """Random walk of the error for each second [rad/s/sqrt(s)], whose variance is 0 until
    `reset_rate` sets it."""
    least: float = Field(default=0.001, ge=1e-6, le=1.0)
    """Least standard deviation of scale and turn per metre, however much is learned [1, rad/m]."""
    gate: float = Field(default=3.0, ge=0.1, le=100.0)
    """Error in standard deviations above which a turn by images teaches nothing [1]."""


class DeadReckoningConfig(BaseModel):
    """Use of the gyroscope, and of the wheels where there is none."""

    model_config = SETTINGS
    least_standing: float = Field(default=0.5, ge=0.01, le=60.0)
    """Time that the robot must have stood before the bias is known [s]."""
    memory: float = Field(default=30.0, ge=0.1, le=3600.0)
    """Standing time over which the bias is averaged; what is older fades [s]."""
    greatest_bias: float = Field(default=0.03, ge=1e-4, le=1.0)
    """Largest bias of the gyroscope [rad/s]."""
    greatest_change: float = Field(default=0.005, ge=1e-5, le=1.0)
    """Largest change of the bias once it is known [rad/s]."""
    rest: float = Field(default=0.02, ge=1e-4, le=1.0)
    """Largest standard deviation of its samples at rest, about any axis [rad/s]."""
    greatest_gap: float = Field(default=0.05, ge=0.001, le=1.0)
    """Largest time between samples for a turn by gyroscope to be known [s]."""
    noise_density: float = Field(default=2.5e-4, ge=1e-7, le=0.1)
    """White noise of the rate (BMI055 data sheet: 0.014 degrees/s) [rad/s/sqrt(Hz)]."""
    gyro: TurnCalibrationConfig = TurnCalibrationConfig(per_radian=0.01, per_metre=0.0, wander=2e-5)
    """Errors of the gyroscope: its sensitivity (BMI055 data sheet: 1 %), and its bias, which drifts
    by some 1e-3 rad/s in the first hour as it warms up."""
    wheels: TurnCalibrationConfig = TurnCalibrationConfig(per_radian=0.05, per_metre=0.03)
    """Errors of the wheels in turns: their distance, and their difference in size."""
    wheel_noise: float = Field(default=0.01, ge=1e-5, le=1.0)
    """Remaining standard deviation of a turn by wheels between keyframes [rad]."""
    watch: GyroFaultsConfig = GyroFaultsConfig()
    """When the wheels alone rule the gyroscope out."""
    vote: GyroVoteConfig = GyroVoteConfig()
    """When images and wheels together rule the gyroscope out."""
