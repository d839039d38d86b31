"""A picture of trajectories, seen along the direction in which they extend least."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.trajectory_error import align, associate

_COLOURS = (
    (40, 40, 46), (215, 40, 35), (30, 80, 220), (20, 150, 60), (200, 130, 0), (140, 60, 170),
)  # fmt: skip
_SIZE, _MARGIN, _LINE = 900, 50, 26


@dataclass(frozen=True, slots=True, eq=False)
class Path2D:
    """A trajectory with a name, stamps (N,) [s] and poses (N, 4, 4)."""

    name: str
    stamps: NDArray[np.float64]
    Ts_map_cam: NDArray[np.float64]


def draw_paths(paths: Sequence[Path2D]) -> bytes:
    """Draw paths as a PNG, each aligned to the first one.

    The first path alone sets the scale, and the others may leave the picture.
    """
    first = paths[0]
    centre = first.Ts_map_cam[:, :3, 3].mean(axis=0)
    _, _, axes = np.linalg.svd(first.Ts_map_cam[:, :3, 3] - centre, full_matrices=False)
    flat = (first.Ts_map_cam[:, :3, 3] - centre) @ axes[:2].T
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = (_SIZE - 2 * _MARGIN) / max(float((high - low).max()), 0.1)
    picture = np.full((_SIZE, _SIZE, 3), 255, np.uint8)
    for path, colour in zip(reversed(paths), reversed(_COLOURS[: len(paths)]), strict=True):
        xy = (_aligned(path, first) - centre) @ axes[:2].T
        pixels = ((xy - (low + high) / 2) * scale + _SIZE / 2).round().astype(np.int32)
        cv2.polylines(picture, [pixels[:, None]], False, colour[::-1], 2, cv2.LINE_AA)
    for row, (path, colour) in enumerate(zip(paths, _COLOURS, strict=False)):
        corner = (12, _LINE * (row + 1))
        font = cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(picture, path.name, corner, font, 0.6, colour[::-1], 2, cv2.LINE_AA)
    metre = round(scale)
    end = (_SIZE - _MARGIN, _SIZE - 20)
    cv2.line(picture, (end[0] - metre, end[1]), end, _COLOURS[0], 2)
    cv2.putText(picture, "1 m", (end[0] - metre, end[1] - 8), font, 0.5, _COLOURS[0], 1)
    return bytes(cv2.imencode(".png", picture)[1])


def _aligned(path: Path2D, first: Path2D) -> NDArray[np.float64]:
    """Positions (N, 3), aligned to the first path."""
    positions = path.Ts_map_cam[:, :3, 3]
    here, there = associate(path.stamps, first.stamps)
    if path is first or len(here) < 3:
        return positions
    T = align(positions[here], first.Ts_map_cam[there, :3, 3])
    return np.asarray(positions @ T[:3, :3].T + T[:3, 3])
