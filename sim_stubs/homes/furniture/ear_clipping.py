"""Polygons of models cut into triangles, concave ones too."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray


def triangulated(corners: NDArray[np.float64]) -> list[tuple[int, int, int]]:
    """Triangles of a polygon without holes, as indices of its corners, in its winding.

    Ears are cut off one after another (Meisters, "Polygons have ears", 1975). What is left of a
    polygon that crosses itself becomes a fan.

    Args:
        corners: (N, 3) in order, about in one plane.
    """
    flat = _flattened(corners)
    left = list(range(len(corners)))
    triangles = []
    while len(left) > 3:
        ear = next((i for i in range(len(left)) if _is_ear(flat, left, i)), None)
        if ear is None:
            break
        triangles.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    return triangles + [(left[0], b, c) for b, c in pairwise(left[1:])]


def _flattened(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 2) the polygon in its plane, counter-clockwise."""
    # Newell's normal also holds for a polygon that is not quite flat.
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    away = int(np.argmax(np.abs(normal)))
    kept = [(1, 2), (2, 0), (0, 1)][away]
    flat = corners[:, kept]
    return flat if normal[away] >= 0 else flat * (1.0, -1.0)


def _is_ear(flat: NDArray[np.float64], left: list[int], i: int) -> bool:
    """Whether the corner juts out and its triangle holds no other one."""
    a, b, c = flat[left[i - 1]], flat[left[i]], flat[left[(i + 1) % len(left)]]
    if _twice_area(a, b, c) <= 0.0:
        return False
    others = flat[[k for k in left if k not in (left[i - 1], left[i], left[(i + 1) % len(left)])]]
    inside = (
        (_twice_area(a, b, others) >= 0.0)
        & (_twice_area(b, c, others) >= 0.0)
        & (_twice_area(c, a, others) >= 0.0)
    )
    # A polygon with a slit comes to the same corner twice.
    at_corner = (others[:, None] == np.stack([a, b, c])).all(axis=2).any(axis=1)
    return not bool((inside & ~at_corner).any())


def _twice_area(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Twice the area of the triangle a, b, c (..., 2); positive if it is counter-clockwise."""
    return np.asarray(
        (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1])
        - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
    )
