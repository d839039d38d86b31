"""Augmentation of training patches: other proportions, angles, light and colours, hidden parts."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn.functional import affine_grid, grid_sample

STRETCH, ZOOM, TILT = 0.12, 0.1, 0.06
"""Standard deviations of width to height and of size (as logarithms), and of the roll [rad]."""
SHIFT = 0.12
"""Farthest shift, as a part of half the edge."""
HIDDEN, HIDDEN_EDGE = 0.35, (0.15, 0.4)
"""Part of the patches in which a rectangle is hidden, and its edges as parts of the patch's."""


def augmented(values: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
    """Images (N, 3, H, W), values in -1 to 1, with random changes."""
    values = _hidden(_bent(values, rng), rng)
    values = (values + 1.0) * _drawn(values, rng, 0.7, 1.25) - 1.0
    values = (values + 1.0) * _drawn(values, rng, 0.92, 1.08, channels=3) - 1.0
    middle = values.mean(dim=(1, 2, 3), keepdim=True)
    values = (values - middle) * _drawn(values, rng, 0.75, 1.25) + middle
    dice = torch.Generator().manual_seed(int(rng.integers(2**31)))
    values = values + _drawn(values, rng, 0.0, 0.06) * torch.randn(values.shape, generator=dice)
    return values.clamp(-1.0, 1.0).contiguous(memory_format=torch.channels_last)


def swap_channels(
    pixels: NDArray[np.uint8], part: float, rng: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Swap red, green and blue in about a `part` of patches (N, H, W, 3).

    Returns:
        The patches, and (N,) which of them have changed colours.
    """
    others = np.array([(0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)])
    changed = rng.random(len(pixels)) < part
    result = pixels.copy()
    for i in np.flatnonzero(changed):
        result[i] = pixels[i][..., others[rng.integers(len(others))]]
    return result, changed


def _bent(values: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
    """Mirrored, stretched, rolled and shifted."""
    count = len(values)
    zoom = np.exp(rng.normal(0.0, ZOOM, count))
    stretch = np.exp(rng.normal(0.0, STRETCH, count))
    across, down = zoom * stretch, zoom / stretch
    roll = rng.normal(0.0, TILT, count)
    mirror = np.where(rng.random(count) < 0.5, -1.0, 1.0)
    shift = rng.uniform(-SHIFT, SHIFT, (2, count))
    rows = np.array([[mirror * across * np.cos(roll), -down * np.sin(roll), shift[0]],
                     [mirror * across * np.sin(roll), down * np.cos(roll), shift[1]]])  # fmt: skip
    theta = torch.from_numpy(rows.transpose(2, 0, 1).astype(np.float32))
    grid = affine_grid(theta, list(values.shape), align_corners=False)
    return grid_sample(values, grid, padding_mode="reflection", align_corners=False)


def _hidden(values: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
    """A grey rectangle before some."""
    _, _, height, width = values.shape
    for i in np.flatnonzero(rng.random(len(values)) < HIDDEN):
        h, w = (rng.uniform(*HIDDEN_EDGE, 2) * (height, width)).astype(int)
        v, u = rng.integers(height - h + 1), rng.integers(width - w + 1)
        values[i, :, v : v + h, u : u + w] = float(rng.uniform(-1.0, 1.0))
    return values


def _drawn(
    values: torch.Tensor, rng: np.random.Generator, low: float, high: float, channels: int = 1
) -> torch.Tensor:
    sample = rng.uniform(low, high, (len(values), channels, 1, 1)).astype(np.float32)
    return torch.from_numpy(sample)
