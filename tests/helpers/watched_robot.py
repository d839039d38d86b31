"""A robot that people watch, without a world: it steps, and does what the wheel says."""

import threading
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from mapping.clip.scores import Query
from tests.helpers.bundles import Snapshot, bundle_of
from tests.helpers.roomba_rig import DEADLINE
from tests.helpers.served import step as standing
from vizbot.config import Config
from vizbot.core.geometry import planar
from vizbot.core.observer import Candidate, Effort, GoalReport, Outcome
from vizbot.core.types import (
    STOP,
    BaseMode,
    BaseState,
    ImuSamples,
    Intrinsics,
    OccupancyGrid,
    RGBDFrame,
    Tracking,
)
from vizbot.objectnav import reasons
from vizbot.objectnav.option import Option
from vizbot.objectnav.tasks import Goal
from vizbot.operator.session.session import OperatorSession

_PERIOD = 0.02


class HeldMap:
    """What of a `Pipeline` people use between two steps.

    Attributes:
        keep_out: Zones that are forbidden.
        begun: The maps that were begun, in order; None for an empty one.
        refuted: How often a place was refuted.
        affirmed: Places that somebody has said to go to.
    """

    def __init__(self):
        self.keep_out = ()
        self.begun = []
        self.refuted = 0
        self.affirmed = []
        self.map = SimpleNamespace(number=0)
        self.config = Config()

    def snapshot(self):
        return Snapshot(replace(bundle_of(), keep_out=self.keep_out))

    def goal(self, text):
        return Goal(text, np.full(4, 0.5, np.float32), 0.3)

    def question(self, goal):
        return Query(goal.embedding, (1.0, -30.0))  # nothing is like it

    def require_usable(self, kept):
        """Any map is."""

    def refute(self, place_xy=None):
        self.refuted += 1

    def affirm(self, place_xy):
        self.affirmed.append(tuple(place_xy))

    def candidate(self, place_xy):
        return Candidate(np.append(place_xy, 0.4), 0.34, 0, np.array([16, 12, 48, 36], np.int32))

    def begin_map(self, kept):
        self.begun.append(kept)
        self.keep_out = () if kept is None else kept.keep_out


LONG_WHY = reasons.exploring(reasons.MOST_ALIKE, [Option("place", np.zeros(2), 0.07, 1.0)])
"""One of the longest reasons there are."""


def first_step():
    camera = Intrinsics(64, 48, 60.0, 60.0, 31.5, 23.5)
    rgb = np.full((48, 64, 3), (200, 60, 30), np.uint8)
    occupancy = np.full((80, 100), 0.5, np.float32)
    occupancy[20:60, 20:80] = 0.1
    plain = standing(0)
    return replace(
        plain,
        frame=RGBDFrame(0.0, rgb, np.full((48, 64), 1.5, np.float32), camera, ImuSamples.none()),
        estimate=replace(plain.estimate, is_keyframe=True),
        T_map_base=planar(2.0, 2.0, 0.5),
        grid=OccupancyGrid(occupancy, 0.05, np.zeros(2)),
        goal="",
        activity="mapping",
        scores=None,
        points=np.zeros((0, 3)),
        frames=np.zeros(0, np.int32),
        boxes=np.zeros((0, 4), np.int32),
    )


class WatchedRobot:
    """Steps in a thread of its own until it is closed.

    Attributes:
        session: Where people ask.
        twist: What the wheels do now.
        driven: Every twist that was new, in order.
        pipeline: Its map.
        tracking: How far it knows where it is.
        question: What it asks people.
    """

    def __init__(self):
        self.tracking, self.question = Tracking.TRACKING, None
        self.session = OperatorSession()
        self.twist = STOP
        self.driven = []
        self.pipeline = HeldMap()
        state = BaseState(
            0.0, np.eye(4), True, False, (False,) * 4, (False, False), 0.5, BaseMode.SAFE
        )
        self.session.robot.base_state = self.session.robot.battery_state = lambda: state
        self._grid = first_step().grid
        self._approached = None
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    @property
    def rests(self):
        return self.twist.linear == self.twist.angular == 0.0

    def grow(self):
        """It has seen all of its grid."""
        self.see(replace(self._grid, occupancy=np.full_like(self._grid.occupancy, 0.1)))

    def see(self, grid):
        """This is its obstacle map from now on."""
        self._grid = grid

    def approach(self, xy, picture=None):
        """It approaches a place, of which this JPEG is the picture; None for no place."""
        self.session.robot.picture_of_place = lambda place: picture
        self._approached = None if xy is None else np.array(xy)

    def arrive(self, text, picture=None):
        """It is asked for something and has arrived there, of which this JPEG is the picture."""
        self.session.robot.picture_of = lambda report: picture
        report = GoalReport(text, Outcome.ARRIVED, "92% sure", (), effort=Effort(50.0, 12.34))

        def end(pipeline):
            self.session.ask([text])
            self.session.queue.current()
            self.session.on_goal(report)

        self.session.jobs.submit(end).result(DEADLINE)

    def close(self):
        self._closed.set()
        self._thread.join()

    def _run(self):
        step, ticks = first_step(), 0
        while not self._closed.wait(_PERIOD):
            told = STOP if self.session.stopped.is_set() else self.session.lease.twist() or STOP
            if (told.linear, told.angular) != (self.twist.linear, self.twist.angular):
                self.driven.append(told)
            self.twist = told
            while self.session.jobs.do_next(self.pipeline):
                pass
            if ticks % 10 == 0:
                self.session.begin_step()
                asked = self.session.queue.current()
                if asked is not None and asked.called_off:
                    self.session.queue.finish(Outcome.GAVE_UP, asked.reason)
                    asked = None
                goal = "" if asked is None else asked.text
                step = replace(step, index=step.index + 1, goal=goal, grid=self._grid)
                estimate = replace(step.estimate, tracking=self.tracking)
                step = replace(step, estimate=estimate)
                activity, why = ("exploring", LONG_WHY) if goal else ("mapping", "")
                step = replace(step, activity=activity, why=why, question=self.question)
                step = replace(step, candidate_xy=self._approached if goal else None)
                self.session.on_step(step)
            ticks += 1
