"""A depth image flattened to the floor: a polar picture of what is free and what stands in the way.

The scan lives in the `level` frame of its camera: origin on the floor below the optical centre, x
along the heading of the optical axis, z up. It is all the depth mapper keeps of a frame, so it can
be painted again when its keyframe moves.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import BaseModel

from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, Intrinsics

BEARINGS = 720
"""Bearing bins of a full turn: half a degree is 4 cm at 4.5 m, narrower than a map cell."""

NOTHING, PASSED, DROP, FLOOR, OBSTACLE = 0, 1, 2, 3, 4
"""What a polar cell holds, in rising order of precedence."""


class ScanConfig(BaseModel):
    """How a depth image is read as floor and obstacles."""

    model_config = SETTINGS

    stride: int = 2
    """Every so many pixels, along rows and columns, one is read."""
    min_depth: float = 0.15
    """Depth below this is not believed [m]."""
    max_range: float = 4.5
    """Points farther than this over the floor are not used [m]."""
    range_step: float = 0.025
    """Length of a polar cell [m]; half a map cell, so that no map cell is skipped."""
    min_height: float = 0.06
    """Points between the floor and this height are floor [m]."""
    max_height: float = 0.75
    """The robot, mast included, passes under anything above this [m]."""
    tilt_tolerance: float = 0.012
    """Error of the camera's pitch that must not lift the floor into the band [rad]."""
    depth_noise: float = 0.003
    """Standard deviation of depth is this times the square of the range [1/m] (D435i)."""
    edge_step: float = 0.05
    """A pixel whose neighbour is nearer or farther by this fraction is a flying pixel."""
    min_points: int = 3
    """Pixels that a polar cell needs to hold an obstacle; a drop needs them within four cells."""
    drop_depth: float = 0.08
    """What lies deeper below the floor is seen through a hole in it, as down a staircase [m]."""
    drop_range: float = 2.0
    """Drops farther away are not believed: pitch errs, and shiny floors mirror the room [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class PlanarScan:
    """What each polar cell around a camera holds, in some kilobytes.

    Attributes:
        first_bearing: Bin of row 0; bin b is centred (b + 0.5) / BEARINGS of a turn from -x.
        shape: Bearings, ranges of the picture.
        packed: The (bearings, ranges) uint8 picture of NOTHING to OBSTACLE, deflated.
    """

    first_bearing: int
    shape: tuple[int, int]
    packed: bytes

    def evidence(self) -> NDArray[np.uint8]:
        """The picture (bearings, ranges) uint8."""
        return np.frombuffer(zlib.decompress(self.packed), np.uint8).reshape(self.shape)


def level_pose(T_map_cam: SE3) -> SE3:
    """T_map_level of a camera: below it on the floor, x along the optical axis."""
    yaw = np.arctan2(T_map_cam[1, 2], T_map_cam[0, 2])
    T_map_level = np.eye(4)
    c, s = np.cos(yaw), np.sin(yaw)
    T_map_level[:2, :2] = [[c, -s], [s, c]]
    T_map_level[:2, 3] = T_map_cam[:2, 3]
    return T_map_level


def flatten(
    depth: NDArray[np.float32], intrinsics: Intrinsics, T_level_cam: SE3, config: ScanConfig
) -> PlanarScan:
    """Scan of a depth image (H, W) [m], 0 where nothing was measured.

    An obstacle needs several pixels in one polar cell. So does a drop, which lies where the rays to
    what is below the floor go through the floor. Seen floor is free wherever it lies. Between
    the nearest floor that the image can show and the first obstacle or drop (or, without one, the
    last floor seen) a cell was passed by rays, which is weaker: the ray may have gone above
    something. Behind the first obstacle or drop only seen floor counts.
    """
    ranges = int(np.ceil(config.max_range / config.range_step))
    obstacles = np.zeros((BEARINGS, ranges), np.uint16)
    floor, drops = np.zeros_like(obstacles), np.zeros_like(obstacles)
    lens = np.array([intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy])
    _project(
        depth,
        lens,
        T_level_cam,
        config.stride,
        config.min_depth,
        config.range_step,
        config.min_height,
        config.max_height,
        config.tilt_tolerance,
        config.edge_step,
        config.drop_depth,
        config.drop_range,
        obstacles,
        floor,
        drops,
    )
    nearest = np.full(BEARINGS, ranges, np.int64)
    _nearest_floor_in_view(
        depth.shape, lens, T_level_cam, config.min_height, config.range_step, nearest
    )
    evidence = _classify(obstacles, floor, drops, nearest, config.min_points)
    seen = np.flatnonzero(evidence.any(axis=1))
    first, last = (int(seen[0]), int(seen[-1]) + 1) if len(seen) else (0, 0)
    kept = evidence[first:last]
    return PlanarScan(first, kept.shape, zlib.compress(kept.tobytes(), 1))


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _project(
    depth: NDArray[np.float32],
    lens: NDArray[np.float64],
    T_level_cam: SE3,
    stride: int,
    min_depth: float,
    range_step: float,
    min_height: float,
    max_height: float,
    tilt_tolerance: float,
    edge_step: float,
    drop_depth: float,
    drop_range: float,
    obstacles: NDArray[np.uint16],
    floor: NDArray[np.uint16],
    drops: NDArray[np.uint16],
) -> None:
    """Count the pixels of each polar cell that show floor, an obstacle, or what is below it."""
    fx, fy, cx, cy = lens
    bearings, ranges = obstacles.shape
    for v in range(stride // 2, depth.shape[0] - 1, stride):
        for u in range(stride // 2, depth.shape[1] - 1, stride):
            z_cam = depth[v, u]
            if not z_cam >= min_depth:
                continue
            x_cam, y_cam = (u - cx) / fx * z_cam, (v - cy) / fy * z_cam
            z = (
                T_level_cam[2, 0] * x_cam
                + T_level_cam[2, 1] * y_cam
                + T_level_cam[2, 2] * z_cam
                + T_level_cam[2, 3]
            )
            if z > max_height:
                continue
            x = T_level_cam[0, 0] * x_cam + T_level_cam[0, 1] * y_cam + T_level_cam[0, 2] * z_cam
            y = T_level_cam[1, 0] * x_cam + T_level_cam[1, 1] * y_cam + T_level_cam[1, 2] * z_cam
            distance = np.sqrt(x * x + y * y)
            floor_top = min_height + tilt_tolerance * distance
            b = int((np.arctan2(y, x) / (2 * np.pi) + 0.5) * bearings) % bearings
            if z < -drop_depth - tilt_tolerance * distance:
                through = distance * T_level_cam[2, 3] / (T_level_cam[2, 3] - z)
                if through < drop_range:
                    drops[b, int(through / range_step)] += 1
            if not distance < ranges * range_step or z < -floor_top:
                continue
            r = int(distance / range_step)
            if z < floor_top:
                floor[b, r] += 1
                continue
            step = edge_step * z_cam
            flying = False
            for dv, du in ((0, -1), (0, 1), (-1, 0), (1, 0)):
                if v + dv >= 0 and u + du >= 0:
                    neighbour = depth[v + dv, u + du]
                    flying |= neighbour > 0 and abs(neighbour - z_cam) > step
            if not flying:
                obstacles[b, r] += 1


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _nearest_floor_in_view(
    shape: tuple[int, int],
    lens: NDArray[np.float64],
    T_level_cam: SE3,
    min_height: float,
    range_step: float,
    nearest: NDArray[np.int64],
) -> None:
    """Range cell, per bearing, from which on the lowest image row looks under `min_height`.

    Nearer than that a low obstacle can stand below the image, and rays above it prove nothing.
    """
    fx, fy, cx, cy = lens
    y_cam = (shape[0] - 1 - cy) / fy
    for u in range(shape[1]):
        x_cam = (u - cx) / fx
        x = T_level_cam[0, 0] * x_cam + T_level_cam[0, 1] * y_cam + T_level_cam[0, 2]
        y = T_level_cam[1, 0] * x_cam + T_level_cam[1, 1] * y_cam + T_level_cam[1, 2]
        drop = -(T_level_cam[2, 0] * x_cam + T_level_cam[2, 1] * y_cam + T_level_cam[2, 2])
        if drop > 1e-6:
            distance = (T_level_cam[2, 3] - min_height) * np.sqrt(x * x + y * y) / drop
            b = int((np.arctan2(y, x) / (2 * np.pi) + 0.5) * len(nearest)) % len(nearest)
            nearest[b] = min(nearest[b], max(int(distance / range_step), 0) + 1)


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _classify(
    obstacles: NDArray[np.uint16],
    floor: NDArray[np.uint16],
    drops: NDArray[np.uint16],
    nearest: NDArray[np.int64],
    min_points: int,
) -> NDArray[np.uint8]:
    """NOTHING to OBSTACLE for every polar cell."""
    bearings, ranges = obstacles.shape
    evidence = np.zeros((bearings, ranges), np.uint8)
    for b in range(bearings):
        first_obstacle, last_floor, count = ranges, 0, 0
        for r in range(ranges):
            count += obstacles[b, r]
            if count >= min_points or (drops[b, r] > 0 and drops[b, r : r + 4].sum() >= min_points):
                first_obstacle = r
                break
            if floor[b, r] > 0:
                last_floor = r
        passed_to = first_obstacle if first_obstacle < ranges else last_floor
        for r in range(nearest[b], passed_to):
            evidence[b, r] = PASSED
        for r in range(ranges):
            # Rays through the floor fall far apart: those just behind count, too.
            if drops[b, r] > 0 and drops[b, r : r + 4].sum() >= min_points:
                evidence[b, r] = DROP
            if floor[b, r] > 0:
                evidence[b, r] = FLOOR
            if obstacles[b, r] >= min_points:
                evidence[b, r] = OBSTACLE
    return evidence
