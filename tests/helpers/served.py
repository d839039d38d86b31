"""A session that is served on this machine, and ways to talk to it."""

import asyncio
import json
import time
from contextlib import contextmanager, suppress
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from tests.helpers.beside import beside
from vizbot.core.geometry import planar
from vizbot.core.observer import Candidate, Effort, GoalReport, Outcome, Step
from vizbot.core.place_scores import Measure, PlaceScores
from vizbot.core.types import (
    STOP,
    ImuSamples,
    Intrinsics,
    OccupancyGrid,
    PoseEstimate,
    RGBDFrame,
    Tracking,
)
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service
from vizbot.operator.session.session import OperatorSession

CAMERA = Intrinsics(32, 24, 30.0, 30.0, 15.5, 11.5)


def step(index, x=0.0, map_number=0):
    """A step of a robot that stands at x [m] in the given map of the run."""
    rgb, depth = np.full((24, 32, 3), 90, np.uint8), np.ones((24, 32), np.float32)
    frame = RGBDFrame(0.1 * index, rgb, depth, CAMERA, ImuSamples.none())
    grid = OccupancyGrid(np.full((20, 20), 0.2, np.float32), 0.1, np.array([-1.0, -1.0]))
    T_map_base = planar(x, 0.0, 0.0)
    estimate = PoseEstimate(frame.stamp, T_map_base, 0, np.eye(4), False, Tracking.TRACKING)
    return Step(
        index=index, frame=frame, frame_number=index, map_number=map_number, estimate=estimate,
        T_map_base=T_map_base, grid=grid,
        goal="sofa", activity="exploring", why="", path=None, target=None, distance_to_go=None,
        scores=PlaceScores(np.array([2, 0]), 0.25, np.full((1, 1), 0.2, np.float32)),
        measure=Measure.PROBABILITY, threshold=0.3, points=np.array([[0.5, 0.0, 0.4]]),
        frames=np.zeros(1, np.int32),
        boxes=np.array([[8, 4, 16, 12]], np.int32), keyframe_poses={0: np.eye(4)}, closures=[],
        frontiers=np.zeros((0, 2)), ended=None, command=None,
    )  # fmt: skip


def resting(index, x=0.0):
    """A step of a robot that is under way at x [m], though its wheels rest."""
    return replace(step(index, x), command=STOP)


def scored(step, points, scores, size=0.1, **changes):
    """The step with elements at these points, whose places have these scores."""
    points, scores = np.array(points, np.float64), np.array(scores, np.float32)
    places = PlaceScores.of_points(points, scores, size)
    return replace(step, points=points, scores=places, **changes)


def arrived(session, text="sofa", picture=b"\xff\xd8 a sofa"):
    """Have the session's robot arrive, with nothing else to do; the number of the task."""
    session.robot.picture_of = lambda report: picture
    [task] = session.ask([text])
    session.queue.current()
    session.on_step(step(0))
    session.on_goal(GoalReport(text, Outcome.ARRIVED, "sure", (), effort=Effort(50.0, 12.34)))
    return task.number


@contextmanager
def jobs_done(session):
    """A robot's loop that only does what people want between two steps.

    What it refutes: a place, or True for that of the last answer.
    """
    refuted = []
    pipeline = SimpleNamespace(
        refute=lambda xy=None: refuted.append(True if xy is None else tuple(xy.tolist())),
        affirm=lambda xy: None,
        candidate=lambda xy: Candidate(np.append(xy, 0.4), 0.34, 0, np.array([0, 0, 9, 9])),
    )

    def loop(over):
        while not over.is_set():
            session.jobs.do_next(pipeline, within=0.05)

    with beside(loop):
        yield refuted


@contextmanager
def served(session=None, **service):
    """A server on a free port of this machine."""
    with Server(session or OperatorSession(), Service(port=0, **service)) as server:
        yield server


def refusal(answer, status=409):
    """Why a request was refused, which was with this status."""
    assert answer.status_code == status
    return answer.json()["detail"]


def websocket_url(server, path):
    return server.url.replace("http", "ws", 1) + path


class Proxy:
    """Between a driver and the robot: it delays, reorders, drops, and may fall silent.

    Attributes:
        delay: Of every message, either way [s].
        swaps: Whether every two motions change places.
        drops: Every so many motions one is lost; 0 for none.
        silent: Whether nothing comes through any more, either way.
    """

    def __init__(self, url, delay=0.0, swaps=False, drops=0):
        self.url, self.delay, self.swaps, self.drops = url, delay, swaps, drops
        self.silent = False
        self.passed = 0
        self._kept = None

    async def __call__(self, client):
        async with connect(self.url) as robot:
            ways = [
                asyncio.ensure_future(self._pass(client, robot, True)),
                asyncio.ensure_future(self._pass(robot, client, False)),
            ]
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            for way in ways:
                way.cancel()

    async def _pass(self, source, sink, motions):
        late = set()
        async for message in source:
            for each in self._disturbed(message) if motions else [message]:
                task = asyncio.ensure_future(self._later(sink, each))
                late.add(task)
                task.add_done_callback(late.discard)

    def _disturbed(self, message):
        self.passed += 1
        if self.drops and self.passed % self.drops == 0:
            return []
        if not self.swaps:
            return [message]
        kept, self._kept = self._kept, None
        if kept is None:
            self._kept = message
            return []
        return [message, kept]

    async def _later(self, sink, message):
        await asyncio.sleep(self.delay)
        if not self.silent:
            with suppress(ConnectionClosed):
                await sink.send(message)


async def drive_for(socket, seconds, linear, first=0):
    """Send motions at 20 Hz as a page does; the last sequence number."""
    heard, sequence = None, first
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            said = json.loads(await asyncio.wait_for(socket.recv(), 0.05))
            heard = said.get("time", heard)
        except TimeoutError:
            pass
        if heard is not None:
            motion = {"sequence": sequence, "heard": heard, "linear": linear, "angular": 0.0}
            await socket.send(json.dumps(motion))
            sequence += 1
    return sequence
