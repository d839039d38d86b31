"""Coloured point clouds as PLY files, which every point cloud viewer opens."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vizbot.core.files import write_whole

_VERTEX = [("xyz", "<f4", 3), ("rgb", "u1", 3)]
_SCORED = [*_VERTEX, ("score", "<f4")]


def write_ply(
    path: Path,
    points: NDArray[np.floating],
    rgb: NDArray[np.uint8],
    scores: NDArray[np.float32] | None = None,
) -> None:
    """Write a binary little-endian PLY; the file appears only when it is whole.

    Args:
        path: Of the file; one that exists is replaced.
        points: (N, 3) [m], stored as float32.
        rgb: (N, 3) uint8.
        scores: (N,) a further number of each point, its property `score`; None for none.

    Raises:
        ConfigError: the file cannot be written.
    """
    vertices = np.empty(len(points), _VERTEX if scores is None else _SCORED)
    vertices["xyz"] = points
    vertices["rgb"] = rgb
    if scores is not None:
        vertices["score"] = scores
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(points)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        + ("" if scores is None else "property float score\n")
        + "end_header\n"
    )
    write_whole(path, header.encode("ascii") + vertices.tobytes())
