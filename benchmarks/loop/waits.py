"""How long the robot's loop waits for a growing map, a save and a console: a process of its own.

    python -m benchmarks.loop.waits JSON

After a few ticks the map is blown up to exactly its number of elements, so that the next frame
makes it grow past what it began with. After some more in peace people come: a console asks for
words, rooms and a place again and again, and somebody saves the map.

Waits are of two kinds. What the loop's thread does itself to let the map grow, to take snapshots
and to do people's jobs is timed. What other threads hold of the interpreter is told by a thread
that wants it every 2 ms: how late it gets it at the most, above how late it was in peace. There the
tick that places the whole large map does not count.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from benchmarks.harness.bench_plan import UNATTENDED
from benchmarks.loop.ticks import blown_up
from mapping.clip.encoder import ClipEncoder
from mapping.clip.growing_rows import GrowingRows
from mapping.clip.mapper import ClipMap
from mapping.clip.placement import Placement
from mapping.clip.places.place_rows import PlaceMap
from vizbot.core.errors import VizbotError
from vizbot.core.program.garbage import collecting_afterwards, keep_freed_memory
from vizbot.objectnav.belief_search import BeliefSearch
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.loop_jobs import LoopJobs
from vizbot.operator.session.session import OperatorSession
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.rig import Rig
from vizbot.rig import open_encoder

DIMENSION = 512
"""Length of an embedding of ViT-B/32."""
LARGE_FROM, PEACE = 10, 30
"""Ticks before the map is large, and before people come."""
_GROWING: tuple[tuple[Any, str], ...] = (
    (ClipMap, "add"), (PlaceMap, "add"), (GrowingRows, "add"), (LoopJobs, "do_next"),
)  # fmt: skip
_BEAT = 0.002
"""Period of asking for the interpreter [s]."""


@dataclass(frozen=True, slots=True)
class WaitingDrive:
    """What is driven.

    Attributes:
        world: The home.
        goal: What is searched for.
        count: Number of ticks.
        elements: Number of elements that the map is blown up to.
        saved: Whether somebody saves the map meanwhile.
    """

    world: str
    goal: str
    count: int
    elements: int
    saved: bool


@dataclass(frozen=True, slots=True)
class Waits:
    """How long the loop waited.

    Attributes:
        own: In each tick: what its own thread did for growing, snapshots and people's jobs [s].
        held_in_peace: Longest time that the interpreter was not to be had before people came [s].
        held: Likewise afterwards [s].
        answers: Answers that the console got.
        saves: Maps that were saved.
        elements: Number of elements in the end.
    """

    own: tuple[float, ...]
    held_in_peace: float
    held: float
    answers: int
    saves: int
    elements: int

    @property
    def longest(self) -> float:
        """Longest wait of a tick for what this bench is about [s]."""
        return max(*self.own, self.held - self.held_in_peace)


class _WideEncoder:
    """An encoder whose embeddings are followed by zeros: as wide as ViT-B/32, the same cosines."""

    dimension = DIMENSION

    def __init__(self, inner: ClipEncoder) -> None:
        self._inner, self.reading = inner, inner.reading
        self.model_id, self.threshold = inner.model_id, inner.threshold
        self.log_odds, self.notice = inner.log_odds, inner.notice

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        return widened(self._inner.embed_texts(texts))

    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        return widened(self._inner.embed_images(images))


def widened(embeddings: NDArray[np.float32]) -> NDArray[np.float32]:
    """Embeddings (N, D) followed by zeros, (N, `DIMENSION`)."""
    return np.pad(embeddings, ((0, 0), (0, DIMENSION - embeddings.shape[1])))


@dataclass(slots=True)
class SpanTimer:
    """Sums up the time that one thread spends in some functions, the outermost alone.

    Attributes:
        spent: Since it was last set to 0 [s].
    """

    spent: float = 0.0
    _thread: int = field(default_factory=threading.get_ident)
    _inside: bool = False

    @contextmanager
    def installed(self, functions: Sequence[tuple[Any, str]]) -> Iterator[None]:
        """Time these functions of classes meanwhile; for a process that does nothing else."""
        with ExitStack() as patches:
            for owner, name in functions:
                timed = self._timed(getattr(owner, name))
                patches.enter_context(patch.object(owner, name, timed))
            yield

    def _timed(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*args: Any, **kwargs: Any) -> Any:
            if self._inside or threading.get_ident() != self._thread:
                return function(*args, **kwargs)
            self._inside, began = True, time.perf_counter()
            try:
                return function(*args, **kwargs)
            finally:
                self._inside = False
                self.spent += time.perf_counter() - began

        return timed


class LoopHeartbeat:
    """A thread that wants the interpreter all the time.

    Attributes:
        latest: How late it got it at the most since this was last set to 0 [s].
    """

    def __init__(self) -> None:
        """Begin."""
        self.latest = 0.0
        self._over = threading.Event()
        threading.Thread(target=self._beat, daemon=True).start()

    def stop(self) -> None:
        """End the thread."""
        self._over.set()

    def _beat(self) -> None:
        while not self._over.is_set():
            began = time.perf_counter()
            time.sleep(_BEAT)
            self.latest = max(self.latest, time.perf_counter() - began - _BEAT)


@dataclass(slots=True)
class _People:
    """A console, and perhaps somebody who saves the map, each in a thread of its own."""

    live_map: LiveMap
    saved: bool
    answers: int = 0
    saves: int = 0
    over: threading.Event = field(default_factory=threading.Event)
    _threads: list[threading.Thread] = field(default_factory=list)

    def begin(self) -> None:
        works = [self._ask, self._save] if self.saved else [self._ask]
        self._threads = [threading.Thread(target=work, daemon=True) for work in works]
        for thread in self._threads:
            thread.start()

    def end(self, jobs: LoopJobs) -> None:
        """Wait for what they are doing; what they want of the loop is refused."""
        self.over.set()
        while any(thread.is_alive() for thread in self._threads):
            jobs.cancel()
            for thread in self._threads:
                thread.join(_BEAT)

    def _ask(self) -> None:
        while not self.over.is_set():
            try:
                self.live_map.vocabulary()
                self.live_map.rooms()
                self.live_map.places("refrigerator")
            except VizbotError:  # the run ends
                return
            self.answers += 1
            self.over.wait(1.0)

    def _save(self) -> None:
        while not self.over.is_set():
            try:
                self.live_map.save("bench", replace=True)
            except VizbotError:
                return
            self.saves += 1


def drive_with_people(drive: WaitingDrive, folder: Path) -> Waits:
    """Drive, and time the waits of every tick."""
    session, timer, own = OperatorSession(), SpanTimer(), []
    with ExitStack() as opened:
        with collecting_afterwards():  # as a run does
            encoder = _WideEncoder(open_encoder(UNATTENDED.clip, UNATTENDED.device))
            rig = Rig(UNATTENDED, "sim", "sim", drive.world, first_goal=drive.goal)
            opened.enter_context(rig)
            pipeline = Pipeline(rig.devices, encoder, UNATTENDED, [session])
            people = _People(LiveMap(session, folder), drive.saved)
            goal = pipeline.goal(drive.goal)
        opened.enter_context(timer.installed(_GROWING))
        heartbeat, in_peace = LoopHeartbeat(), 0.0
        for number in range(drive.count):
            if number == LARGE_FROM:
                _blow_up(pipeline, drive.elements)
            if number == LARGE_FROM + 1:
                heartbeat.latest = 0.0
            if number == PEACE:
                in_peace, heartbeat.latest = heartbeat.latest, 0.0
                people.begin()
            timer.spent = 0.0
            while session.jobs.do_next(pipeline):
                pass
            step = pipeline.tick(goal)
            if number >= LARGE_FROM:
                own.append(timer.spent)
            if step is None or step.ended is not None:
                break
        held = heartbeat.latest
        heartbeat.stop()
        people.end(session.jobs)
        pipeline.finish()
        elements = len(pipeline.map.perception.clip_map)
    return Waits(tuple(own), in_peace, held, people.answers, people.saves, elements)


def _blow_up(pipeline: Pipeline, count: int) -> None:
    """Put a large map in the place of the robot's small one."""
    perception = pipeline.map.perception
    large = blown_up(perception.bundle(), count)
    assert large.statistics is not None
    perception.clip_map = ClipMap(DIMENSION, large.elements)
    perception.places = large.place_map()
    perception._statistics = GrowingRows(large.statistics)
    perception._placement = Placement()
    frontiers = pipeline.map.exploration.frontiers
    pipeline.map.search = BeliefSearch(UNATTENDED, frontiers)


def read_waits(text: str) -> Waits:
    """Read what this program prints."""
    return TypeAdapter(Waits).validate_json(text)


def main(arguments: list[str]) -> None:
    """Drive what the argument says in JSON, and print the waits in JSON."""
    keep_freed_memory()
    drive: Any = TypeAdapter(WaitingDrive).validate_json(arguments[0])
    with TemporaryDirectory() as folder:
        waits = drive_with_people(drive, Path(folder))
    print(json.dumps(asdict(waits)))  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1:])
