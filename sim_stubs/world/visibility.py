"""Visibility of the meshes of a house, so that a renderer draws only what may be in sight.

Two tests, both on the safe side: what is shown may be out of sight, what is hidden never is. A mesh
is hidden when bounding spheres of its pieces lie outside of the picture, or when walls that reach
from the floor to the top of the house stand in front of them. For the second, the plan around the
eye is divided into narrow sectors, and each knows how far one can see at most before a wall closes
it (a depth buffer of one dimension: Greene, Kass and Miller 1993 for the idea).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.solids import Part, triangles
from vizbot.core.program.kernels import kernel
from vizbot.core.types import SE3, Intrinsics

CELL = 1.0
"""Width of the pieces that meshes over twice as wide, as the shell of a room, are cut into [m]."""
RASTER = 0.01
"""Size of the cells of walls [m]; narrower gaps than two cells count as wall."""
SECTORS = 1024
CLIPPED = 0.03
"""Distance below which the near clipping plane may cut a wall, which then hides nothing [m]."""
MARGIN = 1e-3
"""Margin for rounding in the renderer [m]."""


class Visibility:
    """Visibility of meshes behind the walls of a house."""

    def __init__(
        self, walls: Sequence[Part], meshes: Sequence[Part], intrinsics: Intrinsics
    ) -> None:
        """Find opaque walls, and bound the meshes.

        Args:
            walls: Parts that may hide others, in the world; furniture never does.
            meshes: Parts that are drawn, in the world.
            intrinsics: Intrinsics of the camera, with the principal point in the middle.
        """
        corners = triangles([part for part in walls if part.rgba[3] >= 1.0])
        self._top = float(corners[..., 2].max(initial=0.0))
        self._walls = opaque_walls(corners, self._top)
        spheres = [_spheres(part, mesh) for mesh, part in enumerate(meshes)]
        bounds = np.concatenate(spheres) if spheres else np.zeros((0, 8))
        self._count = len(meshes)
        self._mesh = bounds[:, 7].astype(np.intp)
        self._centre, self._radius, self._plan_radius = bounds[:, :3], bounds[:, 3], bounds[:, 4]
        # Only between floor and top is a sight line sure to cross the wall, not to pass it.
        self._indoors = (bounds[:, 5] > -MARGIN) & (bounds[:, 6] < self._top + MARGIN)
        self._slopes = np.array(
            [intrinsics.width / 2 / intrinsics.fx, intrinsics.height / 2 / intrinsics.fy]
        )
        angles = np.linspace(-np.pi, np.pi, SECTORS + 1)
        self._rays = np.stack([np.cos(angles), np.sin(angles)])

    @classmethod
    def in_house(cls, house: House, intrinsics: Intrinsics) -> Self:
        """Of all parts of a house: its structure first, and then instance by instance."""
        return cls(house.structure, house.parts(), intrinsics)

    def seen(self, T_world_cam: SE3) -> NDArray[np.bool_]:
        """Which meshes (M,) may be in the picture."""
        offsets = self._centre - T_world_cam[:3, 3]
        shown = self._in_frustum(offsets @ T_world_cam[:3, :3])
        if len(self._walls) and -MARGIN < T_world_cam[2, 3] < self._top + MARGIN:
            candidates = np.flatnonzero(shown & self._indoors)
            behind = self._behind_walls(
                T_world_cam[:2, 3], offsets[candidates, :2], self._plan_radius[candidates]
            )
            shown[candidates[behind]] = False
        return np.bincount(self._mesh[shown], minlength=self._count) > 0

    def in_view(self, T_world_cam: SE3) -> NDArray[np.bool_]:
        """Which meshes (M,) may be in the picture, whatever walls stand between."""
        offsets = self._centre - T_world_cam[:3, 3]
        shown = self._in_frustum(offsets @ T_world_cam[:3, :3])
        return np.bincount(self._mesh[shown], minlength=self._count) > 0

    def _in_frustum(self, centres: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which spheres (N,), with their centres (N, 3) in `cam`, touch the cone of view."""
        reach = self._radius + MARGIN
        across = np.abs(centres[:, :2]) - centres[:, 2:] * self._slopes
        outside = across > reach[:, None] * np.hypot(1.0, self._slopes)
        return np.asarray((centres[:, 2] > -reach) & ~outside.any(axis=1))

    def _behind_walls(
        self,
        eye: NDArray[np.float64],
        offsets: NDArray[np.float64],
        radii: NDArray[np.float64],
    ) -> NDArray[np.bool_]:
        """Which circles (N,), at `offsets` (N, 2) from the eye on the plan, no sector reaches."""
        distance = np.hypot(offsets[:, 0], offsets[:, 1])
        near = distance - radii - MARGIN
        half = np.arcsin(np.clip((radii + MARGIN) / np.maximum(distance, 1e-9), 0.0, 1.0))
        bearing = np.arctan2(offsets[:, 1], offsets[:, 0])
        width = 2 * np.pi / SECTORS
        first = np.floor((bearing - half + np.pi) / width).astype(np.intp)
        last = np.floor((bearing + half + np.pi) / width).astype(np.intp)
        reach = np.empty(len(first))
        _farthest(self._sight(eye), first, last, reach)
        return np.asarray((near > 0) & (near > reach))

    def _sight(self, eye: NDArray[np.float64]) -> NDArray[np.float64]:
        """Longest sight in each sector (SECTORS,) [m]; inf where no wall fills it."""
        start, end = (self._walls[:, i] - eye for i in (0, 1))
        along = end - start
        # Walls are seen from their left side alone: an eye there is passed counter-clockwise.
        turn = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
        facing = turn > CLIPPED * np.hypot(along[:, 0], along[:, 1])
        start, end, along, turn = start[facing], end[facing], along[facing], turn[facing]
        sight = np.full(SECTORS, np.inf)
        _shorten(start, end, along, turn, self._rays, sight)
        return sight


def opaque_walls(corners: NDArray[np.float64], top: float) -> NDArray[np.float64]:
    """Upright faces that reach without a gap from the floor to `top` [m].

    Args:
        corners: (N, 3, 3) of opaque triangles in the world, counter-clockwise seen from outside.
        top: Upper end [m]; the lower one is 0.

    Returns:
        (W, 2, 2) both ends on the plan; on the way along them the visible side is to the left.
    """
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    upright = (lengths > 1e-9) & (np.abs(normals[:, 2]) < 1e-6 * np.maximum(lengths, 1e-9))
    corners, normals = corners[upright], normals[upright, :2] / lengths[upright, None]
    offsets = (corners[:, 0, :2] * normals).sum(axis=1)
    planes = np.column_stack([np.round(normals, 3), np.round(offsets, 3)])
    _, plane_of = np.unique(planes, axis=0, return_inverse=True)
    order = np.argsort(plane_of.ravel(), kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(plane_of.ravel()[order])) + 1)
    walls = [_complete(corners[group], normals[group[0]], top) for group in groups if len(group)]
    return np.concatenate(walls) if walls else np.zeros((0, 2, 2))


def _complete(
    corners: NDArray[np.float64], normal: NDArray[np.float64], top: float
) -> NDArray[np.float64]:
    """Ends (W, 2, 2) of those runs of a plane that its triangles cover from 0 to `top`."""
    z = corners[..., 2]
    if z.min() > RASTER or z.max() < top - RASTER:
        return np.zeros((0, 2, 2))
    along = np.array([-normal[1], normal[0]])
    s = corners[..., :2] @ along
    origin = s.min()
    pixels = np.stack([(s - origin) / RASTER, z / RASTER], axis=-1) - 0.5
    shape = (max(1, int(top / RASTER)), int((s.max() - origin) / RASTER) + 1)
    image = np.zeros(shape, np.uint8)
    for triangle in np.round(pixels * 16).astype(np.int32):
        cv2.fillConvexPoly(image, triangle, 1, shift=4)
    complete = np.concatenate([[0], image.all(axis=0), [0]]).astype(np.int8)
    first, last = np.flatnonzero(np.diff(complete) > 0), np.flatnonzero(np.diff(complete) < 0)
    # Outlines are drawn up to a cell too far.
    ends = origin + np.column_stack([last - 2, first + 2]) * RASTER
    ends = ends[ends[:, 0] - ends[:, 1] > 0.05]
    on_plan = ends[..., None] * along + (corners[0, 0, :2] @ normal) * normal
    return np.asarray(on_plan)


def _spheres(part: Part, mesh: int) -> NDArray[np.float64]:
    """Bounds (K, 8) of a mesh: centre, radius, radius on the plan, lowest and highest z, `mesh`."""
    if np.ptp(part.vertices[:, :2], axis=0).max(initial=0.0) <= 2 * CELL:
        groups = [part.vertices.astype(np.float64)] if len(part.vertices) else []
    else:
        corners = triangles([part])
        cells = np.floor(corners[..., :2].mean(axis=1) / CELL).astype(np.int64)
        _, cell_of = np.unique(cells, axis=0, return_inverse=True)
        order = np.argsort(cell_of.ravel(), kind="stable")
        starts = np.flatnonzero(np.diff(cell_of.ravel()[order])) + 1
        groups = [group.reshape(-1, 3) for group in np.split(corners[order], starts)]
    bounds = []
    for points in groups:
        low, high = points.min(axis=0), points.max(axis=0)
        centre = (low + high) / 2
        offsets = points - centre
        radius = np.linalg.norm(offsets, axis=1).max()
        plan_radius = np.linalg.norm(offsets[:, :2], axis=1).max()
        bounds.append([*centre, radius, plan_radius, low[2], high[2], mesh])
    return np.array(bounds).reshape(-1, 8)


@kernel("void(f8[::1], i8[::1], i8[::1], f8[::1])")
def _farthest(
    sight: NDArray[np.float64],
    first: NDArray[np.intp],
    last: NDArray[np.intp],
    reach: NDArray[np.float64],
) -> None:
    """Write the longest sight (N,) from the `first` sector to the `last`, which may run over."""
    for run in range(len(first)):
        reach[run] = 0.0
        for sector in range(first[run], last[run] + 1):
            reach[run] = max(reach[run], sight[sector % len(sight)])


@kernel("void(f8[:,:], f8[:,:], f8[:,:], f8[:], f8[:,::1], f8[::1])", error_model="numpy")
def _shorten(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    along: NDArray[np.float64],
    turn: NDArray[np.float64],
    rays: NDArray[np.float64],
    sight: NDArray[np.float64],
) -> None:
    """Shorten the sight of each sector to the nearest wall that fills it.

    Args:
        start: Ends of the walls (W, 2), from the eye [m].
        end: Their other ends, counter-clockwise.
        along: From the one to the other.
        turn: Cross products of both (W,).
        rays: Directions between the sectors (2, SECTORS + 1).
        sight: In each sector (SECTORS,) [m].
    """
    for wall in range(len(start)):
        last = np.inf
        for ray in range(rays.shape[1]):
            x, y = rays[0, ray], rays[1, ray]
            ahead = -(along[wall, 0] * y - along[wall, 1] * x)
            distance = np.inf
            if (
                ahead > 0
                and start[wall, 0] * y - start[wall, 1] * x >= 0
                and end[wall, 0] * y - end[wall, 1] * x <= 0
            ):
                distance = turn[wall] / ahead
            # The distance along a ray has its maximum over a sector on one of its sides.
            if ray > 0:
                sight[ray - 1] = min(sight[ray - 1], max(last, distance))
            last = distance
