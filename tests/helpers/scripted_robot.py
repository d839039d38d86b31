"""A robot of which a test says what it feels and sees."""

from dataclasses import dataclass, field, replace

import numpy as np

from vizbot.core.diff_drive import rolled, wheel_speeds
from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.geometry import camera_mount
from vizbot.core.interfaces import Devices
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import BaseMode, BaseState, ImuSamples, Intrinsics, RGBDFrame, Twist
from vizbot.pipeline import Pipeline

CAMERA = Intrinsics(320, 240, 308.0, 308.0, 159.5, 119.5)
PERIOD = 0.21


@dataclass
class Wall:
    """A camera that always looks at a plain wall near by, so that only wheels tell the motion."""

    clock: SimulatedClock
    rgb: np.ndarray
    intrinsics: Intrinsics = CAMERA
    imu: ImuSamples = field(default_factory=ImuSamples.none)
    distance: float = 1.2

    def read(self, timeout=1.0):
        self.clock.sleep(PERIOD)
        depth = np.full(self.rgb.shape[:2], self.distance, np.float32)
        return RGBDFrame(self.clock.now(), self.rgb, depth, CAMERA, self.imu)


@dataclass
class ScriptedBase:
    """A base that rolls as told and feels what `feels` says for each tick (by number, from 0)."""

    feels: dict[int, dict] = field(default_factory=dict)
    driven: list[Twist] = field(default_factory=list)
    T_odom_base: np.ndarray = field(default_factory=lambda: np.eye(4))
    mode: BaseMode = BaseMode.SAFE
    silent_reads: int = 0
    asked: list[str] = field(default_factory=list)

    def dock(self):
        self.asked.append("dock")

    def resume(self):
        self.asked.append("resume")

    def show(self, feedback):
        self.asked.append(feedback)

    def drive(self, twist):
        self.driven.append(twist)
        left, right = wheel_speeds(twist, 0.235)
        self.T_odom_base = self.T_odom_base @ rolled(left * PERIOD, right * PERIOD, 0.235)

    def read(self):
        if self.silent_reads > 0:
            self.silent_reads -= 1
            raise DeviceTimeoutError("no answer from the base")
        state = BaseState(
            0.0, self.T_odom_base, False, False, (False,) * 4, (False, False), 1.0, self.mode
        )
        return replace(state, **self.feels.get(len(self.driven), {}))


def wall_pipeline(base, encoder, config, colour, imu=None, observers=()):
    """A pipeline of a robot before a wall of a colour."""
    clock, rgb = SimulatedClock(), np.full((240, 320, 3), colour, np.uint8)
    wall = Wall(clock, rgb, CAMERA, imu or ImuSamples.none())
    devices = Devices(clock, wall, base, camera_mount(0.6, 0.05, 0.15), False)
    return Pipeline(devices, encoder, config, observers)


def ticks(pipeline, count, text="yellow chair"):
    goal = pipeline.goal(text)
    return [pipeline.tick(goal) for _ in range(count)]


def until_it_ends(pipeline, task, most=120):
    """The steps of a task, which must end by then."""
    steps = [pipeline.tick(task)]
    while steps[-1].ended is None:
        assert len(steps) < most
        steps.append(pipeline.tick(task))
    return steps
