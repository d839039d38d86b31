"""A furnished home from a seed, for rehearsals and benchmarks.

Seeds below 1000 are training homes, those from 1000 on held-out homes: their furniture, floors and
walls are on different sides of the split. In homes from 1020 on models of goals and shapes of our
own take turns; 1100 to 1199 are for development.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from sim_stubs.homes.floor_plan.floor_plan import FloorPlan, floor_plan
from sim_stubs.homes.floor_plan.staircase import placed, staircase
from sim_stubs.homes.floor_plan.stairs import Stairs
from sim_stubs.homes.floor_plan.walls import Opening, RectangularRoom, build_structure, wall_of
from sim_stubs.homes.furnishing.placement import RoomLayout
from sim_stubs.homes.furnishing.rooms import furnish
from sim_stubs.homes.furniture.catalogue import Entry, read_catalogue
from sim_stubs.homes.furniture.fitting import Source, fitted, stretched_piece
from sim_stubs.homes.furniture.procedural import FIRST_IN_TURN, GOALS, HomeShapes, in_turn
from sim_stubs.homes.furniture.sampler import ModelSampler, model_sampler
from sim_stubs.homes.furniture.source import furniture_source
from sim_stubs.homes.geometry.bounding_block import FACING, Block
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.homes.goal_chair import FIRST_DISTANCE, with_goal
from sim_stubs.homes.start_pose import distances, standing_room, starts, things_named
from vizbot.core.errors import ConfigError

HELD_OUT = 1000
"""First seed of the held-out homes."""
DRAWS = 100
"""Most draws of a home; most homes need one."""
ESSENTIAL = {"bed", "sofa", "toilet", "sink", "refrigerator"}
"""Classes that every home has; a home in which they found no place is drawn again."""


def home(seed: int) -> House:
    """The home of a seed, the same in every process.

    Raises:
        ConfigError: no draw of the seed gives a home; no such seed is known.
    """
    house, _ = home_and_space(seed)
    return house


def home_and_space(seed: int) -> tuple[House, FreeSpace]:
    """The home of a seed and its true plan.

    Raises:
        ConfigError: no draw of the seed gives a home; no such seed is known.
    """
    # Most first draws are good. A home without free paths or starts is drawn again.
    for draw in range(DRAWS):
        drawn = _drawn(seed, draw)
        if drawn is not None:
            return drawn
    raise ConfigError(f"world {seed}: no home in {DRAWS} draws, which is a bug; report it")


def notice_of(seed: int) -> str:
    """One line about the home of a seed for the user."""
    side = "held-out" if seed >= HELD_OUT else "training"
    notice = f"world {seed}: a home with {side} furniture, floors and walls"
    if not _catalogue():
        notice += " (plain shapes: Debian's sweethome3d-furniture is not installed)"
    return notice


@cache
def _catalogue() -> tuple[Entry, ...]:
    return read_catalogue()


def _drawn(seed: int, draw: int) -> tuple[House, FreeSpace] | None:
    """A home and its plan; None when something in it blocks a path."""
    rng, held_out = np.random.default_rng((seed, draw)), seed >= HELD_OUT
    shapes = HomeShapes(seed, draw) if seed >= FIRST_IN_TURN else None
    source_of = _source_of(seed, shapes)
    plan = floor_plan(rng, held_out)
    if plan is None:
        return None
    pieces, counted = model_sampler(source_of, rng), Counter[str]()
    fixtures = _fixtures(plan, source_of, rng, counted)
    instances = [it for it, _ in fixtures]
    if plan.stairs is not None:
        instances.append(_stairs(plan.stairs, plan.height, pieces, rng, held_out, shapes))
    # A niche for stairs is a room of the plan, but nobody walks in it.
    rooms = [room for room in plan.rooms if not _filled(room, plan.stairs)]
    for room in rooms:
        layout = RoomLayout(room, plan.openings, plan.stairs, rng, counted)
        furnish(room.name, layout, pieces, plan.height, rng)
        instances += layout.instances
    if not ESSENTIAL.issubset(it.label for it in instances):
        return None
    empty = House(
        rooms=tuple(room.room for room in plan.rooms),
        structure=build_structure(plan.rooms, plan.openings, plan.height, plan.stairs),
        instances=tuple(instances),
        lights=np.array([(*_middle(room), plan.height - 0.2) for room in plan.rooms]),
        start=(0.0, 0.0, 0.0),
    )
    doorways = [_middle(hole) for hole in plan.openings if hole.kind != "window"]
    chair = fitted(source_of("chair")("chair", rng), 0.6, 0.6, 1.1)
    entered = [room.room for room in rooms]
    with_chairs = with_goal(empty, FreeSpace.from_house(empty), chair, doorways, entered, rng)
    if with_chairs is None:
        return None
    house, space = with_chairs
    gone = _in_the_way(house, space)
    if gone is None:
        return None
    if not gone:
        return house, space
    house = _without(house, gone, plan, {it.name: hole for it, hole in fixtures})
    return house, FreeSpace.from_house(house)


def _source_of(seed: int, shapes: HomeShapes | None) -> Callable[[str], Source]:
    """Returns the source of the next piece of a class; without `shapes` it is always the same."""
    if shapes is None:
        source = furniture_source(_catalogue(), seed >= HELD_OUT)
        return lambda label: source
    models = furniture_source(_catalogue(), held_out=True, shapes=shapes.piece)
    return in_turn(seed, models, furniture_source((), held_out=True, shapes=shapes.piece))


def _stairs(
    stairs: Stairs,
    height: float,
    pieces: ModelSampler,
    rng: np.random.Generator,
    held_out: bool,
    shapes: HomeShapes | None,
) -> Instance:
    """Stairs of a home: models lead upwards, in held-out homes alone; else they are procedural."""
    model = pieces("stairs") if held_out and stairs.kind == "up" else None
    if model is not None:
        return placed(stairs, fitted(model, stairs.width, stairs.depth))
    if shapes is not None:
        return shapes.staircase(stairs, height)
    return staircase(stairs, height, rng, held_out)


def _filled(room: RectangularRoom, stairs: Stairs | None) -> bool:
    """Whether stairs fill the whole room."""
    if stairs is None:
        return False
    x0, y0, x1, y1 = stairs.bounds
    x0, x1 = np.clip((x0, x1), room.x0, room.x1)
    y0, y1 = np.clip((y0, y1), room.y0, room.y1)
    return bool((x1 - x0) * (y1 - y0) > 0.6 * (room.x1 - room.x0) * (room.y1 - room.y0))


def _middle(area: RectangularRoom | Opening) -> tuple[float, float]:
    return (area.x0 + area.x1) / 2, (area.y0 + area.y1) / 2


def _fixtures(
    plan: FloorPlan,
    source_of: Callable[[str], Source],
    rng: np.random.Generator,
    counted: Counter[str],
) -> list[tuple[Instance, Opening]]:
    """Windows and the outer door in their openings, one model of each in a home."""
    models = {kind: source_of(kind)(kind, rng) for kind in ("window", "door")}
    placed = []
    for opening in plan.openings:
        if opening.kind == "doorway":
            continue
        facings = (wall_of(opening, Block(r.x0, r.y0, r.x1, r.y1)) for r in plan.rooms)
        facing = next(facing for facing in facings if facing is not None)
        across, through = opening.x1 - opening.x0, opening.y1 - opening.y0
        if facing in "EW":
            across, through = through, across
        # The outdoors is shown in the middle of the wall; the frame fills the inner half.
        depth = through / 2 - 0.01
        model = models[opening.kind]
        size = np.array([across, depth, opening.head - opening.sill])
        piece = stretched_piece(model, size / model.size)
        counted[opening.kind] += 1
        x, y = _middle(opening)
        inwards = through / 4
        x += {"E": inwards, "W": -inwards}.get(facing, 0.0)
        y += {"N": inwards, "S": -inwards}.get(facing, 0.0)
        name = f"{opening.kind}#{counted[opening.kind]}"
        placed.append((Instance(name, piece, x, y, FACING[facing], opening.sill), opening))
    return placed


def _in_the_way(house: House, space: FreeSpace) -> list[Instance] | None:
    """The pieces to remove so that every goal has a start; None when there is no such set.

    Where every place is too near to an instance of a goal, the instances around the place that is
    near to the fewest are removed, but never the last one, and neither of the two chairs.
    """
    places = standing_room(space, house.start)
    gone: list[Instance] = []
    for goal in GOALS:
        things, rooms = things_named(house, goal)
        if len(starts(space, places, things, rooms)):
            continue
        if rooms or not len(places):
            return None
        near = np.stack([distances(places, it) <= FIRST_DISTANCE for it in things])
        stays = np.array([it.name.endswith(" chair#1") and " " in it.label for it in things])
        cost = near.sum(axis=0) + len(things) * near[stays].any(axis=0)
        best = int(cost.argmin())
        if cost[best] >= len(things):
            return None
        gone += [it for it, is_near in zip(things, near[:, best], strict=True) if is_near]
    return gone


def _without(
    house: House, gone: Sequence[Instance], plan: FloorPlan, holes: dict[str, Opening]
) -> House:
    """The house without these pieces, those that stand on them, and the openings that they fill."""
    names = {it.name for it in gone}
    closed = [hole for name, hole in holes.items() if name in names]
    curtains = {
        it.name
        for it in house.instances
        if it.label == "curtain"
        and any(
            Block.around(it).grown(0.5).overlaps(Block(hole.x0, hole.y0, hole.x1, hole.y1))
            for hole in closed
        )
    }
    names |= curtains
    left = tuple(it for it in house.instances if it.name not in names and it.on not in names)
    openings = [hole for hole in plan.openings if hole not in closed]
    structure = (
        build_structure(plan.rooms, openings, plan.height, plan.stairs)
        if closed
        else house.structure
    )
    return replace(house, instances=left, structure=structure)
