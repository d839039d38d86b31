"""Errors of a D435i's colours, and of its depth: noise, steps, holes, bleeding, limited range.

Stereo measures disparity d = f B / z, so an error of disparity grows in depth with z^2 / (f B)
(Intel, "Best-Known-Methods for Tuning Intel RealSense D400 Depth Cameras", section on depth RMS).
Depth is that of the left imager: what only that one sees, to the left of near things, is lost
("Projection, Texture-Mapping and Occlusion with Intel RealSense Depth Cameras"). Where there is
little light, too much of it, or nothing to match, there are holes; the projector's dots help
against the last one near by.
"""

from __future__ import annotations

from math import exp

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from sim_stubs.realsense.config import ColourNoiseConfig, DepthNoiseConfig
from vizbot.core.geometry import transform
from vizbot.core.program.kernels import kernel
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
    errors = random_bytes((height // 2, width // 2), rng)
    bleeds = rng.random((height // 4, width // 4), np.float32) < config.bleeding
    flicker = NORMAL[random_bytes((height // _COARSE, width // _COARSE), rng)]

    true = depth.copy()
    true[~(depth > 0)] = _NOTHING
    constant = np.float32(intrinsics.fx * config.baseline)
    # Every other row will do: shadows are as high as what casts them.
    hidden = occluded(np.float32(config.occlusion) * (constant / true[::2]))
    holes = _holes(true, rgb, _patches(true, intrinsics, T_world_cam) + 0.2 * flicker, config)
    edges = config.edge_width > 0 and config.edge_jump > 0
    width = config.edge_width if edges else 1
    measured = np.empty_like(true)
    _measure(
        true,
        cv2.erode(true, np.ones((width, width), np.uint8)),
        hidden,
        holes,
        bleeds,
        errors,
        np.float32(config.disparity_noise) * NORMAL,
        np.float32(config.disparity_step),
        constant,
        np.float32(config.least_range),
        np.float32(1.0 + config.edge_jump if edges else np.inf),
        measured,
    )
    return measured


def random_bytes(shape: tuple[int, int], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Equally likely bytes: those of `Generator.bytes`, where possible drawn eight at a time."""
    count = shape[0] * shape[1]
    # Half of a former draw may be left, which comes first.
    if count % 8 or rng.bit_generator.state["has_uint32"]:
        return np.frombuffer(bytearray(rng.bytes(count)), np.uint8).reshape(shape)
    return rng.integers(0, 2**64, count // 8, np.uint64).view(np.uint8).reshape(shape)


def occluded(disparity: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Pixels (H, W) of the left imager that the right one does not see, by disparities [px].

    A pixel at u is seen at u - d from the right; something nearer, from farther right in the left
    image, lies before it there.
    """
    hidden = np.empty(disparity.shape, np.bool_)
    _hide(disparity, hidden)
    return hidden


@kernel("void(f4[:,::1], b1[:,::1])", error_model="numpy")
def _hide(disparity: NDArray[np.float32], hidden: NDArray[np.bool_]) -> None:
    rows, columns = disparity.shape
    for row in range(rows):
        nearest = np.float32(np.inf)
        for column in range(columns - 1, -1, -1):
            seen = np.float32(column) - disparity[row, column]
            hidden[row, column] = seen > nearest
            nearest = min(nearest, seen)


@kernel(
    "void(f4[:,::1], f4[:,::1], b1[:,::1], b1[:,::1], b1[:,::1], u1[:,::1], f4[::1], f4, f4, f4,"
    " f4, f4[:,::1])",
    error_model="numpy",
)
def _measure(
    true: NDArray[np.float32],
    near: NDArray[np.float32],
    hidden: NDArray[np.bool_],
    holes: NDArray[np.bool_],
    bleeds: NDArray[np.bool_],
    errors: NDArray[np.uint8],
    noise: NDArray[np.float32],
    step: np.float32,
    constant: np.float32,
    least: np.float32,
    beyond: np.float32,
    measured: NDArray[np.float32],
) -> None:
    """Write what is measured (H, W) [m].

    Args:
        true: True depth (H, W), `_NOTHING` where there is nothing.
        near: Least depth (H, W) within the matching window.
        hidden: What the right imager does not see (H / 2, W).
        holes: Where nothing matches (H / 2, W / 2).
        bleeds: Where the near side of an edge bleeds into the far one (H / 4, W / 4).
        errors: Index in `noise` (H / 2, W / 2).
        noise: Errors of disparity [px].
        step: Disparities are whole multiples of this [px]; 0 for any.
        constant: Product of disparity and depth [px m].
        least: Least measured depth [m].
        beyond: How many times as far as the near side something is beyond an edge.
        measured: What is measured; 0 where nothing is.
    """
    nothing, one_thousandth = np.float32(0.0), np.float32(1e-3)
    exact = step == nothing and noise[0] == nothing
    rows, columns = true.shape
    lost = np.empty(columns, np.bool_)
    bled = np.empty(columns, np.bool_)
    error = np.empty(columns, np.float32)
    for row in range(rows):
        if row % 2 == 0:
            for column in range(columns):
                lost[column] = hidden[row // 2, column] | holes[row // 2, column // 2]
                bled[column] = bleeds[row // 4, column // 4]
                error[column] = noise[errors[row // 2, column // 2]]
        for column in range(columns):
            far, close = true[row, column], near[row, column]
            edge = far > beyond * close
            taken = edge & bled[column]
            # What bleeds in was measured on the near side.
            z = close if taken else far
            valid = (far < _NOTHING) & (z >= least) & (taken | ~(edge | lost[column]))
            if not exact:
                disparity = constant / z + error[column]
                if step > nothing:
                    disparity = np.rint(disparity / step) * step
                z = constant / max(disparity, one_thousandth)
            measured[row, column] = z if valid else nothing


def _holes(
    depth: NDArray[np.float32],
    rgb: NDArray[np.uint8],
    patches: NDArray[np.float32],
    config: DepthNoiseConfig,
) -> NDArray[np.bool_]:
    """Pixels (H / 2, W / 2) without a match because of light, surface or distance."""
    size = (depth.shape[1] // 2, depth.shape[0] // 2)
    chance = cv2.resize(patches, size)
    z = depth[::2, ::2]
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
    smooth = cv2.blur(grey, (9, 9))
    light = smooth[::2, ::2]
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
    return np.asarray(holes, np.bool_)


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
