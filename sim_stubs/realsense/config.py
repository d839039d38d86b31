"""Settings of the simulated RealSense."""

from __future__ import annotations

from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class DepthNoiseConfig(BaseModel):
    """The error model of depth; zero switches a part off."""

    model_config = SETTINGS

    baseline: float = Field(default=0.05, ge=0.005, le=0.5)
    """Distance of the two infrared cameras [m]."""
    disparity_noise: float = Field(default=0.08, ge=0.0, le=10.0)
    """Standard deviation of the disparity [px]."""
    disparity_step: float = Field(default=1.0 / 32.0, ge=0.0, le=4.0)
    """Disparities are whole multiples of this [px]."""
    occlusion: float = Field(default=1.0, ge=0.0, le=10.0)
    """Width of the hole to the left of near things, as a share of the geometric width [1]."""
    edge_width: int = Field(default=5, ge=0, le=100)
    """Width around edges within which the matching window sees both sides [px]."""
    edge_jump: float = Field(default=0.08, ge=0.0, le=10.0)
    """Relative step of depth from which it is an edge [1]; 0 makes no edges."""
    bleeding: float = Field(default=0.5, ge=0.0, le=1.0)
    """Share of the far side of edges that gets the near side's depth [1]; the rest gets none."""
    dark: float = Field(default=16.0, ge=0.0, le=255.0)
    """Brightness, of 255, below which half of a surface is not measured [grey levels]."""
    shiny: float = Field(default=0.985, ge=0.0, le=2.0)
    """Share of full brightness from which a surface blinds the imagers [1].

    Only what the picture shows nearly white counts: lamps, and highlights that are as bright. The
    renderer mirrors nothing but the mirror of a home with bare walls, so that panes, polished metal
    and other mirrors that look darker are measured as if they were matt.
    """
    plain: float = Field(default=0.6, ge=0.0, le=255.0)
    """Local contrast, of 255, that each metre beyond `projector_range` asks of a surface [grey
    levels]."""
    projector_range: float = Field(default=3.0, ge=0.0, le=50.0)
    """Range up to which the projector's dots make plain surfaces measurable [m]."""
    least_range: float = Field(default=0.28, ge=0.0, le=5.0)
    """Least measured depth [m]."""
    greatest_range: float = Field(default=5.5, ge=0.0, le=50.0)
    """Range at which half of the pixels are measured [m]; 0 sets no limit."""
    range_fade: float = Field(default=0.4, ge=0.0, le=10.0)
    """Standard deviation of that limit between places [m]."""

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
    """Standard deviation of each value, of 255, at unit gain [grey levels]; it grows with the
    gain."""
    flicker: float = Field(default=0.02, ge=0.0, le=1.0)
    """Standard deviation of the relative brightness of a frame [1]."""
    exposure_control: float = Field(default=0.6, ge=0.0, le=1.0)
    """Share of a deviation from `exposure_target`, as a ratio, that auto exposure takes away
    [1]."""
    exposure_target: float = Field(default=110.0, ge=1.0, le=255.0)
    """Mean brightness that auto exposure aims at, of 255 [grey levels]."""
    exposure_lag: float = Field(default=0.4, ge=0.0, le=60.0)
    """Time constant of auto exposure [s]."""
    exposure_time: float = Field(default=0.008, ge=0.0, le=1.0)
    """Exposure time, which blurs pictures in turns [s]."""

    @classmethod
    def none(cls) -> ColourNoiseConfig:
        """Settings of a camera without errors of colour."""
        return cls(noise=0.0, flicker=0.0, exposure_control=0.0, exposure_time=0.0)


class InertialConfig(BaseModel):
    """The D435i's BMI055: rates and errors; zero switches an error off."""

    model_config = SETTINGS

    gyro_rate: float = Field(default=200.0, ge=1.0, le=2000.0)
    """Sample rate [1/s]."""
    accel_rate: float = Field(default=100.0, ge=1.0, le=2000.0)
    """Sample rate [1/s]."""
    gyro_noise: float = Field(default=0.003, ge=0.0, le=10.0)
    """Standard deviation of one sample [rad/s]."""
    accel_noise: float = Field(default=0.03, ge=0.0, le=100.0)
    """Standard deviation of one sample [m/s^2]."""
    gyro_bias: float = Field(default=0.005, ge=0.0, le=1.0)
    """Standard deviation of the bias, drawn once for a run [rad/s]."""
    gyro_scale: float = Field(default=0.005, ge=0.0, le=1.0)
    """Standard deviation of the error of its sensitivity as a fraction, drawn once for a run
    [1]."""
    accel_bias: float = Field(default=0.05, ge=0.0, le=10.0)
    """Standard deviation of the bias, drawn once for a run [m/s^2]."""


class SimulatedRealSenseConfig(BaseModel):
    """The simulated camera."""

    model_config = SETTINGS

    rate: float = Field(default=3.5, ge=0.1, le=90.0)
    """Frame rate [1/s]. The default gives steps of 0.14 m or 21 degrees at full speed, and commands
    in time for the base, which stops after 0.3 s without one."""
    depth_noise: DepthNoiseConfig = DepthNoiseConfig()
    """Errors of depth."""
    colour_noise: ColourNoiseConfig = ColourNoiseConfig()
    """Errors of colour."""
    inertial: InertialConfig = InertialConfig()
    """Rates and errors of the inertial sensors."""
