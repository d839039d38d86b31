"""Round and bent solids, built from those of `solids`; metres, z up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from sim_stubs.homes.geometry.solids import Part, Surface, joined, meshed, moved_part
from vizbot.core.geometry import planar

Profile = Sequence[tuple[float, float]]
"""Radius and height of the points of an outline, from below."""


def sheet(
    points: ArrayLike, surface: Surface, *, both: bool = False, stretch: bool = False
) -> Part:
    """A smooth surface through a grid of points (R, C, 3).

    It is seen from the side that columns x rows points to; with `both`, from the other as well.
    A texture repeats every metre, or with `stretch` covers the sheet once.
    """
    grid = np.asarray(points, np.float64)
    rows, columns = grid.shape[:2]
    across, along = np.gradient(grid, axis=1), np.gradient(grid, axis=0)
    normals = np.cross(across, along).reshape(-1, 3)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    # Where an edge shrinks to a point, as at a pole, any direction will do.
    normals[np.linalg.norm(normals, axis=1) < 0.5] = (0.0, 0.0, 1.0)
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    if not stretch:
        u = u * float(np.linalg.norm(np.diff(grid, axis=1), axis=2).sum(axis=1).max())
        v = v * float(np.linalg.norm(np.diff(grid, axis=0), axis=2).sum(axis=0).max())
    part = meshed(
        grid.reshape(-1, 3),
        normals,
        np.column_stack([u.ravel(), v.ravel()]),
        (rows, columns),
        surface,
    )
    return joined([part, _reversed(part)]) if both else part


def turned(
    profile: Profile, surface: Surface, centre: ArrayLike = (0, 0, 0), segments: int = 20
) -> Part:
    """A body of revolution: an outline, straight between its points, turned about the z axis."""
    angles = np.linspace(0, 2 * np.pi, segments + 1)
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    bands = []
    for (r0, z0), (r1, z1) in pairwise(profile):
        slope = np.array([z1 - z0, r0 - r1]) / max(np.hypot(z1 - z0, r0 - r1), 1e-12)
        points = np.concatenate(
            [np.column_stack([ring * r, np.full(len(ring), z)]) for r, z in ((r0, z0), (r1, z1))]
        )
        normals = np.tile(np.column_stack([ring * slope[0], np.full(len(ring), slope[1])]), (2, 1))
        uv = np.column_stack([np.tile(angles * max(r0, r1), 2), np.repeat([z0, z1], len(ring))])
        bands.append(meshed(points, normals, uv, (2, len(ring)), surface))
    return shifted(joined(bands), centre)


def rod(
    start: ArrayLike,
    end: ArrayLike,
    radius: float,
    surface: Surface,
    end_radius: float | None = None,
    segments: int = 8,
) -> Part:
    """A round bar from one point to another; with `end_radius` it tapers."""
    a, b = np.asarray(start, np.float64), np.asarray(end, np.float64)
    length = float(np.linalg.norm(b - a))
    tip = radius if end_radius is None else end_radius
    bar = turned([(0, 0), (radius, 0), (tip, length), (0, length)], surface, segments=segments)
    T = np.eye(4)
    T[:3, :3] = Rotation.align_vectors([(b - a) / length], [[0, 0, 1]])[0].as_matrix()
    T[:3, 3] = a
    return moved_part(bar, T)


def tube(path: ArrayLike, radius: float, surface: Surface, segments: int = 8) -> Part:
    """A bent pipe along points (N, 3)."""
    points = np.asarray(path, np.float64)
    ways = np.gradient(points, axis=0)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    side = np.cross(ways[0], [0.36, 0.48, 0.8])
    rings = []
    angles = np.linspace(0, 2 * np.pi, segments + 1)
    for point, way in zip(points, ways, strict=True):
        side = side - way * (side @ way)
        side /= np.linalg.norm(side)
        up = np.cross(way, side)
        rings.append(
            point + radius * (np.outer(np.cos(angles), side) + np.outer(np.sin(angles), up))
        )
    return sheet(np.array(rings), surface)


def vec(*values: float) -> NDArray[np.float64]:
    """A point or an offset."""
    return np.array(values, np.float64)


def arc_points(
    centre: ArrayLike, u: ArrayLike, v: ArrayLike, start: float, end: float, steps: int = 8
) -> NDArray[np.float64]:
    """Points (steps + 1, 3) of an arc: centre + u cos + v sin, from angle `start` to `end`."""
    angles = np.linspace(start, end, steps + 1)[:, None]
    c, a, b = (np.asarray(vector, np.float64) for vector in (centre, u, v))
    return np.asarray(c + np.cos(angles) * a + np.sin(angles) * b)


def prism(outline: ArrayLike, base: float, height: float, surface: Surface) -> Part:
    """An upright block over a plan (N, 2), counter-clockwise and star-shaped about its mean."""
    plan = np.asarray(outline, np.float64)
    closed = np.vstack([plan, plan[:1]])
    top = np.column_stack([closed, np.full(len(closed), base + height)])
    bottom = np.column_stack([closed, np.full(len(closed), base)])
    middle = np.tile(plan.mean(axis=0), (len(closed), 1))
    upper = np.column_stack([middle, np.full(len(closed), base + height)])
    lower = np.column_stack([middle, np.full(len(closed), base)])
    sides = [
        sheet(np.array([bottom[i : i + 2], top[i : i + 2]]), surface) for i in range(len(plan))
    ]
    return joined([*sides, sheet(np.array([top, upper]), surface),
                   sheet(np.array([lower, bottom]), surface)])  # fmt: skip


def ellipse(width: float, depth: float, steps: int = 24, power: float = 1.0) -> NDArray[np.float64]:
    """Corners (steps, 2) of an ellipse about the origin; with `power` below 1 it is squarer."""
    angles = np.linspace(0, 2 * np.pi, steps, endpoint=False)
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    return np.asarray(np.sign(ways) * np.abs(ways) ** power * (width / 2, depth / 2))


def shifted(part: Part, offset: ArrayLike, yaw: float = 0.0) -> Part:
    """The part turned about the z axis, then moved."""
    x, y, z = np.asarray(offset, np.float64)
    T = planar(float(x), float(y), yaw)
    T[2, 3] = z
    return moved_part(part, T)


def tilted(part: Part, axis: ArrayLike, angle: float, about: ArrayLike = (0, 0, 0)) -> Part:
    """The part turned about an axis through a point."""
    pivot = np.asarray(about, np.float64)
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(angle * np.asarray(axis, np.float64)).as_matrix()
    T[:3, 3] = pivot - T[:3, :3] @ pivot
    return moved_part(part, T)


def facing(part: Part, centre: ArrayLike) -> Part:
    """A part that looks up, made to look to the front (-y), with its origin at `centre`."""
    T = np.eye(4)
    T[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    T[:3, 3] = np.asarray(centre, np.float64)
    return moved_part(part, T)


def translucent(part: Part, alpha: float) -> Part:
    """The part as glass that lets 1 - `alpha` of the light through."""
    return replace(part, rgba=np.array([*part.rgba[:3], alpha], np.float32))


def _reversed(part: Part) -> Part:
    return replace(part, normals=-part.normals, faces=part.faces[:, ::-1].copy())
