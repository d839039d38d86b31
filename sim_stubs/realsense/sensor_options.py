"""Sensor settings of a D435i that the driver uses, for a software device.

Ranges are those that the SDK lists for a D435i. A software device only stores the values.
"""

from __future__ import annotations

from typing import Any

from drivers.realsense.sdk import rs

Controls = tuple[tuple[Any, float, float, float], ...]

STEREO_CONTROLS: Controls = (
    (rs.option.visual_preset, 0, 5, 0),
    (rs.option.emitter_enabled, 0, 2, 1),
    (rs.option.laser_power, 0, 360, 150),
    (rs.option.enable_auto_exposure, 0, 1, 1),
    (rs.option.auto_exposure_limit, 1, 200_000, 200_000),
    (rs.option.auto_exposure_limit_toggle, 0, 1, 0),
    (rs.option.global_time_enabled, 0, 1, 1),
)
"""Option, least and greatest value, default."""

COLOUR_CONTROLS: Controls = (
    (rs.option.auto_exposure_priority, 0, 1, 1),
    (rs.option.enable_auto_exposure, 0, 1, 1),
    (rs.option.global_time_enabled, 0, 1, 1),
)
"""As `STEREO_CONTROLS`."""

MOTION_CONTROLS: Controls = ((rs.option.global_time_enabled, 0, 1, 1),)
"""As `STEREO_CONTROLS`."""


def add_controls(sensor: Any, controls: Controls) -> None:
    """Let a sensor of a software device (`rs.software_sensor`) have these settings."""
    for option, least, greatest, default in controls:
        allowed = rs.option_range()
        allowed.min, allowed.max, allowed.step, allowed.default = least, greatest, 1.0, default
        sensor.add_option(option, allowed, True)
