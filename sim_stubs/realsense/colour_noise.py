"""Colour errors of a D435i: exposure, motion blur in turns, noise."""

from __future__ import annotations

from math import exp

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.realsense.config import ColourNoiseConfig
from sim_stubs.realsense.depth_noise import NORMAL, random_bytes


class AutoExposure:
    """The gain of a camera, which follows the brightness of its pictures."""

    def __init__(self, config: ColourNoiseConfig) -> None:
        self._config = config
        self._stops: float | None = None

    def gain(self, rgb: NDArray[np.uint8], seconds: float) -> float:
        """Factor by which the next picture is brighter than rendered.

        Args:
            rgb: The rendered picture (H, W, 3).
            seconds: Time since the last picture [s]; the first one is exposed correctly.
        """
        config = self._config
        mean = max(float(np.mean(rgb[::8, ::8])), 1.0)
        wanted = config.exposure_control * float(np.log2(config.exposure_target / mean))
        if self._stops is None or config.exposure_lag == 0:
            self._stops = wanted
        else:
            kept = exp(-seconds / config.exposure_lag)
            self._stops = kept * self._stops + (1.0 - kept) * wanted
        return float(2.0**self._stops)


def noisy_colour(
    rgb: NDArray[np.uint8],
    gain: float,
    shift: float,
    config: ColourNoiseConfig,
    rng: np.random.Generator,
) -> NDArray[np.uint8]:
    """Add the errors of a camera to a picture (H, W, 3).

    Args:
        rgb: The rendered picture.
        gain: Gain of the exposure.
        shift: How far the picture moves along its rows during the exposure [px].
        config: The error model.
        rng: Source of the noise, of which always as much is drawn, whatever is switched off.
    """
    flicker = 1.0 + config.flicker * float(rng.standard_normal())
    draws = random_bytes((rgb.shape[0], rgb.shape[1]), rng)
    blurred = motion_blurred(rgb, shift)
    exposed = cv2.convertScaleAbs(blurred, alpha=gain * flicker) if gain * flicker != 1 else blurred
    # One draw for the three channels: most of the noise of a small sensor is in brightness.
    error = np.round(config.noise * gain * NORMAL)
    more, less = (
        cv2.cvtColor(
            cv2.LUT(draws, np.clip(sign * error, 0, 255).astype(np.uint8)), cv2.COLOR_GRAY2RGB
        )
        for sign in (1, -1)
    )
    brighter = cv2.add(exposed, more, dst=more)
    return np.asarray(cv2.subtract(brighter, less, dst=brighter), np.uint8)


def motion_blurred(rgb: NDArray[np.uint8], shift: float) -> NDArray[np.uint8]:
    """A picture smeared over `shift` [px] along its rows, half to each side."""
    length = abs(shift)
    if length <= 1.0:
        return rgb
    reach = int(np.ceil((length - 1.0) / 2))
    edges = np.clip(np.arange(-reach, reach + 2) - 0.5, -length / 2, length / 2)
    kernel = np.diff(edges) / length
    return np.asarray(cv2.sepFilter2D(rgb, -1, kernel, np.ones(1)), np.uint8)
