"""Two visits to a home that changes between them, and what its map answers after each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.episodes.calibration_error import CalibrationError
from benchmarks.episodes.episode import Episode
from benchmarks.episodes.exploration import explored_map
from benchmarks.episodes.homes import house_of, open_benchmark_home
from benchmarks.episodes.latency import Latencies, slow_devices
from benchmarks.episodes.run import encoder_of
from benchmarks.moved.changes import Change, ChangeKind, draw_changes, movable
from mapping.map_bundle import MapBundle
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.homes.start_pose import standing_room
from sim_stubs.scoring.success import (
    PRECISE,
    VISIBLE_PIXELS,
    distance_to,
    goals_of,
    instances_of,
    pixels_of,
    precise,
)
from sim_stubs.world.world import World
from vizbot.config import Config
from vizbot.core.geometry import invert, transform
from vizbot.core.observer import GoalReport, Outcome, Step
from vizbot.core.types import SE3
from vizbot.mission import explore
from vizbot.objectnav.tasks import goal_of
from vizbot.operator.session.place_answers import Answer, find_places
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.rig import Rig

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

LOOKED = 3.0
"""An old place was looked at again where a frame sees it from within this distance [m]."""
_HALF = 0.5
"""Share of the old place that such a frame sees, with nothing before it."""
_BEFORE = 0.1
"""What is nearer than a point by more than this hides it [m]."""
_FARTHEST = 6.0
"""A new place is looked for in frames from within this distance [m]."""
ThingKind = ChangeKind | Literal["unmoved"]


@dataclass(frozen=True, slots=True)
class MovedAnswer:
    """What the maps of the two visits answer to a question.

    Attributes:
        home: Seed of the home.
        text: The question.
        kind: What happened to the thing meanwhile.
        right_before: Whether the first answer of the first map was right.
        right: Whether that of the second map is: at the thing's new place; of a gone thing that
            there is none.
        claimed_old: Whether some answer of the second map is at the thing's old place.
        looked_again: Whether the second visit had a look at the old place from near.
        seen: Whether a frame of the second visit saw the thing in its new place.
        score: Of the second map's first answer; 0 without one.
    """

    home: int
    text: str
    kind: ThingKind
    right_before: bool
    right: bool
    claimed_old: bool
    looked_again: bool
    seen: bool
    score: float


@dataclass(frozen=True, slots=True)
class HomeVisits:
    """A home that is visited twice.

    Attributes:
        config: Settings of the robot.
        home: Seed of the home.
        folder: Of the map of the first visit, which is made where it is missing.
    """

    config: Config
    home: int
    folder: Path


@dataclass
class ChangeWatcher:
    """An observer that notes, by the truth, which changes came into view."""

    world: World
    changes: Sequence[Change]
    looked_again: set[str] = field(default_factory=set)
    seen: set[str] = field(default_factory=set)

    def on_step(self, step: Step) -> None:
        """Look at what the picture of this step shows."""
        T_world_base = self.world.T_world_pictured
        for change in self.changes:
            if change.text not in self.looked_again and shows_again(
                self.world, T_world_base, change.before
            ):
                self.looked_again.add(change.text)
        near = [
            change
            for change in self.changes
            if change.text not in self.seen
            and change.after is not None
            and np.linalg.norm(change.after.centre[:2] - T_world_base[:2, 3]) < _FARTHEST
        ]
        if not near:
            return
        shown = pixels_of(self.world.segment_from(T_world_base), len(self.world.instances))
        for change in near:
            if (shown[instances_of(self.world, change.text)] >= VISIBLE_PIXELS).any():
                self.seen.add(change.text)

    def on_goal(self, report: GoalReport) -> None:
        """Do nothing: nothing is searched for."""


def shows_again(world: World, T_world_base: SE3, before: Instance) -> bool:
    """Whether a picture from there shows at least half of the place where a thing stood."""
    if np.linalg.norm(before.centre[:2] - T_world_base[:2, 3]) > LOOKED:
        return False
    points = triangles(before.parts()).mean(axis=1)
    T_world_cam, c = T_world_base @ world.T_base_cam, world.intrinsics
    x, y, z = transform(invert(T_world_cam), points).T
    ahead = np.maximum(z, 1e-3)
    u, v = c.fx * x / ahead + c.cx, c.fy * y / ahead + c.cy
    inside = (z > 0.0) & (u >= 0) & (u < c.width) & (v >= 0) & (v < c.height)
    if np.count_nonzero(inside) < _HALF * len(points):
        return False
    _, depth = world.render_from(T_world_base)
    along = depth[v[inside].astype(np.intp), u[inside].astype(np.intp)]
    open_ = (along == 0.0) | (along > z[inside] - _BEFORE)
    return bool(np.count_nonzero(open_) >= _HALF * len(points))


def visit_twice(job: HomeVisits) -> tuple[list[MovedAnswer], list[MovedAnswer]]:
    """The answers after the second visit: by the robot's map, and by one that forgets nothing."""
    config, seed = job.config, job.home
    encoder: ClipEncoder = encoder_of(config)
    error = CalibrationError.drawn(Episode(seed, ()))
    with open_benchmark_home(seed, config, error) as world:
        T_world_map = world.T_world_base  # the map begins where the base stands
        _, first = explored_map(world, seed, config, job.folder)
        texts = list(
            dict.fromkeys([*goals_of(world), *(each.label for each in movable(world.house))])
        )
        before = {text: _ask(first, text, encoder, config, T_world_map) for text in texts}
        right_before = {text: answer.right_in(world) for text, answer in before.items()}
    rng = np.random.default_rng((seed, 7))
    answered = [text for text, right in right_before.items() if right]
    changes, house = draw_changes(house_of(seed), answered, rng)
    start = _start(house, rng)
    with error.world(replace(house, start=start), config, seed + 1_000_000) as world:
        watcher = ChangeWatcher(world, changes)
        second = _second_map(world, config, encoder, first, watcher)
        rows = second, _forgetting_nothing(second)
        by_map, by_all = (
            [
                _answer(
                    seed, text, changes, right_before[text], watcher,
                    _ask(bundle, text, encoder, config, T_world_map),
                )
                for text in texts
                if not _is_changed_class(world, text, changes)
            ]
            for bundle in rows
        )  # fmt: skip
    return by_map, by_all


@dataclass(frozen=True, slots=True, eq=False)
class _Asked:
    """An answer of a map.

    Attributes:
        text: The question.
        located: Whether the map says that it is there.
        claimed: (N, 2) x, y of all places that are likely enough, in the world [m].
        first_xy: (2,) of the first place; None without one.
        score: Of that.
    """

    text: str
    located: bool
    claimed: NDArray[np.float64]
    first_xy: NDArray[np.float64] | None
    score: float

    def right_in(self, world: World) -> bool:
        """Whether the first answer is claimed and right."""
        return (
            self.located and self.first_xy is not None and precise(world, self.first_xy, self.text)
        )


def _ask(
    bundle: MapBundle, text: str, encoder: ClipEncoder, config: Config, T_world_map: SE3
) -> _Asked:
    answer: Answer = find_places(bundle, goal_of(encoder, text), config.objectnav)
    points = np.array([each.position for each in answer.places]).reshape(-1, 3)
    xy = transform(T_world_map, points)[:, :2]
    likely = [each.score > answer.threshold for each in answer.places]
    located = answer.outcome is Outcome.LOCATED
    score = answer.places[0].score if answer.places else 0.0
    return _Asked(text, located, xy[likely], xy[0] if len(xy) else None, score)


def _answer(
    home: int,
    text: str,
    changes: Sequence[Change],
    right_before: bool,
    watcher: ChangeWatcher,
    asked: _Asked,
) -> MovedAnswer:
    """The judged answer to one question."""
    change = next((each for each in changes if each.text == text), None)
    score = round(asked.score, 4)
    if change is None:
        right = asked.right_in(watcher.world)
        return MovedAnswer(home, text, "unmoved", right_before, right, False, False, True, score)
    old = any(distance_to(change.before, x, y) <= PRECISE for x, y in asked.claimed.tolist())
    right = not asked.located if change.kind == "gone" else asked.right_in(watcher.world)
    return MovedAnswer(
        home, text, change.kind, right_before, right, old, text in watcher.looked_again,
        text in watcher.seen, score,
    )  # fmt: skip


def _is_changed_class(world: World, text: str, changes: Sequence[Change]) -> bool:
    """Whether a text names a changed thing and others, so that nobody can say what is right."""
    labels = {each.text for each in changes}
    named = {world.instances[i].label for i in instances_of(world, text)}
    gone = any(each.kind == "gone" and text in each.text.split() for each in changes)
    return text not in labels and (gone or bool(labels & named))


def _second_map(
    world: World,
    config: Config,
    encoder: ClipEncoder,
    first: MapBundle,
    watcher: ChangeWatcher,
) -> MapBundle:
    """The map after a visit that began at an unknown place of the first one."""
    with Rig(config, "sim", "sim", world) as rig:
        devices = slow_devices(rig.devices, Latencies.kept(), config, world.seed)
        pipeline = Pipeline(devices, encoder, config, [watcher], saved_map=first)
        explore(pipeline, devices, config.objectnav.max_exploration_steps)
        pipeline.finish()
        bundle = pipeline.bundle()
    assert bundle is not None  # it began with a map
    return bundle


def _forgetting_nothing(bundle: MapBundle) -> MapBundle:
    """The map as if all of it were of one moment: then nothing is older than anything else."""
    frames = replace(bundle.frames, times=np.zeros_like(bundle.frames.times))
    return replace(bundle, frames=frames)


def _start(house: House, rng: np.random.Generator) -> tuple[float, float, float]:
    """A place on the floor that the entrance leads to, with any heading."""
    xy = standing_room(FreeSpace.from_house(house), house.start)
    x, y = xy[rng.integers(len(xy))].tolist()
    return x, y, float(rng.uniform(-np.pi, np.pi))


def kinds_of(answers: Sequence[MovedAnswer]) -> Iterator[tuple[ThingKind, list[MovedAnswer]]]:
    """The answers of each kind that there is."""
    for kind in ("within its room", "to another room", "gone", "unmoved"):
        if of_kind := [each for each in answers if each.kind == kind]:
            yield kind, of_kind
