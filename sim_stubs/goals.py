"""The goals of the paper's benchmark, and which of them exist in a home."""

from __future__ import annotations

from math import atan2, pi

import numpy as np

from sim_stubs.judge import VISIBLE_PIXELS, instances_of, pixels_of, rooms_of
from sim_stubs.occupancy_slice import reachable
from sim_stubs.world import World
from vizbot.core.geometry import planar

GOALS = (
    "bed", "chair", "sofa", "toilet", "dining table", "tv", "sink", "refrigerator", "bathtub",
    "laundry", "kitchen", "stairs", "hallway", "living room", "carpet", "window",
)  # fmt: skip
"""The 16 goals of object-goal navigation (paper, section IV-C)."""

IN_COCO = ("bed", "chair", "sofa", "toilet", "dining table", "tv", "sink", "refrigerator")
"""Those among them that are classes of COCO, which the paper's detectors were trained on."""

VIEW = 4.0
"""A thing is looked for from no farther away than this [m]."""
VIEWS = 48
"""From so many places, until it is seen from one."""


def goals_of(world: World) -> tuple[str, ...]:
    """Those of GOALS that exist in a world, in their order: rooms, and things one can see.

    A thing that shows VISIBLE_PIXELS from none of the places that the robot can drive to is no
    goal.
    """
    return tuple(
        goal
        for goal in GOALS
        if rooms_of(world, goal) or any(can_be_seen(world, i) for i in instances_of(world, goal))
    )


def can_be_seen(world: World, instance: int) -> bool:
    """Whether the instance of this index is in sight from somewhere the robot can drive to."""
    free, grid = world.free
    start = grid.cell_of(*world.house.start[:2])
    if start is None:
        return False
    rows, columns = np.nonzero(reachable(free, start))
    places = grid.to_xy(np.column_stack([columns, rows]))
    centre = world.instances[instance].centre[:2]
    distances = np.hypot(*(places - centre).T)
    places = places[distances < VIEW + world.instances[instance].piece.size[:2].max() / 2]
    order = np.random.default_rng(instance).permutation(len(places))[:VIEWS]
    for x, y in places[order]:
        yaw = atan2(centre[1] - y, centre[0] - x)
        # Next to a large thing its middle may hide behind another; its ends may not.
        for turn in (0.0, pi / 6, -pi / 6):
            shown = world.segment_from(planar(x, y, yaw + turn))
            if pixels_of(shown, len(world.instances))[instance] >= VISIBLE_PIXELS:
                return True
    return False
