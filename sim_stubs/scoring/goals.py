"""The goals of the paper's benchmark, and which of them exist in a home."""

from __future__ import annotations

from math import atan2, pi

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.occupancy_slice import reachable
from sim_stubs.scoring.success import VISIBLE_PIXELS, instances_of, pixels_of, rooms_of
from sim_stubs.world.visibility import Visibility
from sim_stubs.world.world import World
from vizbot.core.geometry import planar

GOALS = (
    "bed", "chair", "sofa", "toilet", "dining table", "tv", "sink", "refrigerator", "bathtub",
    "laundry", "kitchen", "stairs", "hallway", "living room", "carpet", "window",
)  # fmt: skip
"""The 16 goals of object-goal navigation (paper, section IV-C)."""

IN_COCO = ("bed", "chair", "sofa", "toilet", "dining table", "tv", "sink", "refrigerator")
"""Goals that are classes of COCO, on which the paper's detectors were trained."""

PLACES = 0.25
"""Distance between the places from which a thing is looked for [m]."""
VIEW = 1.5
"""Distance of the first places [m]; from nearer by, high things are out of the picture."""


def goals_of(world: World) -> tuple[str, ...]:
    """The goals of GOALS that exist in a world, in their order: rooms and visible things.

    A thing is no goal if it shows fewer than VISIBLE_PIXELS from every place that the robot can
    drive to.
    """
    places = _places(world)
    return tuple(
        goal
        for goal in GOALS
        if rooms_of(world, goal)
        or any(_can_be_seen(world, i, places) for i in instances_of(world, goal))
    )


def _can_be_seen(world: World, instance: int, places: NDArray[np.float64]) -> bool:
    """Whether the instance of this index is in sight from one of the places.

    Places from which a wall surely hides it are left out.
    """
    thing = world.instances[instance]
    centre, width = thing.centre[:2], float(np.hypot(*thing.piece.size[:2]))
    order = np.argsort(np.abs(np.hypot(*(places - centre).T) - VIEW), kind="stable")
    sight = Visibility(world.house.structure, thing.parts(), world.intrinsics)
    for x, y in places[order]:
        yaw = atan2(centre[1] - y, centre[0] - x)
        # Next to a large thing its ends are out of the picture of its middle.
        large = width > np.hypot(centre[0] - x, centre[1] - y)
        for turn in (0.0, pi / 6, -pi / 6) if large else (0.0,):
            T_world_base = planar(x, y, yaw + turn)
            if not sight.seen(T_world_base @ world.T_base_cam).any():
                continue
            shown = world.segment_from(T_world_base)
            if pixels_of(shown, len(world.instances))[instance] >= VISIBLE_PIXELS:
                return True
    return False


def _places(world: World) -> NDArray[np.float64]:
    """x, y (N, 2) of places all over the floor that the robot can drive to [m]."""
    free, grid = world.free
    start = grid.cell_of(*world.house.start[:2])
    if start is None:
        return np.zeros((0, 2))
    rows, columns = np.nonzero(reachable(free, start))
    # One cell of each block of cells, so that narrow ways count, too.
    block = round(PLACES / grid.resolution)
    _, one = np.unique(rows // block * free.shape[1] + columns // block, return_index=True)
    return grid.pixels_to_xy(np.column_stack([columns[one], rows[one]]).astype(np.float64))
