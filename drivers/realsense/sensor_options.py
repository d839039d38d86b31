"""Options of the camera itself: preset, exposure, projector, clock.

A camera keeps its options until it loses power, so all are set, whatever another program has left.
Exposure limits apply from the next start of the streams, so options are set before it.
"""

from __future__ import annotations

import logging
from typing import Any

from drivers.realsense.config import Preset, RealSenseConfig
from drivers.realsense.sdk import rs

log = logging.getLogger(__name__)

_PRESETS = {preset: getattr(rs.rs400_visual_preset, preset.replace(" ", "_")) for preset in Preset}


def apply_options(device: Any, config: RealSenseConfig, name: str) -> None:
    """Set the options that each sensor of `device`, an `rs.device` that streams next, supports."""
    for sensor in device.query_sensors():
        for option, value in _wanted(sensor, config):
            if sensor.supports(option):
                _set(sensor, option, value, name)
            else:
                log.debug("%s: %s has no %s", name, sensor.name, option.name)


def _wanted(sensor: Any, config: RealSenseConfig) -> list[tuple[Any, float]]:
    """Options and values, in the order in which they must be set."""
    # Images and IMU on the host's clock: they are joined by their stamps.
    wanted: list[tuple[Any, float]] = [(rs.option.global_time_enabled, 1.0)]
    if sensor.is_depth_sensor():
        if config.preset is not None:  # first: a preset brings settings of its own
            wanted.append((rs.option.visual_preset, float(int(_PRESETS[config.preset]))))
        wanted.append((rs.option.emitter_enabled, float(config.emitter)))
    limit = config.exposure_limit
    if limit is None:
        wanted.append((rs.option.enable_auto_exposure, 1.0))
        wanted.append((rs.option.auto_exposure_priority, 1.0))
        wanted.append((rs.option.auto_exposure_limit_toggle, 0.0))
        return wanted
    wanted.append((rs.option.enable_auto_exposure, 1.0))
    # With priority the exposure may last longer than a frame period, at a lower rate.
    wanted.append((rs.option.auto_exposure_priority, 0.0))
    # In this order: setting the limit [us] switches the toggle off.
    wanted.append((rs.option.auto_exposure_limit, 1e6 * limit))
    wanted.append((rs.option.auto_exposure_limit_toggle, 1.0))
    return wanted


def _set(sensor: Any, option: Any, value: float, name: str) -> None:
    try:
        allowed = sensor.get_option_range(option)
        sensor.set_option(option, min(max(value, allowed.min), allowed.max))
    except RuntimeError as error:
        reason = " ".join(str(error).split())
        log.warning("%s: %s cannot be set to %g (%s)", name, option.name, value, reason)
