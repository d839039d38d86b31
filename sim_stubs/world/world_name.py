"""Worlds by their names: a seed, `office` or a file, and where the robot starts in them.

A seed with `+bare` after it is its home with bare walls.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.homes.home import home_and_space, notice_of
from sim_stubs.homes.start_pose import start_for, things_named
from sim_stubs.world.body import Outline
from sim_stubs.world.contact_map import ContactMap
from sim_stubs.world.world_plan import HouseShape, WorldPlan
from sim_stubs.world.world_spec import MJCF, OFFICE, is_bare, require_world, seed_of
from vizbot.core.errors import ConfigError
from vizbot.core.types import SE3

if TYPE_CHECKING:  # loads what a world is planned without
    from sim_stubs.world.body import WorldConfig
    from sim_stubs.world.world import World

_BARED = "its walls are bare: no pictures, white doors, and a mirror that shows the room"
_LEAST_REGION = 0.1
"""Least share of the largest free region that one to start in has; the inside of furniture is
hollow, and free."""


def open_world(
    spec: str,
    config: WorldConfig,
    T_base_cam: SE3 | None = None,
    text: str = "",
    labels: Path | None = None,
    start: tuple[float, float, float] | None = None,
) -> World:
    """The world that `--world` names: a seed, `office`, or a file.

    Goal, labels and start are as `plan_world` takes them. Without `T_base_cam` the camera has its
    usual mount.

    Raises:
        ConfigError: as there, or the robot cannot stand at `start`.
        DeviceError: the machine cannot render.
    """
    from sim_stubs.world.world import MOUNT, World

    mount = MOUNT if T_base_cam is None else T_base_cam
    plan = plan_world(spec, text, labels, start)
    outline = config.outline(float(mount[2, 3]), float(mount[0, 3]))
    return World.of_plan(plan, config, mount, partial(shape_of, plan, outline))


def plan_world(
    spec: str,
    text: str = "",
    labels: Path | None = None,
    start: tuple[float, float, float] | None = None,
) -> WorldPlan:
    """Plan the world that `--world` names.

    Args:
        spec: The name.
        text: The first goal, far from which the robot starts. In an MJCF file, without a goal, and
            for a goal that the world lacks, it starts at the start of the house; the notice says
            so.
        labels: TOML file with labels of what is in an MJCF or SDF file.
        start: x, y [m], yaw [rad] of the robot, wherever the first goal is.

    Raises:
        ConfigError: there is no such world, or a label is for nothing in it.
    """
    seed, notice, space = 0, "", None
    require_world(spec, labels)
    if (number := seed_of(spec)) is not None:
        seed = number
        house, space = home_and_space(seed)
        notice = notice_of(seed)
        if is_bare(spec):
            from sim_stubs.world.bare import bare  # loads numba

            house = bare(house)
            notice = f"{notice}\n{_BARED}{'' if house.mirror else ', without a place for a mirror'}"
    elif spec == OFFICE:
        from sim_stubs.homes.office import office

        house = office(seed)
    else:
        from sim_stubs.world.world_file import read_world

        house = read_world(Path(spec), labels, start)
    if start is not None:
        house = replace(house, start=start)
    elif text and Path(spec).suffix not in MJCF:
        house, remark = _away_from(text, house, space, np.random.default_rng((seed, 3)))
        notice = "\n".join(line for line in (notice, remark) if line)
    return WorldPlan(house, seed, notice, start is not None)


def shape_of(plan: WorldPlan, outline: Outline) -> HouseShape:
    """What the shape of a planned house does to a robot with this outline.

    Raises:
        ConfigError: the robot cannot stand where it is asked to start.
    """
    shape = HouseShape.for_robot(plan.house, outline)
    if plan.start_is_asked:
        _require_standing(plan.house, shape.touch)
    return shape


def _require_standing(house: House, touch: ContactMap) -> None:
    """Refuse a start in something, inside something hollow, or without floor under the robot."""
    free, grid = touch.free()
    x, y, _ = house.start
    regions: NDArray[np.int32] = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)[1]
    sizes = np.bincount(regions[free])
    if not len(sizes):
        raise ConfigError("the robot fits nowhere in this world: it needs a floor and free space")
    wide = free & (sizes[regions] >= _LEAST_REGION * sizes.max())
    cell = grid.cell_of(x, y)
    if cell is not None and wide[cell]:
        return
    rows, columns = np.nonzero(wide)
    places = grid.pixels_to_xy(np.column_stack([columns, rows]))
    near_x, near_y = places[np.hypot(*(places - (x, y)).T).argmin()]
    raise ConfigError(
        f"--start {x:g},{y:g} is in something or without floor under the whole robot; the nearest"
        f" free place is {near_x:.2f},{near_y:.2f}"
    )


def _away_from(
    text: str, house: House, space: FreeSpace | None, rng: np.random.Generator
) -> tuple[House, str]:
    """The house with a start far from what `text` asks for, or as it is and a line on that."""
    start = None
    why = f"nothing in this world is called {text!r}"
    if any(things_named(house, text)):
        start = start_for(house, text, rng, space)
        why = f"no place in this world is far enough from {text!r}"
    if start is None:
        return house, f"{why}: the robot starts anywhere, maybe beside it"
    return replace(house, start=start), ""
