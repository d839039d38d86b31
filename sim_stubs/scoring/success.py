"""The scorer: whether the robot reached its goal, by the truth, which the robot never sees."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import atan2, pi

import cv2
import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.house import Instance, Room
from sim_stubs.homes.geometry.occupancy_slice import reachable
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.homes.start_pose import names_meant
from sim_stubs.world.visibility import Visibility
from sim_stubs.world.world import World
from vizbot.core.geometry import back_project, planar, transform
from vizbot.core.home_vocabulary import kinds
from vizbot.core.observer import GoalReport, Outcome, Step
from vizbot.core.types import SE3

REACH = 2.0
"""Largest distance of a stop from the goal [m] (paper, section IV-C)."""
LOOKS = 12
"""Number of views of a full turn, which overlap."""
VISIBLE_PIXELS = 50
"""Least number of pixels of the thing in one of the views."""
ROOM_REACH = 1.0
"""Largest distance from a room that the robot looks into [m]."""
ROOM_SHARE = 0.2
"""Least share of the pixels of the room in one of the views."""
PRECISE = 0.5
"""Largest distance of a right position from the thing on the plan [m]."""
WALL = 0.05
"""The walls of a room are the room's: measured points scatter around them by this much [m]."""
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


@dataclass
class GoalScorer:
    """An observer that scores each goal where the robot stopped, from the world's truth."""

    world: World
    verdicts: list[Verdict] = field(default_factory=list)

    def on_step(self, step: Step) -> None:
        """Nothing is scored under way."""

    def on_goal(self, report: GoalReport) -> None:
        """Score the place where the robot stands now."""
        stopped = report.outcome is Outcome.ARRIVED
        self.verdicts.append(judge(self.world, report.text, stopped=stopped))


@dataclass(frozen=True, slots=True)
class Verdict:
    """The scorer's verdict.

    Attributes:
        success: Whether the robot stopped by itself, within reach, with the goal in sight by
            turning.
        distance: Distance on the plan from the robot's centre to the nearest instance or room [m];
            None when the world has none.
        visible: Whether turning on the spot brings a goal within reach into sight.
        reason: Reason of a failure in a few words; empty on success.
    """

    success: bool
    distance: float | None
    visible: bool
    reason: str


def judge(world: World, text: str, *, stopped: bool) -> Verdict:
    """Score the robot where it stands.

    A room is reached inside of its floor, or within ROOM_REACH of it with a view into it.

    Args:
        world: The world with the robot.
        text: The goal in words: a class ("chair", which any chair fulfils), a label ("yellow
            chair"), a synonym ("couch"), or a room.
        stopped: Whether the robot claims to have arrived.
    """
    return _judged(world, text, world.T_world_base, stopped)


def _judged(world: World, text: str, T_world_base: SE3, stopped: bool) -> Verdict:
    """Score a robot that stands there."""
    rooms, instances = rooms_of(world, text), instances_of(world, text)
    x, y = T_world_base[:2, 3]
    if rooms:
        distances = [distance_to_room(room, x, y) for room in rooms]
        reach, shown = ROOM_REACH, any(room.contains(x, y) for room in rooms)
    else:
        distances = [distance_to(world.instances[i], x, y) for i in instances]
        reach, shown = REACH, False
    if not distances:
        return Verdict(False, None, False, f"no {text.strip()} in this world")
    near = [i for i, distance in enumerate(distances) if distance <= reach]
    if near and not shown:
        shown = (
            _looks_into(world, [rooms[i] for i in near], T_world_base)
            if rooms
            else is_visible(world, [instances[i] for i in near], T_world_base)
        )
    reason = ""
    if not stopped:
        reason = "did not stop by itself"
    elif not near:
        reason = f"{min(distances):.2f} m away"
    elif not shown:
        reason = "not in sight"
    return Verdict(reason == "", min(distances), shown, reason)


def precise(world: World, point: NDArray[np.floating], text: str) -> bool:
    """Whether a point (2,) or (3,) in the world [m] is a right position of `text` on the plan.

    It is right within PRECISE of the true mesh of an instance, or inside the floor of a room.
    """
    x, y = float(point[0]), float(point[1])
    rooms = rooms_of(world, text)
    if rooms:
        return any(distance_to_room(room, x, y) <= WALL for room in rooms)
    wanted = (world.instances[i] for i in instances_of(world, text))
    return any(distance_to(instance, x, y) <= PRECISE for instance in wanted)


def instances_of(world: World, text: str) -> list[int]:
    """Indices in `world.instances` of the instances that `text` names."""
    names = names_meant(text)
    return [i for i, it in enumerate(world.instances) if names.intersection(kinds(it.label))]


def rooms_of(world: World, text: str) -> list[Room]:
    """The rooms that `text` names."""
    names = names_meant(text)
    return [room for room in world.house.rooms if room.name in names]


def distance_to(instance: Instance, x: float, y: float) -> float:
    """Distance on the plan from a point to an instance's true mesh [m]."""
    corners = triangles(instance.parts())[..., :2] - (x, y)
    sides = np.roll(corners, -1, axis=1) - corners
    # Cross products of one sign: the point, now the origin, lies within the triangle.
    turns = corners[..., 0] * sides[..., 1] - corners[..., 1] * sides[..., 0]
    area = np.abs(turns.sum(axis=1))
    if np.any(((turns >= 0).all(axis=1) | (turns <= 0).all(axis=1)) & (area > 1e-12)):
        return 0.0
    lengths = (sides**2).sum(axis=-1)
    share = -(corners * sides).sum(axis=-1) / np.where(lengths > 0, lengths, 1.0)
    nearest = corners + np.clip(share, 0.0, 1.0)[..., None] * sides
    return float(np.sqrt((nearest**2).sum(axis=-1).min()))


def distance_to_room(room: Room, x: float, y: float) -> float:
    """Distance from a point to a room's floor [m]; 0 inside."""
    inside = cv2.pointPolygonTest(room.polygon.astype(np.float32), (x, y), True)
    return max(0.0, -float(inside))


def is_visible(world: World, instances: Sequence[int], T_world_base: SE3) -> bool:
    """Whether a turn on the spot brings one of the `instances` (indices) into sight there."""
    for looking in _looks_around(T_world_base):
        counts = pixels_of(world.segment_from(looking), len(world.instances))
        if (counts[list(instances)] >= VISIBLE_PIXELS).any():
            return True
    return False


def _looks_around(T_world_base: SE3) -> list[SE3]:
    """Poses T_world_base of a full turn on the spot."""
    turns = np.arange(LOOKS) * 2 * pi / LOOKS
    return [T_world_base @ planar(0.0, 0.0, float(turn)) for turn in turns]


def pixels_of(segments: NDArray[np.int32], instances: int) -> NDArray[np.intp]:
    """How many pixels (instances,) of an image of instances (H, W) show each; -1 is none."""
    return np.bincount(segments.ravel() + 1, minlength=instances + 1)[1:]


def in_room(room: Room, xy: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points (N, 2) lie over a room's floor, its walls included."""
    cell = 0.01
    low = room.polygon.min(axis=0) - 2 * WALL
    columns, rows = np.ceil((np.ptp(room.polygon, axis=0) + 4 * WALL) / cell).astype(int)
    floor = np.zeros((rows, columns), np.uint8)
    cv2.fillPoly(floor, [np.round((room.polygon - low) / cell - 0.5).astype(np.int32)], 1)
    size = 2 * round(WALL / cell) + 1
    floor = cv2.dilate(floor, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)))
    at = np.floor((xy - low) / cell).astype(np.intp)
    inside = ((at >= 0) & (at < (columns, rows))).all(axis=1)
    at = np.where(inside[:, None], at, 0)
    return np.asarray(inside & (floor[at[:, 1], at[:, 0]] > 0))


def _looks_into(world: World, rooms: Sequence[Room], T_world_base: SE3) -> bool:
    """Whether a turn on the spot there brings enough of one of the rooms into sight.

    Rooms of one name are one room here: the legs of a hallway, each with its own floor.
    """
    names = {room.name for room in rooms}
    for looking in _looks_around(T_world_base):
        _, depth = world.render_from(looking)
        points = back_project(depth, world.intrinsics)[::4, ::4][depth[::4, ::4] > 0]
        xy = transform(looking @ world.T_base_cam, points)[:, :2]
        for name in names:
            shown = np.any([in_room(room, xy) for room in rooms if room.name == name], axis=0)
            if np.count_nonzero(shown) >= ROOM_SHARE * depth[::4, ::4].size:
                return True
    return False


def goals_of(world: World) -> tuple[str, ...]:
    """The goals of GOALS that can be reached in a world, in their order.

    The judge is asked: at some place that the robot can drive to, a stop is a success.
    """
    places = _places(world)
    return tuple(
        goal
        for goal in GOALS
        if any(
            _judged(world, goal, stop, stopped=True).success for stop in _stops(world, goal, places)
        )
    )


def _stops(world: World, goal: str, places: NDArray[np.float64]) -> Iterator[SE3]:
    """Poses T_world_base at places from which a goal may be near and in sight, likely ones first.

    Places from which a wall surely hides a thing are left out.
    """
    for room in rooms_of(world, goal):
        away = np.array([distance_to_room(room, x, y) for x, y in places])
        for i in np.argsort(away, kind="stable")[: np.count_nonzero(away <= ROOM_REACH)]:
            yield planar(places[i, 0], places[i, 1], 0.0)
    for thing in (world.instances[i] for i in instances_of(world, goal)):
        away = np.linalg.norm(places - thing.centre[:2], axis=1)
        near = np.flatnonzero(away <= REACH + np.hypot(*thing.piece.size[:2]) / 2)
        sight = Visibility(world.house.structure, thing.parts(), world.intrinsics)
        for x, y in places[near[np.argsort(np.abs(away[near] - VIEW), kind="stable")]]:
            stop = planar(x, y, atan2(thing.centre[1] - y, thing.centre[0] - x))
            if any(sight.seen(look @ world.T_base_cam).any() for look in _looks_around(stop)):
                yield stop


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
