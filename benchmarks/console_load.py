"""Cost of consoles for the robot's loop.

    python -m benchmarks.console_load [--sequence FOLDER] [--out FILE]

A camera at 30 Hz plays frames of a recorded sequence, or of a simulated home, to and fro, and the
loop processes them as fast as it can. Five watchers in another process on the same machine receive
every picture ten times a second. Stretches with and without watchers take turns.
"""

from __future__ import annotations

import asyncio
import json
import multiprocessing
import statistics
import time
from dataclasses import asdict, dataclass, replace
from itertools import cycle
from multiprocessing.connection import Connection
from pathlib import Path

import typer
from websockets.asyncio.client import connect

from benchmarks.harness.fingerprint import commit, hardware
from drivers.tum_sequence import RecordedSequence
from mapping.clip.embedded.encoder import load_embedded_clip
from sim_stubs.realsense.camera import SimulatedRealSense
from sim_stubs.world.world_name import open_world
from vizbot.config import Config
from vizbot.core.clock import WallClock
from vizbot.core.closeable import Closeable
from vizbot.core.files import write_whole
from vizbot.core.geometry import yaw_of
from vizbot.core.interfaces import Devices
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import Intrinsics, RGBDFrame
from vizbot.objectnav.tasks import Goal
from vizbot.operator.api.image_stream import NAMES
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service
from vizbot.operator.printing import echo
from vizbot.operator.session.session import OperatorSession
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.config import RehearsalConfig

WATCHERS, PICTURES_RATE = 5, 10
_CAMERA_RATE = 30.0
_FRAMES = 90
_TURN = 0.02
"""Turn of the simulated camera from frame to frame [rad]."""
_STRETCH = 10.0
_PAIRS = 6
_GOAL = "yellow chair"


class LoopedCamera(Closeable):
    """A `Camera` that plays frames to and fro in real time; a late reader misses frames."""

    def __init__(self, frames: list[RGBDFrame], clock: WallClock) -> None:
        self._frames = cycle([*frames, *frames[-2:0:-1]])
        self._clock = clock
        self._began = clock.now()
        self._shown = 0
        self.intrinsics: Intrinsics = frames[0].intrinsics

    def read(self, timeout: float = 1.0) -> RGBDFrame:
        """Wait for the next frame and return it."""
        next_at = self._began + (self._shown + 1) / _CAMERA_RATE
        self._clock.sleep(max(0.0, next_at - self._clock.now()))
        due = int((self._clock.now() - self._began) * _CAMERA_RATE)
        for _ in range(due - self._shown):
            frame = next(self._frames)
        self._shown = due
        return replace(frame, stamp=self._began + due / _CAMERA_RATE)

    def close(self) -> None:
        """Do nothing: the camera holds no resource."""


@dataclass(frozen=True, slots=True)
class ConsoleLoad:
    """How much of its rate the loop loses to watchers.

    Attributes:
        alone: Rate of the loop in each stretch without watchers [1/s].
        watched: Rate in the stretch after it, with watchers [1/s].
        pictures: Pictures of all kinds that each watcher received in a second.
    """

    alone: tuple[float, ...]
    watched: tuple[float, ...]
    pictures: float

    def figures(self) -> dict[str, object]:
        """All of it, with the share of the rate that is lost [%]: median, least and most."""
        lost = [100 * (1.0 - w / a) for a, w in zip(self.alone, self.watched, strict=True)]
        return asdict(self) | {
            "lost": statistics.median(lost), "least": min(lost), "most": max(lost),
            "pairs": len(lost), "watchers": WATCHERS, "commit": commit(), "hardware": hardware(),
        }  # fmt: skip

    def summary(self) -> str:
        """The result as a paragraph."""
        lost = [1.0 - w / a for a, w in zip(self.alone, self.watched, strict=True)]
        return (
            f"{WATCHERS} watchers, each sent {self.pictures:.0f} pictures a second: the loop loses"
            f" {100 * statistics.median(lost):.1f} % of its rate (median of {len(lost)}, from"
            f" {100 * min(lost):.1f} to {100 * max(lost):.1f}); alone it makes"
            f" {statistics.median(self.alone):.1f} steps a second."
        )


def measure_watchers(
    frames: list[RGBDFrame], stretch: float = _STRETCH, pairs: int = _PAIRS
) -> ConsoleLoad:
    """Measure the rate of the loop in pairs of stretches [s] with and without watchers."""
    clock, config = WallClock(), Config()
    camera, session = LoopedCamera(frames, clock), OperatorSession()
    devices = Devices(clock, camera, None, config.mount.T_base_cam, False)
    pipeline = Pipeline(devices, load_embedded_clip(), config, [session])
    goal = pipeline.goal(_GOAL)
    alone, watched, pictures = [], [], []
    with Server(session, Service(port=0)) as server:
        _rate(pipeline, goal, stretch)  # warm up
        for _ in range(pairs):
            alone.append(_rate(pipeline, goal, stretch))
            ours, process = _begin_watching(server.url)
            watched.append(_rate(pipeline, goal, stretch))
            ours.send("enough")
            pictures.append(ours.recv() / WATCHERS / stretch)
            process.join()
    return ConsoleLoad(tuple(alone), tuple(watched), statistics.median(pictures))


def _rate(pipeline: Pipeline, goal: Goal, seconds: float) -> float:
    """Rate of the loop [1/s]."""
    began, steps = time.monotonic(), pipeline.steps
    while time.monotonic() - began < seconds:
        pipeline.tick(goal)
    return (pipeline.steps - steps) / (time.monotonic() - began)


def _begin_watching(url: str) -> tuple[Connection, multiprocessing.process.BaseProcess]:
    """Start the watchers and wait until all are connected."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_watch, args=(url, theirs), daemon=True)
    process.start()
    ours.recv()
    return ours, process


def _watch(url: str, parent: Connection) -> None:
    """Run all watchers until the parent ends them, then send it the number of pictures."""
    address = f"{url.replace('http', 'ws', 1)}/live?images={','.join(NAMES)}&rate={PICTURES_RATE}"

    async def watch_one(ready: asyncio.Barrier, over: asyncio.Event) -> int:
        pictures = 0
        async with connect(address) as socket:
            await ready.wait()
            while not over.is_set():
                pictures += isinstance(await socket.recv(), bytes)
        return pictures

    async def watch_all() -> int:
        ready, over = asyncio.Barrier(WATCHERS + 1), asyncio.Event()
        watchers = [asyncio.ensure_future(watch_one(ready, over)) for _ in range(WATCHERS)]
        await ready.wait()
        parent.send("ready")
        await asyncio.to_thread(parent.recv)
        over.set()
        return sum(await asyncio.gather(*watchers))

    parent.send(asyncio.run(watch_all()))


def frames_to_play(sequence: Path | None) -> list[RGBDFrame]:
    """Frames of a TUM-layout folder, or of a camera that turns in a simulated home."""
    if sequence is not None:
        with RecordedSequence(sequence) as recording:
            read = (recording.read() for _ in range(_FRAMES))
            return [frame for frame in read if frame is not None]
    config, rehearsal = Config(), RehearsalConfig()
    frames = []
    with open_world("1000", rehearsal.world, config.mount.T_base_cam, "") as world:
        camera = SimulatedRealSense(world, SimulatedClock(), rehearsal.sim_camera)
        (x, y), yaw = world.T_world_base[:2, 3], yaw_of(world.T_world_base)
        for turned in range(_FRAMES):
            world.place(float(x), float(y), yaw + _TURN * turned)
            frames.append(camera.read())
    return frames


def print_console_load(sequence: Path | None = None, out: Path | None = None) -> None:
    """Print the cost of watchers on this machine; write it to a JSON file where one is given."""
    load = measure_watchers(frames_to_play(sequence))
    echo(load.summary())
    if out is not None:
        write_whole(out, (json.dumps(load.figures(), indent=1) + "\n").encode())


if __name__ == "__main__":
    typer.run(print_console_load)
