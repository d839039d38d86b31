"""A flat mirror: the eye behind it that sees what it shows, and where a picture shows it.

What a plane mirror shows is what an eye sees that lies as far behind its plane as the true one lies
before it, through the mirror as through a window. A stereo camera measures the depth of what is
shown, not that of the glass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vizbot.core.types import SE3, Intrinsics


@dataclass(frozen=True, slots=True, eq=False)
class Mirror:
    """An upright rectangle that mirrors on the side that `along` x `up` points to.

    Attributes:
        corner: (3,) lower left corner, as the one who looks into it sees it [m].
        along: (3,) vector to the lower right corner [m].
        up: (3,) vector to the upper left corner [m].
    """

    corner: NDArray[np.float64]
    along: NDArray[np.float64]
    up: NDArray[np.float64]

    @property
    def normal(self) -> NDArray[np.float64]:
        """(3,) unit vector towards whoever looks into it."""
        normal = np.cross(self.along, self.up)
        return np.asarray(normal / np.linalg.norm(normal))

    def before(self, point: NDArray[np.float64]) -> float:
        """How far a point (3,) lies before the plane of the mirror [m]; negative behind it."""
        return float((point - self.corner) @ self.normal)

    def reflected(self, T_world_cam: SE3) -> SE3:
        """Pose of the camera that sees left and right exchanged what the mirror shows to `cam`."""
        normal, T = self.normal, T_world_cam.copy()
        reflection = np.eye(3) - 2 * np.outer(normal, normal)
        T[:3, :3] = reflection @ T[:3, :3] @ np.diag([-1.0, 1.0, 1.0])
        T[:3, 3] -= 2 * self.before(T[:3, 3]) * normal
        return T

    def seen(
        self, T_world_cam: SE3, intrinsics: Intrinsics, depth: NDArray[np.float32]
    ) -> MirrorPixels | None:
        """Where a picture with this depth (H, W) [m] shows the mirror; None where it does not.

        Args:
            T_world_cam: Pose of the camera.
            intrinsics: Its intrinsics.
            depth: Depth of what stands in the house, 0 where nothing is.
        """
        eye, rotation = T_world_cam[:3, 3], T_world_cam[:3, :3]
        corners = self.corner + np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) @ [self.along, self.up]
        x, y, z = ((corners - eye) @ rotation).T
        if self.before(eye) <= 0 or not (z > 0).any():
            return None
        low, high = np.zeros(2, int), np.array([intrinsics.width, intrinsics.height])
        if (z > 0).all():
            at = np.array([x * intrinsics.fx, y * intrinsics.fy]) / z
            at += np.array([[intrinsics.cx], [intrinsics.cy]])
            low = np.maximum(low, np.floor(at.min(axis=1)).astype(int))
            high = np.minimum(high, np.ceil(at.max(axis=1)).astype(int) + 1)
        if (low >= high).any():
            return None
        columns, rows = np.arange(low[0], high[0]), np.arange(low[1], high[1])
        rays = np.stack(np.broadcast_arrays(
            (columns - intrinsics.cx) / intrinsics.fx,
            ((rows - intrinsics.cy) / intrinsics.fy)[:, None],
            1.0,
        ), axis=-1) @ rotation.T  # fmt: skip
        towards = rays @ -self.normal
        glass = np.where(towards > 0, self.before(eye) / np.maximum(towards, 1e-9), np.inf)
        s, t = (
            (((eye - self.corner) @ axis) + glass * (rays @ axis)) / (axis @ axis)
            for axis in (self.along, self.up)
        )
        there = depth[low[1] : high[1], low[0] : high[0]]
        shown = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1) & ((there <= 0) | (there > glass))
        if not shown.any():
            return None
        rows, columns = np.flatnonzero(shown.any(axis=1)), np.flatnonzero(shown.any(axis=0))
        inner = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
        window = (
            slice(int(low[1] + rows[0]), int(low[1] + rows[-1] + 1)),
            slice(int(low[0] + columns[0]), int(low[0] + columns[-1] + 1)),
        )
        return MirrorPixels(window, shown[inner], s[inner], t[inner], glass[inner])


@dataclass(frozen=True, slots=True, eq=False)
class MirrorPixels:
    """The pixels of a picture that show a mirror.

    Attributes:
        window: Rows and columns of the picture that hold them all, (R, C) pixels.
        shown: (R, C) whether a pixel shows the mirror.
        s: (R, C) where it meets the mirror's plane, 0 at its left edge, 1 at its right one.
        t: (R, C) likewise, 0 at its lower edge, 1 at its upper one.
        glass: (R, C) depth of the plane there [m].
    """

    window: tuple[slice, slice]
    shown: NDArray[np.bool_]
    s: NDArray[np.float64]
    t: NDArray[np.float64]
    glass: NDArray[np.float64]
