"""Which RealSense camera, and how it looks at the world.

Nothing here has been tried on hardware: the defaults follow Intel's advice and the geometry of a
robot that turns, not measurements of a D435i.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Self

from pydantic import BaseModel, Field, model_validator

from vizbot.core.settings import SETTINGS


class Preset(StrEnum):
    """The D400's depth presets: how sure a pixel must be to count as measured."""

    DEFAULT = "default"
    """Clean edges; what the camera starts with."""
    HAND = "hand"
    """For gestures near the camera."""
    HIGH_ACCURACY = "high accuracy"
    """Only what is sure: walls without texture become holes."""
    HIGH_DENSITY = "high density"
    """Few holes, more errors."""
    MEDIUM_DENSITY = "medium density"
    """Between the two."""


class SpatialFilterConfig(BaseModel):
    """Smooths each depth image along its rows and columns, edges kept."""

    model_config = SETTINGS

    alpha: float = Field(0.5, ge=0.25, le=1.0)
    """Weight of a pixel against its neighbours; 1 smooths nothing."""
    delta: int = Field(20, ge=1, le=50)
    """A step that is larger is an edge [1/32 px of disparity]."""
    passes: int = Field(2, ge=1, le=5)
    """How often."""


class TemporalFilterConfig(BaseModel):
    """Smooths each depth pixel over time; on a robot that moves it drags edges along."""

    model_config = SETTINGS

    alpha: float = Field(0.4, ge=0.0, le=1.0)
    """Weight of the newest image; 1 smooths nothing."""
    delta: int = Field(20, ge=1, le=100)
    """A step that is larger is a change of the scene [1/32 px of disparity]."""
    persistence: int = Field(0, ge=0, le=8)
    """The SDK's rule by which holes are filled from the past; 0 fills none, since what was there
    before the robot moved is elsewhere now."""


class DepthFilterConfig(BaseModel):
    """What is done to depth before it is registered to colour; as a default nothing.

    The pose estimator and the obstacle map weigh the sensor's noise themselves and know that a
    filtered pixel is none of its own; `vizbot doctor` measures what the filters cost here.
    """

    model_config = SETTINGS

    nearest: float | None = Field(None, gt=0)
    """What is nearer counts as not measured [m]."""
    farthest: float | None = Field(None, gt=0)
    """What is farther counts as not measured [m]."""
    spatial: SpatialFilterConfig | None = None
    """None smooths no image."""
    temporal: TemporalFilterConfig | None = None
    """None smooths nothing over time."""

    @model_validator(mode="after")
    def _nearest_is_nearer(self) -> Self:
        if self.nearest and self.farthest and self.nearest >= self.farthest:
            raise ValueError(f"nearest {self.nearest} m is not nearer than {self.farthest} m")
        return self


class RealSenseConfig(BaseModel):
    """Which camera, and what it streams. A recording streams what was recorded."""

    model_config = SETTINGS

    serial: str | None = None
    """Serial number printed on the camera; without one the first camera found."""
    width: int = Field(640, gt=0)
    """Of the colour and the depth image [px]."""
    height: int = Field(480, gt=0)
    """Of the colour and the depth image [px]."""
    fps: int = Field(30, gt=0)
    """Images per second; the nearest lower rate where the camera lacks this one, as on USB 2."""
    preset: Preset | None = Preset.MEDIUM_DENSITY
    """A map needs walls without holes to know where the home ends, and no phantoms in doorways;
    None leaves the camera as it is."""
    exposure_limit: float | None = Field(0.010, gt=0)
    """Longest exposure that the camera may choose for depth [s]: at 1 rad/s 10 ms are 6 px of
    blur. Colour has no such setting; it is kept from exposing for longer than its frame period.
    None lets the camera choose freely."""
    emitter: bool = True
    """Project the dots that give walls a texture; its power is left as it is."""
    filters: DepthFilterConfig = DepthFilterConfig()
    """Of depth, live and recorded."""
    imu: bool = True
    """Read gyro and accelerometer where the camera has them."""
    gyro_rate: int = Field(200, gt=0)
    """Gyro samples per second; the nearest rate of the camera is taken."""
    accel_rate: int = Field(100, gt=0)
    """Accelerometer samples per second; the nearest rate of the camera is taken."""
    first_frame_timeout: float = Field(5.0, gt=0)
    """Streams get so long to bring their first frame [s]: a camera takes a while to start."""
    reconnect_timeout: float = Field(60.0, ge=0)
    """A camera that gives no frames has so long to come back [s]."""
