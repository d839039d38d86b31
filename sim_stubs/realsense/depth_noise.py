"""Depth errors of a D435i: noise, steps, holes, bleeding, limited range.

Stereo measures disparity d = f B / z, so an error of disparity grows in depth with z^2 / (f B)
(Intel, "Best-Known-Methods for Tuning Intel RealSense D400 Depth Cameras", section on depth RMS).
Depth is that of the left imager: what only that one sees, to the left of near things, is lost
("Projection, Texture-Mapping and Occlusion with Intel RealSense Depth Cameras"). Where there is
little light, too much of it, or nothing to match, there are holes; the projector's dots help
against the last one near by.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from sim_stubs.realsense.config import DepthNoiseConfig
from vizbot.core.geometry import transform
from vizbot.core.types import SE3, Intrinsics

NORMAL = ndtri((np.arange(256) + 0.5) / 256).astype(np.float32)
"""256 equally likely values of a normal distribution: bytes become noise by looking them up."""
_NOTHING = np.float32(1e3)
"""Depth of pixels without a surface [m]."""
_COARSE = 16
"""Distance in the image between the places for which holes are drawn [px]."""
_PATCH = 0.12
"""Size in the world of patches that share a draw [m]."""


def noisy_depth(
    depth: NDArray[np.float32],
    rgb: NDArray[np.uint8],
    intrinsics: Intrinsics,
    T_world_cam: SE3,
    config: DepthNoiseConfig,
    rng: np.random.Generator,
) -> NDArray[np.float32]:
    """A measured depth image (H, W) [m] for a true one; 0 where nothing was measured.

    Holes depend on the picture. Random holes keep their places in the world, so that they do not
    flicker.

    Args:
        depth: True depth [m], 0 where there is nothing.
        rgb: True colours (H, W, 3).
        intrinsics: Intrinsics of both.
        T_world_cam: Pose of the camera.
        config: The error model.
        rng: Source of the noise, of which always as much is drawn, whatever is switched off.
    """
    height, width = depth.shape
    # Neighbouring pixels are matched with overlapping windows, so their errors are alike.
    error = _normal((height // 2, width // 2), rng)
    bleeds = rng.random((height // 4, width // 4), np.float32) < config.bleeding
    flicker = _normal((height // _COARSE, width // _COARSE), rng)

    there = depth > 0
    true = np.where(there, depth, _NOTHING)
    valid = there & (true >= config.least_range)
    valid &= ~_holes(true, rgb, _patches(true, intrinsics, T_world_cam) + 0.2 * flicker, config)
    constant = np.float32(intrinsics.fx * config.baseline)
    disparity = constant / true
    if config.occlusion > 0:
        # Every other row will do: shadows are as high as what casts them.
        shadow = occluded(np.float32(config.occlusion) * disparity[::2])
        valid &= ~np.repeat(shadow, 2, axis=0)
    if config.edge_width > 0 and config.edge_jump > 0:
        near = cv2.erode(true, np.ones((config.edge_width, config.edge_width), np.uint8))
        beyond = true > (1.0 + config.edge_jump) * near
        taken = beyond & _enlarged(bleeds, depth.shape)
        # What bleeds in was measured on the near side.
        valid = (valid & ~beyond) | (taken & there & (near >= config.least_range))
        np.copyto(true, near, where=taken)
        np.divide(constant, true, out=disparity, where=taken)
    if config.disparity_step == 0 and config.disparity_noise == 0:
        return np.asarray(true * valid, np.float32)
    if config.disparity_noise > 0:
        disparity += _enlarged(np.float32(config.disparity_noise) * error, depth.shape)
    if config.disparity_step > 0:
        step = np.float32(config.disparity_step)
        np.rint(disparity / step, out=disparity)
        disparity *= step
    return np.asarray(valid * constant / np.maximum(disparity, np.float32(1e-3)), np.float32)


def occluded(disparity: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Pixels (H, W) of the left imager that the right one does not see, by disparities [px].

    A pixel at u is seen at u - d from the right; something nearer, from farther right in the left
    image, lies before it there.
    """
    columns = np.arange(disparity.shape[1], dtype=np.float32) - disparity
    nearest = np.minimum.accumulate(columns[:, ::-1], axis=1)[:, ::-1]
    hidden = np.zeros(disparity.shape, np.bool_)
    np.greater(columns[:, :-1], nearest[:, 1:], out=hidden[:, :-1])
    return hidden


def _holes(
    depth: NDArray[np.float32],
    rgb: NDArray[np.uint8],
    patches: NDArray[np.float32],
    config: DepthNoiseConfig,
) -> NDArray[np.bool_]:
    """Pixels (H, W) without a match because of light, surface or distance, at half resolution."""
    size = (depth.shape[1] // 2, depth.shape[0] // 2)
    chance = cv2.resize(patches, size)
    z = cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST)
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
    smooth = cv2.blur(grey, (9, 9))
    light = cv2.resize(smooth, size, interpolation=cv2.INTER_NEAREST)
    holes = light < config.dark * (1.0 + 0.25 * chance)
    if config.shiny > 0:
        holes |= light > 255.0 * config.shiny
    if config.plain > 0:
        contrast = cv2.resize(
            cv2.absdiff(grey, smooth).astype(np.float32), size, interpolation=cv2.INTER_AREA
        )
        needed = np.float32(config.plain) * np.maximum(z - config.projector_range, 0.0)
        holes |= cv2.blur(contrast, (7, 7)) < needed * (1.0 + 0.5 * chance)
    if config.greatest_range > 0:
        holes |= z > config.greatest_range + config.range_fade * chance
    return _enlarged(holes, depth.shape)


def _patches(
    depth: NDArray[np.float32], intrinsics: Intrinsics, T_world_cam: SE3
) -> NDArray[np.float32]:
    """Normal values on a coarse grid over the image that belong to places in the world."""
    rows, columns = (np.arange(n // _COARSE) * _COARSE + _COARSE // 2 for n in depth.shape)
    metres = depth[np.ix_(rows, columns)].astype(np.float64)
    rays = np.stack(np.broadcast_arrays(
        (columns - intrinsics.cx) / intrinsics.fx,
        ((rows - intrinsics.cy) / intrinsics.fy)[:, None],
        1.0,
    ), axis=-1)  # fmt: skip
    places = np.floor(transform(T_world_cam, rays * metres[..., None]) / _PATCH).astype(np.int64)
    # The spatial hash of Teschner et al. 2003, mixed once more.
    x, y, z = np.moveaxis(places * np.array([73856093, 19349663, 83492791]), -1, 0)
    mixed = (x ^ y ^ z) & 0xFFFFFFFF
    mixed = ((mixed ^ mixed >> 15) * 0x2C1B3C6D) & 0xFFFFFFFF
    return np.asarray(NORMAL[(mixed ^ mixed >> 13) >> 8 & 255])


def _normal(shape: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float32]:
    draws = np.frombuffer(rng.bytes(shape[0] * shape[1]), np.uint8)
    return np.asarray(NORMAL[draws].reshape(shape))


def _enlarged(image: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    rows, columns = shape[0] // image.shape[0], shape[1] // image.shape[1]
    return np.repeat(np.repeat(image, rows, axis=0), columns, axis=1)
