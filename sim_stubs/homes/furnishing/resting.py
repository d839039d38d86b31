"""How high the surface is on which a thing is to stand."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.bounding_block import Block


def tops(surface: NDArray[np.float64], block: Block) -> NDArray[np.float64]:
    """Height of the highest surface below 9 points spread over a block; -inf beside it.

    Args:
        surface: (T, 3, 3) triangles [m].
        block: Where something is to stand.
    """
    xs = np.linspace(block.x0, block.x1, 5)[1:-1]
    ys = np.linspace(block.y0, block.y1, 5)[1:-1]
    points = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 1, 2)
    a, b, c = (surface[:, k, :2] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    level = np.abs(twice) > 1e-9
    a, b, c, twice, z = a[level], b[level], c[level], twice[level], surface[level, :, 2]

    def share(p: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
        to_p, to_q = p - points, q - points
        return np.asarray((to_p[..., 0] * to_q[..., 1] - to_p[..., 1] * to_q[..., 0]) / twice)

    shares = np.stack([share(b, c), share(c, a), share(a, b)], axis=-1)
    hit = (shares >= -1e-6).all(axis=-1)
    return np.asarray(
        np.where(hit, (shares * z).sum(axis=-1), -np.inf).max(axis=1, initial=-np.inf)
    )
