"""Ray-cast rooms whose walls and boxes are known, and the maps made of them."""

import numpy as np

from vizbot.core.geometry import camera_mount
from vizbot.core.types import Intrinsics, OccupancyGrid

INTRINSICS = Intrinsics(320, 240, 303.0, 303.0, 159.5, 119.5)
MOUNT = camera_mount(0.6, 0.0, 0.25)
ROOM = ((-3.0, -3.0, 0.0), (3.0, 3.0, 2.5))
LOW_BOX = ((1.0, -0.3, 0.0), (1.3, 0.3, 0.25))
SHELF = ((1.0, -0.4, 1.0), (1.5, 0.4, 1.2))


def _rays(T_map_cam) -> np.ndarray:
    v, u = np.mgrid[: INTRINSICS.height, : INTRINSICS.width]
    x, y = (u - INTRINSICS.cx) / INTRINSICS.fx, (v - INTRINSICS.cy) / INTRINSICS.fy
    return np.stack([x, y, np.ones_like(x)], -1) @ T_map_cam[:3, :3].T


def depth_of(T_map_cam, boxes=(), rng=None) -> np.ndarray:
    """Depth (H, W) of a room and boxes in it; with `rng`, noise, holes and flying pixels."""
    rays = _rays(T_map_cam)
    rays[rays == 0] = 1e-12
    ends = [(np.array(box) - T_map_cam[:3, 3])[:, None, None] / rays for box in (ROOM, *boxes)]
    depth = np.maximum(*ends[0]).min(-1)
    for first, second in ends[1:]:
        enter, leave = np.minimum(first, second).max(-1), np.maximum(first, second).min(-1)
        depth = np.where((enter < leave) & (enter > 0), np.minimum(depth, enter), depth)
    if rng is not None:
        edge = np.abs(np.diff(depth, axis=1, append=depth[:, -1:])) > 0.1
        behind = np.roll(depth, -1, axis=1)
        depth[edge] += (rng.random(depth.shape) * (behind - depth))[edge]
        depth += 0.003 * depth**2 * rng.standard_normal(depth.shape)
        depth[rng.random(depth.shape) < 0.2] = 0.0
    return depth.astype(np.float32)


def see(mapper, T_map_base, boxes=(), keyframe=0, frames=1, rng=None, holes=None) -> None:
    T_map_cam = T_map_base @ MOUNT
    for _ in range(frames):
        depth = depth_of(T_map_cam, boxes, rng)
        if holes is not None:
            depth[holes(depth)] = 0.0
        mapper.integrate(keyframe, np.eye(4), T_map_cam, depth, INTRINSICS)


def at(grid: OccupancyGrid, x: float, y: float) -> float:
    return float(grid.occupancy[tuple(grid.to_cells(np.array([x, y])))])


def occupied_xy(grid: OccupancyGrid) -> np.ndarray:
    return grid.to_xy(np.argwhere(grid.occupancy > 0.65))


def stairwell(T_map_cam, rng=None) -> np.ndarray:
    """Depth of an endless floor with a hole 1.5 m deep, x from 1.6 to 2.6 and |y| below 0.6 [m]."""
    depth = depth_of(T_map_cam)
    rays = _rays(T_map_cam)
    place = T_map_cam[:3, 3] + depth[..., None] * rays
    inside = (np.abs(place[..., 0] - 2.1) < 0.5) & (np.abs(place[..., 1]) < 0.6)
    hole = inside & (np.abs(place[..., 2]) < 0.01)
    down = (place[..., 2] - 1.5 - T_map_cam[2, 3]) / rays[..., 2]
    across = (2.6 - T_map_cam[0, 3]) / rays[..., 0]
    depth[hole] = np.minimum(down, np.where(across > 0, across, np.inf))[hole]
    if rng is not None:
        depth += 0.003 * depth**2 * rng.standard_normal(depth.shape)
    return depth.astype(np.float32)


ASKEW_MIDDLE = np.array([5.0, 5.0])
_SIZE = np.array([7.0, 4.5])
_THICKNESS = 0.1


def _axes(angle):
    """Directions along the longer and the shorter walls, counterclockwise."""
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def askew_room(angle, seen=1.0):
    """A rectangular room.

    Args:
        angle: Direction of its longer walls, counterclockwise from x [rad].
        seen: Share of it that is known, from its left end on.
    """
    cells = np.stack(np.meshgrid(np.arange(200), np.arange(200)), axis=-1)
    offsets = np.abs(turned := ((cells + 0.5) * 0.05 - ASKEW_MIDDLE) @ _axes(angle).T)
    room = (offsets < _SIZE / 2).all(axis=-1)
    floor = (offsets < _SIZE / 2 - _THICKNESS).all(axis=-1)
    occupancy = np.where(floor, 0.1, np.where(room, 0.9, 0.5))
    occupancy[turned[..., 0] > (seen - 0.5) * _SIZE[0]] = 0.5
    return OccupancyGrid(occupancy.astype(np.float32), 0.05, np.zeros(2))


def askew_corners(angle):
    """The corners of its floor (4, 2) x, y in `map` [m], counterclockwise."""
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return ASKEW_MIDDLE + signs * (_SIZE / 2 - _THICKNESS) @ _axes(angle)
