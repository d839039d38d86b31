"""Ticks of one rehearsal in a process of its own: `python -m benchmarks.loop.ticks`.

Numerical libraries read how many threads they may have when they load, so whoever starts it sets
the environment that the command line sets for itself.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from benchmarks.harness.bench_plan import UNATTENDED
from drivers.roomba.service import RoombaService
from mapping import map_bundle
from mapping.clip.placement import Placement
from mapping.clip.places.place_rows import PlaceRows
from mapping.clip.scores import Background
from mapping.map_bundle import MapBundle
from mapping.occupancy.depth_mapper import DepthMapper
from mapping.slam.slam import Slam
from nav import navigator
from nav.costmap import LiveCostmap
from sim_stubs.realsense import camera
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.world.world import World
from vizbot.core.observer import Observer, Observers
from vizbot.core.program.garbage import keep_freed_memory
from vizbot.objectnav.belief_search import BeliefSearch
from vizbot.objectnav.exploration import Exploration
from vizbot.operator.report.report import Report
from vizbot.perception import perception
from vizbot.pipeline import Pipeline
from vizbot.recorder import Recorder
from vizbot.rehearsal.rig import Rig
from vizbot.rig import open_encoder

STAGES: tuple[tuple[str, Any, tuple[str, ...]], ...] = (
    ("camera and clock", camera.SimulatedRealSense, ("read",)),
    ("serial line in lockstep", RoombaService, ("step",)),
    ("serial line in lockstep", SimulatedRoomba, ("publish", "advance")),
    ("rendering", World, ("render_from",)),
    ("noise", camera, ("noisy_colour", "noisy_depth")),
    ("tracking", Slam, ("track",)),
    ("obstacle map", DepthMapper, ("integrate", "follow", "grid")),
    ("embedding", perception, ("embed_frame", "footprint")),
    ("embedding", Background, ("statistics",)),
    ("placing elements", Placement, ("place",)),
    ("belief", perception.Perception, ("believe",)),
    ("search", Exploration, ("look", "decide")),
    ("search", BeliefSearch, ("go",)),
    ("costmap", LiveCostmap, ("update",)),
    ("planning", navigator, ("plan", "exits")),
    ("recorder", Recorder, ("on_step",)),
    ("report", Report, ("on_step",)),
    ("video", Report, ("_draw",)),
    ("other observers", Observers, ("on_step",)),
)
"""Name of each stage, and the functions whose own time it is: what they call of other stages is
theirs."""
REST = "rest"
"""What a tick does beside all stages."""


@dataclass(slots=True)
class StageTime:
    """Time of one stage.

    Attributes:
        processor: Of the thread on a processor [s].
        wall: By the clock on the wall [s].
    """

    processor: float = 0.0
    wall: float = 0.0


class _Open(threading.local):
    """The stages that this thread is in, the innermost last."""

    def __init__(self) -> None:
        self.inner: list[StageTime] = []


@dataclass(slots=True)
class StageTimer:
    """Collects the own time of every stage while it is `measuring`."""

    times: dict[str, StageTime] = field(
        default_factory=lambda: {name: StageTime() for name, _, _ in STAGES}
    )
    measuring: bool = False
    _open: _Open = field(default_factory=_Open)

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Time the stages meanwhile; for a process that does nothing else."""
        with ExitStack() as patches:
            for stage, owner, names in STAGES:
                for name in names:
                    timed = self._timed(stage, getattr(owner, name))
                    patches.enter_context(patch.object(owner, name, timed))
            yield

    def _timed(self, stage: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*args: Any, **kwargs: Any) -> Any:
            if not self.measuring:
                return function(*args, **kwargs)
            inside = StageTime()
            self._open.inner.append(inside)
            began, began_wall = time.thread_time(), time.perf_counter()
            try:
                return function(*args, **kwargs)
            finally:
                processor, wall = time.thread_time() - began, time.perf_counter() - began_wall
                open_stages, total = self._open.inner, self.times[stage]
                open_stages.pop()
                total.processor += processor - inside.processor
                total.wall += wall - inside.wall
                if open_stages:
                    open_stages[-1].processor += processor
                    open_stages[-1].wall += wall

        return timed


@dataclass(frozen=True, slots=True)
class TimedDrive:
    """What is driven.

    Attributes:
        world: The home.
        goal: What is searched for.
        count: Number of ticks.
        map_folder: The map to begin in; None for an empty one.
        elements: Number of elements that this map is blown up to.
    """

    world: str
    goal: str
    count: int
    map_folder: str | None = None
    elements: int = 0


@dataclass(frozen=True, slots=True)
class Ticks:
    """Ticks that were driven.

    Attributes:
        wall: Duration of every tick [s].
        processor: Processor time of the process in every tick, of all its threads [s].
        moved: Whether the base was commanded to move in each tick or had been before.
        elements: Number of elements of the CLIP map in the end.
        stages: Time of every stage in all ticks.
    """

    wall: tuple[float, ...]
    processor: tuple[float, ...]
    moved: tuple[bool, ...]
    elements: int
    stages: dict[str, StageTime]


def drive_ticks(drive: TimedDrive, folder: Path) -> Ticks:
    """Drive, with all observers of a rehearsal, and time every tick."""
    config, timer = UNATTENDED, StageTimer()
    wall: list[float] = []
    processor: list[float] = []
    moved: list[bool] = []
    encoder = open_encoder(config.clip, config.device)
    with Rig(config, "sim", "sim", drive.world, first_goal=drive.goal) as rig, timer.installed():
        recorder = Recorder(folder, config)
        observers: list[Observer] = [recorder, Report(folder, encoder.notice)]
        saved = None if drive.map_folder is None else map_bundle.load(Path(drive.map_folder))
        if saved is not None and drive.elements:
            saved = blown_up(saved, drive.elements)
        pipeline = Pipeline(rig.devices, encoder, config, observers, saved_map=saved)
        goal, timer.measuring = pipeline.goal(drive.goal), True
        for _ in range(drive.count):
            began, began_processor = time.perf_counter(), time.process_time()
            step = pipeline.tick(goal)
            wall.append(time.perf_counter() - began)
            processor.append(time.process_time() - began_processor)
            if step is None:
                break
            command = step.command
            moving = command is not None and (command.linear != 0.0 or command.angular != 0.0)
            moved.append(moving or (bool(moved) and moved[-1]))
            if step.ended is not None:
                break
        timer.measuring = False
        pipeline.finish()
        elements = len(pipeline.map.perception.clip_map)
    rest = rest_of(timer.times, sum(wall), sum(processor))
    stages = timer.times | {REST: rest}
    return Ticks(tuple(wall), tuple(processor), tuple(moved), elements, stages)


def rest_of(stages: Mapping[str, StageTime], wall: float, processor: float) -> StageTime:
    """What ticks took beside their stages; the video is encoded by a thread while they go on.

    Args:
        stages: Time of every stage.
        wall: Duration of all ticks [s].
        processor: Processor time of the process in all ticks, of all its threads [s].
    """
    of_stages = sum(each.processor for each in stages.values())
    waited_for = sum(each.wall for name, each in stages.items() if name != "video")
    return StageTime(max(0.0, processor - of_stages), max(0.0, wall - waited_for))


def blown_up(bundle: MapBundle, count: int) -> MapBundle:
    """The map with `count` elements, and as many more views of places: copies, each a little off.

    A copy has the frame and keyframe of its original. A map of more elements is cut to the first.
    """
    elements, rng = bundle.elements, np.random.default_rng(0)
    source = np.sort(np.arange(count) % len(elements.keyframes))
    embeddings = elements.embeddings[source]
    embeddings += 0.02 * rng.standard_normal(embeddings.shape, np.float32)
    embeddings /= np.linalg.norm(embeddings, axis=1, keepdims=True)
    points = elements.points_keyframe[source] + 0.05 * rng.standard_normal((count, 3))
    return replace(
        bundle,
        places=_more_places(bundle.places, source, rng),
        statistics=None if bundle.statistics is None else bundle.statistics[source],
        elements=replace(
            elements,
            embeddings=embeddings,
            points_keyframe=points,
            keyframes=elements.keyframes[source],
            frames=elements.frames[source],
            boxes=elements.boxes[source],
        ),
    )


def _more_places(rows: PlaceRows, source: NDArray[np.int64], rng: np.random.Generator) -> PlaceRows:
    """Views of places for each copy of the elements that they are of.

    Args:
        rows: Of the elements before they were copied.
        source: (N,) in ascending order, the element that each is a copy of.
        rng: Draws how far a copy is off.
    """
    first, counts = np.unique(source, return_index=True, return_counts=True)[1:]
    copies = int(counts.max(initial=1))
    left = np.flatnonzero((rows.elements < len(first)).all(axis=1))
    many = np.repeat(left, copies)
    number = np.tile(np.arange(copies), len(left))[:, None]
    of = rows.elements[many]
    points = rows.points_keyframe[many] + 0.05 * rng.standard_normal((len(many), 3), np.float32)
    return PlaceRows(
        points.astype(np.float32),
        rows.keyframes[many],
        (first[of] + np.minimum(number, counts[of] - 1)).astype(np.int32),
        rows.ranges[many],
        rows.shares[many],
        rows.spots[many],
        rows.frames[many],
    )


def read_ticks(text: str) -> Ticks:
    """Read what this program prints."""
    return TypeAdapter(Ticks).validate_json(text)


def main(arguments: list[str]) -> None:
    """Drive what the first argument says in JSON, and print its ticks in JSON."""
    keep_freed_memory()
    drive: Any = TypeAdapter(TimedDrive).validate_json(arguments[0])
    keep = Path(arguments[1]) if len(arguments) > 1 else None
    with TemporaryDirectory() as folder:
        ticks = drive_ticks(drive, keep or Path(folder) / "run")
    print(json.dumps(asdict(ticks)))  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1:])
