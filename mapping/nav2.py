"""Obstacle maps as `nav2_map_server` reads them: `map.yaml` and `map.pgm`, and a keep-out mask.

Source: the documentation of Nav2's map server (mode trinary) and of its keepout filter.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.types import OccupancyGrid

_FREE, _UNKNOWN, _OCCUPIED = 254, 205, 0
"""Grey levels: light is free; by the thresholds below the middle one is neither."""
_FREE_BELOW, _OCCUPIED_ABOVE = 0.196, 0.65


def nav2_files(
    grid: OccupancyGrid, free_threshold: float, occupied_threshold: float
) -> dict[str, bytes]:
    """The files of a map by their names; those of a mask are there where the grid has zones.

    Cells up to `free_threshold` are free, those from `occupied_threshold` on are occupied.
    """
    image = np.full(grid.occupancy.shape, _UNKNOWN, np.uint8)
    image[grid.occupancy <= free_threshold] = _FREE
    image[grid.occupancy >= occupied_threshold] = _OCCUPIED
    files = _image_and_yaml("map", image, grid)
    if grid.zones:
        mask = np.full(image.shape, _FREE, np.uint8)
        for zone in grid.zones:
            corners = (zone - grid.origin) / grid.resolution - 0.5
            cv2.fillPoly(mask, [np.round(corners).astype(np.int32)], _OCCUPIED)
        files |= _image_and_yaml("keepout_mask", mask, grid)
    return files


def _image_and_yaml(name: str, image: NDArray[np.uint8], grid: OccupancyGrid) -> dict[str, bytes]:
    """An image (rows, cols) of the plan, its first row at the top, and what says where it is."""
    rows, columns = image.shape
    x, y = grid.origin.tolist()
    yaml = (
        f"image: {name}.pgm\nmode: trinary\nresolution: {grid.resolution:.6g}\n"
        f"origin: [{x:.6f}, {y:.6f}, 0.0]\nnegate: 0\n"
        f"occupied_thresh: {_OCCUPIED_ABOVE}\nfree_thresh: {_FREE_BELOW}\n"
    )
    # Row 0 of a picture is its upper edge, row 0 of the grid the southern one.
    content = f"P5\n{columns} {rows}\n255\n".encode() + np.ascontiguousarray(image[::-1]).tobytes()
    return {f"{name}.yaml": yaml.encode(), f"{name}.pgm": content}
