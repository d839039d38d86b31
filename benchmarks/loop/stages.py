"""Time that each stage of a tick takes, by the thread that works on it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from drivers.roomba.service import RoombaService
from mapping.clip.placement import Placement
from mapping.clip.scores import Background
from mapping.occupancy.depth_mapper import DepthMapper
from mapping.slam.slam import Slam
from nav import navigator
from nav.costmap import LiveCostmap
from sim_stubs.realsense import camera
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.world.world import World
from vizbot.core.observer import Observers
from vizbot.objectnav.belief_search import BeliefSearch
from vizbot.objectnav.exploration import Exploration
from vizbot.operator.report.report import Report
from vizbot.perception import perception
from vizbot.recorder import Recorder

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
        before = [
            (owner, name, getattr(owner, name)) for _, owner, names in STAGES for name in names
        ]
        try:
            for stage, owner, names in STAGES:
                for name in names:
                    setattr(owner, name, self._timed(stage, getattr(owner, name)))
            yield
        finally:
            for owner, name, function in before:
                setattr(owner, name, function)

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
