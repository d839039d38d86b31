"""What a D435i's pictures have that rendered ones have not: noise, holes, a least distance.

Stereo measures disparity d = f B / z, so an error of disparity grows in depth with z^2 / (f B)
(Intel, "Best-Known-Methods for Tuning Intel RealSense D400 Depth Cameras", section on depth RMS).
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from vizbot.core.settings import SETTINGS


class DepthNoiseConfig(BaseModel):
    """The error model of depth; zero switches a part off."""

    model_config = SETTINGS

    baseline: float = Field(default=0.05, gt=0.0)
    """Distance of the two infrared cameras [m]."""
    disparity_noise: float = Field(default=0.08, ge=0.0)
    """Standard deviation of the disparity [px]."""
    disparity_step: float = Field(default=1.0 / 32.0, ge=0.0)
    """Disparities are whole multiples of this [px]."""
    edge_jump: float = Field(default=0.08, ge=0.0)
    """Relative step of depth between neighbours that leaves a hole; 0 leaves none."""
    edge_width: int = Field(default=5, ge=1)
    """Width of such a hole along the rows [px]."""
    least_range: float = Field(default=0.28, ge=0.0)
    """Nothing nearer is measured [m]."""
    greatest_range: float = Field(default=8.0, ge=0.0)
    """Nothing farther is measured [m]; 0 sets no limit."""


class ColourNoiseConfig(BaseModel):
    """The error model of colour; zero switches a part off."""

    model_config = SETTINGS

    noise: float = Field(default=2.0, ge=0.0)
    """Standard deviation of each value, of 255."""
    exposure: float = Field(default=0.02, ge=0.0)
    """Standard deviation of the relative brightness of a frame."""


def noisy_depth(
    depth: NDArray[np.float32],
    focal_length: float,
    config: DepthNoiseConfig,
    rng: np.random.Generator,
) -> NDArray[np.float32]:
    """A measured depth image (H, W) [m] for a true one; 0 where nothing was measured.

    Args:
        depth: True depth [m], 0 where there is nothing.
        focal_length: Of the image [px].
        config: The error model.
        rng: Noise is drawn from it, always as much, whatever is switched off.
    """
    height, width = depth.shape
    # Neighbouring pixels are matched with overlapping windows, so their errors are alike.
    coarse = rng.standard_normal((height // 2, width // 2), np.float32)
    error = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_NEAREST)
    valid = (depth > 0) & (depth >= config.least_range)
    if config.greatest_range > 0:
        valid &= depth <= config.greatest_range
    if config.edge_jump > 0:
        kernel = np.ones((3, config.edge_width), np.uint8)
        far, near = cv2.dilate(depth, kernel), cv2.erode(depth, kernel)
        valid &= far - near <= config.edge_jump * near
    if config.disparity_noise == 0 and config.disparity_step == 0:
        return np.where(valid, depth, np.float32(0.0))
    constant = np.float32(focal_length * config.baseline)
    disparity = constant / np.where(valid, depth, np.float32(1.0))
    disparity += np.float32(config.disparity_noise) * error
    if config.disparity_step > 0:
        step = np.float32(config.disparity_step)
        disparity = np.round(disparity / step) * step
    measured = constant / np.maximum(disparity, np.float32(1e-3))
    return np.where(valid, measured, np.float32(0.0)).astype(np.float32)


def noisy_colour(
    rgb: NDArray[np.uint8], config: ColourNoiseConfig, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """A colour image (H, W, 3) with sensor noise and a slightly wrong exposure."""
    gain = 1.0 + config.exposure * rng.standard_normal()
    # One draw for the three channels: most of the noise of a small sensor is in brightness.
    error = rng.standard_normal(rgb.shape[:2], np.float32)[..., None]
    noisy = rgb * np.float32(gain) + np.float32(config.noise) * error
    return np.asarray(np.clip(np.round(noisy), 0, 255), np.uint8)
