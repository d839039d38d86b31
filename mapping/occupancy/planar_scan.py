"""Planar scans: depth images projected to the floor, as polar images of floor and obstacles.

A scan is in the `level` frame of its camera: origin on the floor below the optical centre, x
along the heading of the optical axis, z up. It is all that the depth mapper stores of a frame, so
that it can be painted again when its keyframe moves.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.occupancy.config import ScanConfig
from vizbot.core.program.kernels import kernel
from vizbot.core.types import SE3, Intrinsics

BEARINGS = 720
"""Bearing bins of a full turn: half a degree is 4 cm at 4.5 m, narrower than a map cell."""

NOTHING, PASSED, DROP, FLOOR, OBSTACLE = 0, 1, 2, 3, 4
"""Kinds of evidence in a polar cell, in rising order of precedence."""


@dataclass(frozen=True, slots=True, eq=False)
class PlanarScan:
    """The evidence in each polar cell around a camera, in some kilobytes.

    Attributes:
        first_bearing: Bin of row 0; bin b is centred (b + 0.5) / BEARINGS of a turn from -x.
        shape: Bearings, ranges of the polar image.
        packed: The (bearings, ranges) uint8 image of NOTHING to OBSTACLE, deflated.
    """

    first_bearing: int
    shape: tuple[int, int]
    packed: bytes

    def evidence(self) -> NDArray[np.uint8]:
        """The polar image (bearings, ranges) uint8."""
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
    """Make the scan of a depth image (H, W) [m], 0 where nothing was measured.

    An obstacle needs several pixels in one polar cell. So does a drop, which lies where rays to
    points below the floor pass through it. Seen floor is free wherever it lies. Between the nearest
    floor that the image can show and the first obstacle or drop (or, without one, the last floor
    seen) cells were passed by rays, which is weaker: a ray may have passed above something. Behind
    the first obstacle or drop only seen floor counts.
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


def scan_of_obstacles(points: NDArray[np.float64], config: ScanConfig) -> PlanarScan:
    """The scan that shows obstacles at points (N, 2) x, y in its level frame [m], nothing else.

    Points beyond the scan's range are left out.
    """
    ranges = int(np.ceil(config.max_range / config.range_step))
    evidence = np.zeros((BEARINGS, ranges), np.uint8)
    for x, y in points:
        reached = int(np.hypot(x, y) / config.range_step)
        if reached < ranges:
            evidence[bearing_bin(x, y, BEARINGS), reached] = OBSTACLE
    return PlanarScan(0, evidence.shape, zlib.compress(evidence.tobytes(), 1))


@kernel()
def bearing_bin(x: float, y: float, bearings: int) -> int:
    """Bin of the direction x, y: b is centred (b + 0.5) / bearings of a turn from -x.

    An arctangent takes most of the time of a scan. Ahead, a polynomial that is right within 1e-5
    (Abramowitz and Stegun 1964, 4.4.47) decides, except at the edge of a bin.
    """
    if abs(y) < x:
        t = y / x
        s = t * t
        angle = t * (
            0.9998660 + s * (-0.3302995 + s * (0.1801410 + s * (-0.0851330 + s * 0.0208351)))
        )
        b = (angle / (2 * np.pi) + 0.5) * bearings
        if abs(b - np.rint(b)) > 1e-5 * bearings:
            return int(b)
    return int((np.arctan2(y, x) / (2 * np.pi) + 0.5) * bearings) % bearings


@kernel(
    "void(f4[:,::1], f8[::1], f8[:,::1], i8, f8, f8, f8, f8, f8, f8, f8, f8,"
    " u2[:,::1], u2[:,::1], u2[:,::1])"
)
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
    """Count the pixels of each polar cell that show floor, an obstacle, or points below it."""
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
            b = bearing_bin(x, y, bearings)
            if z < -drop_depth - tilt_tolerance * distance:
                # Negative where the pose has sunk below the floor: nothing is known of drops then.
                through = distance * T_level_cam[2, 3] / (T_level_cam[2, 3] - z)
                if 0.0 <= through < min(drop_range, ranges * range_step):
                    drops[b, min(int(through / range_step), ranges - 1)] += 1
            if not distance < ranges * range_step or z < -floor_top:
                continue
            r = min(int(distance / range_step), ranges - 1)
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


@kernel("void(UniTuple(i8, 2), f8[::1], f8[:,::1], f8, f8, i8[::1])")
def _nearest_floor_in_view(
    shape: tuple[int, int],
    lens: NDArray[np.float64],
    T_level_cam: SE3,
    min_height: float,
    range_step: float,
    nearest: NDArray[np.int64],
) -> None:
    """Range cell, per bearing, from which on the lowest image row sees below `min_height`.

    Nearer than that, a low obstacle may stand below the image, and rays above it prove nothing.
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
            b = bearing_bin(x, y, len(nearest))
            nearest[b] = min(nearest[b], max(int(distance / range_step), 0) + 1)


@kernel("u1[:,::1](u2[:,::1], u2[:,::1], u2[:,::1], i8[::1], i8)")
def _classify(
    obstacles: NDArray[np.uint16],
    floor: NDArray[np.uint16],
    drops: NDArray[np.uint16],
    nearest: NDArray[np.int64],
    min_points: int,
) -> NDArray[np.uint8]:
    """Kind of evidence, NOTHING to OBSTACLE, of every polar cell."""
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
            # Rays through the floor are far apart: those just behind count, too.
            if drops[b, r] > 0 and drops[b, r : r + 4].sum() >= min_points:
                evidence[b, r] = DROP
            if floor[b, r] > 0:
                evidence[b, r] = FLOOR
            if obstacles[b, r] >= min_points:
                evidence[b, r] = OBSTACLE
    return evidence
