"""Settings of the simulated RealSense."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class DepthNoiseConfig(BaseModel):
    """The error model of depth; zero switches a part off."""

    model_config = SETTINGS

    baseline: float = Field(default=0.05, ge=0.005, le=0.5)
    """The two infrared cameras are this far apart [m]."""
    disparity_noise: float = Field(default=0.08, ge=0.0, le=10.0)
    """The disparity has this standard deviation [px]."""
    disparity_step: float = Field(default=1.0 / 32.0, ge=0.0, le=4.0)
    """Disparities are whole multiples of this [px]."""
    occlusion: float = Field(default=1.0, ge=0.0, le=10.0)
    """The hole to the left of near things has this share of its geometric width [1]."""
    edge_width: int = Field(default=5, ge=0, le=100)
    """The matching window sees both sides within this width around edges [px]."""
    edge_jump: float = Field(default=0.08, ge=0.0, le=10.0)
    """Depth has an edge where it steps by more than this fraction; 0 makes no edges [1]."""
    bleeding: float = Field(default=0.5, ge=0.0, le=1.0)
    """This share of the far side of edges gets the near side's depth; the rest gets none [1]."""
    dark: float = Field(default=16.0, ge=0.0, le=255.0)
    """Half of a surface is not measured below this brightness, of 255 [grey levels]."""
    shiny: float = Field(default=0.985, ge=0.0, le=2.0)
    """A surface blinds the imagers from this share of full brightness on [1].

    Only what the picture shows nearly white counts: lamps, and highlights that are as bright. The
    renderer mirrors nothing but the mirror of a home with bare walls, so that panes, polished metal
    and other mirrors that look darker are measured as if they were matt.
    """
    plain: float = Field(default=0.6, ge=0.0, le=255.0)
    """A surface needs this local contrast, of 255, for each metre beyond `projector_range` [grey
    levels]."""
    projector_range: float = Field(default=3.0, ge=0.0, le=50.0)
    """The projector's dots make plain surfaces measurable up to this range [m]."""
    least_range: float = Field(default=0.28, ge=0.0, le=5.0)
    """Depth below this is not measured [m]."""
    greatest_range: float = Field(default=5.5, ge=0.0, le=50.0)
    """Half of the pixels are measured at this range; 0 sets no limit [m]."""
    range_fade: float = Field(default=0.4, ge=0.0, le=10.0)
    """The limit `greatest_range` varies between places by this standard deviation [m]."""

    @classmethod
    def none(cls) -> DepthNoiseConfig:
        """Settings of a camera without errors of depth."""
        return cls(
            disparity_noise=0.0,
            disparity_step=0.0,
            occlusion=0.0,
            edge_width=0,
            dark=0.0,
            shiny=0.0,
            plain=0.0,
            least_range=0.0,
            greatest_range=0.0,
        )


class ColourNoiseConfig(BaseModel):
    """The error model of colour; zero switches a part off."""

    model_config = SETTINGS

    noise: float = Field(default=2.0, ge=0.0, le=255.0)
    """Each value, of 255, has this standard deviation at unit gain, which grows with the gain [grey
    levels]."""
    flicker: float = Field(default=0.02, ge=0.0, le=1.0)
    """The brightness of a frame varies by this fraction (standard deviation) [1]."""
    exposure_control: float = Field(default=0.6, ge=0.0, le=1.0)
    """Auto exposure takes away this share of a deviation from `exposure_target`, as a ratio [1]."""
    exposure_target: float = Field(default=110.0, ge=1.0, le=255.0)
    """Auto exposure aims at this mean brightness, of 255 [grey levels]."""
    exposure_lag: float = Field(default=0.4, ge=0.0, le=60.0)
    """Auto exposure follows with this time constant [s]."""
    exposure_time: float = Field(default=0.008, ge=0.0, le=1.0)
    """A picture is exposed for this time, which blurs it in turns [s]."""

    @classmethod
    def none(cls) -> ColourNoiseConfig:
        """Settings of a camera without errors of colour."""
        return cls(noise=0.0, flicker=0.0, exposure_control=0.0, exposure_time=0.0)


class InertialConfig(BaseModel):
    """The D435i's BMI055: rates and errors; zero switches an error off."""

    model_config = SETTINGS

    gyro_rate: float = Field(default=200.0, ge=1.0, le=2000.0)
    """The gyroscope takes this number of samples a second [1/s]."""
    accel_rate: float = Field(default=100.0, ge=1.0, le=2000.0)
    """The accelerometer takes this number of samples a second [1/s]."""
    gyro_noise: float = Field(default=0.003, ge=0.0, le=10.0)
    """One sample of the gyroscope has this standard deviation [rad/s]."""
    accel_noise: float = Field(default=0.03, ge=0.0, le=100.0)
    """One sample of the accelerometer has this standard deviation [m/s^2]."""
    gyro_bias: float = Field(default=0.005, ge=0.0, le=1.0)
    """The gyroscope's bias, drawn once for a run, has this standard deviation [rad/s]."""
    gyro_scale: float = Field(default=0.005, ge=0.0, le=1.0)
    """The error of the gyroscope's sensitivity as a fraction, drawn once for a run, has this
    standard deviation [1]."""
    accel_bias: float = Field(default=0.05, ge=0.0, le=10.0)
    """The accelerometer's bias, drawn once for a run, has this standard deviation [m/s^2]."""


class SimulatedRealSenseConfig(BaseModel):
    """The simulated camera."""

    model_config = SETTINGS

    rate: float = Field(default=3.5, ge=0.1, le=90.0)
    """The camera takes this number of frames a second [1/s]. The default gives steps of 0.14 m or
    21 degrees at full speed, and commands in time for the base, which stops after 0.3 s without
    one."""
    depth_noise: DepthNoiseConfig = DepthNoiseConfig()
    """These settings are the errors of depth."""
    colour_noise: ColourNoiseConfig = ColourNoiseConfig()
    """These settings are the errors of colour."""
    inertial: InertialConfig = InertialConfig()
    """These settings are the rates and errors of the inertial sensors."""
