"""True length of the shortest path to a goal, for the score of path lengths."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from sim_stubs.homes.geometry.occupancy_slice import PlanGrid, occupied
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.scoring.success import REACH, instances_of, rooms_of
from sim_stubs.world.world import World

SNAP = 0.35
"""Largest distance of the free cell from which a robot in contact starts [m]."""
EYE_LEVEL = (0.5, 0.7)
"""Walls that reach into this height hide what is behind them [m]."""
EVERY_HEIGHT = (-100.0, 100.0)
_STEPS = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2))
"""Rows, columns from a cell to half of its sixteen neighbours: paths are at most 3 % too long."""


def nearest_path_length(world: World, text: str) -> float | None:
    """Length of the shortest path from the robot to where `text` is reached [m].

    A goal is reached within REACH of an instance without a wall between (furniture may be), or on
    the floor of a room. None where there is no path, or no such thing.
    """
    free, grid = world.free
    lengths = path_lengths(free, grid, world.T_world_base[:2, 3])
    reached = np.zeros(free.shape, np.bool_)
    for room in rooms_of(world, text):
        floor = np.zeros(free.shape, np.uint8)
        corners = np.round(grid.to_pixels(room.polygon) * 16).astype(np.int32)
        cv2.fillPoly(floor, [corners], 1, shift=4)
        reached |= floor.astype(np.bool_)
    if not reached.any():
        walls = occupied(triangles(world.house.structure), *EYE_LEVEL, grid)
        for index in instances_of(world, text):
            mesh = triangles(world.instances[index].parts())
            thing = occupied(mesh, *EVERY_HEIGHT, grid)
            reached |= _in_reach(thing, walls & ~thing, grid)
    shortest = float(lengths[reached].min(initial=np.inf))
    return shortest if np.isfinite(shortest) else None


def path_lengths(
    free: NDArray[np.bool_], grid: PlanGrid, start: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Lengths (rows, cols) of shortest free paths from a point (2,) [m]; inf without a path."""
    number = np.full(free.shape, -1, np.intp)
    number[free] = np.arange(np.count_nonzero(free))
    edges, lengths = [], []
    for down, right in _STEPS:
        here, there = _shifted(number, down, right)
        linked = (here >= 0) & (there >= 0)
        edges.append(np.stack([here[linked], there[linked]]))
        lengths.append(np.full(edges[-1].shape[1], np.hypot(down, right) * grid.resolution))
    cells = np.argwhere(free)
    everywhere = np.full(free.shape, np.inf)
    if not len(cells):
        return everywhere
    distance = np.linalg.norm(grid.pixels_to_xy(cells[:, ::-1].astype(np.float64)) - start, axis=1)
    nearest = int(distance.argmin())
    if distance[nearest] > SNAP:
        return everywhere
    graph = coo_array(
        (np.concatenate(lengths), tuple(np.concatenate(edges, axis=1))),
        shape=(len(cells), len(cells)),
    )
    everywhere[free] = dijkstra(graph.tocsr(), directed=False, indices=nearest)
    return everywhere


def _shifted(
    number: NDArray[np.intp], down: int, right: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The numbers of cells and, at the same place, those of their neighbours."""
    rows, columns = number.shape
    west, east = max(0, -right), max(0, right)
    here = number[: rows - down, west : columns - east]
    return here, number[down:, east : columns - west]


def _in_reach(
    thing: NDArray[np.bool_], walls: NDArray[np.bool_], grid: PlanGrid
) -> NDArray[np.bool_]:
    """Cells within REACH of a thing, from which no wall hides the nearest of its cells."""
    distance, labels = cv2.distanceTransformWithLabels(
        (~thing).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    near = np.argwhere(distance * grid.resolution <= REACH)
    at = np.zeros((int(labels.max()) + 1, 2))
    at[labels[thing]] = np.argwhere(thing)
    ends = at[labels[near[:, 0], near[:, 1]]]
    share = np.linspace(0.0, 1.0, int(2 * REACH / grid.resolution))[:, None, None]
    between = np.round(near + (ends - near) * share).astype(np.intp)
    clear = ~walls[between[..., 0], between[..., 1]].any(axis=0)
    reached = np.zeros(thing.shape, np.bool_)
    reached[near[clear, 0], near[clear, 1]] = True
    return reached
