"""Settings of the RealSense camera.

None of them was tried on hardware: the defaults follow Intel's advice and the geometry of a robot
that turns, not measurements of a D435i.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Self

from pydantic import Field, model_validator

from vizbot.core.settings import BASIC, Settings


class Preset(StrEnum):
    """The D400's depth presets: the confidence from which a pixel counts as measured."""

    DEFAULT = "default"
    """Clean edges; the camera's own default."""
    HAND = "hand"
    """For gestures near the camera."""
    HIGH_ACCURACY = "high accuracy"
    """Only confident pixels: walls without texture become holes."""
    HIGH_DENSITY = "high density"
    """Few holes, more errors."""
    MEDIUM_DENSITY = "medium density"
    """Between high accuracy and high density."""


class SpatialFilterConfig(Settings):
    """Smooths each depth image along its rows and columns, edges kept."""

    alpha: float = Field(0.5, ge=0.25, le=1.0)
    """A pixel has this weight against its neighbours; 1 smooths nothing [1]."""
    delta: int = Field(20, ge=1, le=50)
    """A step of at least this counts as an edge [1/32 px of disparity]."""
    passes: int = Field(2, ge=1, le=5)
    """The filter passes over the image this number of times [1]."""


class TemporalFilterConfig(Settings):
    """Smooths each depth pixel over time; on a robot that moves it drags edges along."""

    alpha: float = Field(0.4, ge=0.0, le=1.0)
    """The newest image has this weight; 1 smooths nothing [1]."""
    delta: int = Field(20, ge=1, le=100)
    """A step of at least this counts as a change of the scene [1/32 px of disparity]."""
    persistence: int = Field(0, ge=0, le=8)
    """Holes are filled from former images by this rule of the SDK; 0 fills none, since former
    images do not match once the robot has moved [1]."""


class DepthFilterConfig(Settings):
    """Filters of depth before it is registered to colour; none by default.

    Pose estimation and the obstacle map model the sensor's noise themselves, and filtered pixels do
    not follow that model; `vizbot doctor` measures the time that the filters take.
    """

    nearest: float | None = Field(default=None, ge=0.05, le=20.0)
    """A pixel with less depth than this counts as not measured; None has no limit [m]."""
    farthest: float | None = Field(default=None, ge=0.1, le=65.0)
    """A pixel with more depth than this counts as not measured; None has no limit [m]."""
    spatial: SpatialFilterConfig | None = None
    """Each image is smoothed by these settings; None does not smooth."""
    temporal: TemporalFilterConfig | None = None
    """Images are smoothed over time by these settings; None does not smooth."""

    @model_validator(mode="after")
    def _nearest_is_nearer(self) -> Self:
        if self.nearest and self.farthest and self.nearest >= self.farthest:
            raise ValueError(f"nearest {self.nearest} m is not nearer than {self.farthest} m")
        return self


class RealSenseConfig(Settings):
    """The camera, and what it streams. A recording streams what was recorded."""

    serial: str | None = Field(default=None, json_schema_extra=BASIC)
    """The camera has this serial number printed on it; None takes the first one found."""
    width: int = Field(default=640, ge=160, le=1920, json_schema_extra=BASIC)
    """The colour and the depth image are this wide [px]."""
    height: int = Field(default=480, ge=90, le=1080, json_schema_extra=BASIC)
    """The colour and the depth image are this high [px]."""
    fps: int = Field(default=30, ge=1, le=300, json_schema_extra=BASIC)
    """The camera takes this number of images a second, or the nearest lower one where it lacks this
    rate, as on USB 2 [1/s]."""
    preset: Preset | None = Field(default=Preset.MEDIUM_DENSITY, json_schema_extra=BASIC)
    """The camera measures depth by this preset; None leaves the camera as it is. A map needs walls
    without holes to know where the home ends, and no phantoms in doorways."""
    exposure_limit: float | None = Field(default=0.010, ge=1e-5, le=0.2, json_schema_extra=BASIC)
    """The camera may choose an exposure up to this for depth; None has no limit [s]. At 1 rad/s, 10
    ms are 6 px of blur. The exposure of colour is limited to its frame period alone."""
    emitter: bool = Field(default=True, json_schema_extra=BASIC)
    """This says whether to project the dots that give walls a texture, at the power set before."""
    filters: DepthFilterConfig = DepthFilterConfig()
    """These filters change depth, live and recorded."""
    imu: bool = Field(default=True, json_schema_extra=BASIC)
    """This says whether to read gyroscope and accelerometer where the camera has them."""
    gyro_rate: int = Field(default=200, ge=1, le=1000)
    """The gyroscope takes this number of samples a second, or the nearest it can [1/s]."""
    accel_rate: int = Field(default=100, ge=1, le=1000)
    """The accelerometer takes this number of samples a second, or the nearest it can [1/s]."""
    first_frame_timeout: float = Field(default=5.0, ge=0.1, le=120.0)
    """Streams have this time to bring a first frame, since a camera takes time to start [s]."""
    reconnect_timeout: float = Field(default=60.0, ge=0.0, le=86400.0, json_schema_extra=BASIC)
    """A camera without frames has this time to return [s]."""
