"""Come back and dock: the real driver on a simulated base with a dock, in a bare room."""

import math
import threading
from contextlib import closing

import numpy as np
import pytest

from benchmarks.faults.minimal_robot import GreyEncoder, WheelPoses
from drivers.roomba.base import Roomba
from drivers.roomba.packets import Buttons
from drivers.roomba.serial_port import open_serial
from drivers.roomba.service import LockstepLink
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.roomba.dock import SimulatedDock
from sim_stubs.world.body import FreeFloor
from sim_stubs.world.box_room import BoxCamera
from vizbot.config import Config
from vizbot.core.geometry import planar
from vizbot.core.interfaces import Devices
from vizbot.core.observer import Outcome
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import BaseMode
from vizbot.objectnav.tasks import Task, Waypoint
from vizbot.operator.session.drive_lease import DriveLease
from vizbot.operator.session.twist_mux import TwistMux
from vizbot.perception.interfaces import PerceptionParts
from vizbot.pipeline import Pipeline

ON_DOCK = planar(0.0, 0.0, math.pi)
"""A robot on its contacts faces the dock."""
DOCK = SimulatedDock(planar(-0.15, 0.0, 0.0))
CONFIG = Config.model_validate(
    {"objectnav": {"look_around": False}, "docking": {"contact_timeout": 40.0}}
)


class Robot:
    """A pipeline on devices of which the test knows where they are."""

    def __init__(self, T_world_base=ON_DOCK, dock=DOCK, charge=1.0):
        self.clock, self.floor = SimulatedClock(), FreeFloor(T_world_base=T_world_base)
        self.stub = SimulatedRoomba(self.floor, dock=dock, charge=charge)
        self.clock.attach(self.stub)
        link = LockstepLink(
            lambda: self.stub.lockstep_port(open_serial(self.stub.path)), self.clock, CONFIG.roomba
        )
        self.base = Roomba(link, self.clock, CONFIG.roomba)
        mount = CONFIG.mount.T_base_cam
        camera = BoxCamera(self.floor, self.clock, mount, 5.0)
        self.lease = DriveLease(self.clock.now)
        self.shared = TwistMux(self.base, self.lease, threading.Event(), self.clock.now)
        devices = Devices(self.clock, camera, self.shared, mount, False)
        parts = PerceptionParts(slam=WheelPoses(mount))
        self.pipeline = Pipeline(devices, GreyEncoder(), CONFIG, [], parts)

    def close(self):
        self.base.close()
        self.stub.close()

    def do(self, task, seconds=120.0):
        """Until it has ended: how, and why."""
        until = self.clock.now() + seconds
        while self.clock.now() < until:
            step = self.pipeline.tick(task)
            if step.ended is not None:
                return step.ended
        raise AssertionError(f"{task} has not ended, it does: {step.activity}")

    @property
    def xy(self):
        return self.floor.T_world_base[:2, 3]


@pytest.fixture
def robot(opened):
    return lambda *place, **settings: opened.enter_context(closing(Robot(*place, **settings)))


def test_it_goes_to_a_place_and_comes_back_to_where_it_began(robot):
    there = robot(planar(0.5, 0.5, 0.3), dock=None)
    start = there.xy.copy()
    ahead = Waypoint(1.5, -0.8)
    outcome, reason = there.do(ahead)
    assert outcome is Outcome.ARRIVED, reason
    # `map` begins where the robot stood, with its heading.
    place = (planar(0.5, 0.5, 0.3) @ [ahead.x, ahead.y, 0.0, 1.0])[:2]
    assert np.linalg.norm(there.xy - place) < 0.3
    outcome, reason = there.do(Task.COME_BACK)
    assert outcome is Outcome.ARRIVED, reason
    assert np.linalg.norm(there.xy - start) < 0.3


@pytest.mark.slow
def test_a_robot_that_began_on_its_dock_finds_back_onto_it_charges_and_leaves_it_again(robot):
    there = robot(charge=0.5)
    assert there.do(Waypoint(-1.5, 1.0))[0] is Outcome.ARRIVED
    assert np.linalg.norm(there.xy) > 1.0
    outcome, reason = there.do(Task.DOCK)
    assert (outcome, reason) == (Outcome.ARRIVED, "it is on its dock")
    state = there.base.read()
    assert state.docked and state.mode is BaseMode.PASSIVE
    charge = state.battery
    for _ in range(50):
        there.pipeline.tick(Task.MAP)  # who only looks leaves it charging
    state = there.base.read()
    assert state.docked and state.mode is BaseMode.PASSIVE and state.battery >= charge
    assert there.do(Waypoint(-1.5, -1.0))[0] is Outcome.ARRIVED
    assert there.base.read().mode is BaseMode.SAFE


def test_on_its_dock_but_obeying_it_is_told_to_charge(robot):
    there = robot(charge=0.5)
    assert there.base.read().mode is BaseMode.SAFE
    assert there.do(Task.DOCK)[0] is Outcome.ARRIVED
    assert there.base.read().mode is BaseMode.PASSIVE


@pytest.mark.slow
def test_a_robot_that_was_launched_on_its_dock_charges_until_it_is_asked_for_something(robot):
    there = robot(charge=0.5)
    assert there.base.read().mode is BaseMode.SAFE
    for _ in range(50):
        there.pipeline.tick(Task.MAP)
    state = there.base.read()
    assert state.mode is BaseMode.PASSIVE and state.battery > 0.5
    assert there.do(Waypoint(-1.5, -1.0))[0] is Outcome.ARRIVED
    assert there.base.read().mode is BaseMode.SAFE
    there.pipeline.tick(Task.MAP)
    there.clock.sleep(0.1)
    assert there.base.read().mode is BaseMode.SAFE  # off its dock it waits ready to drive


def test_who_drives_by_hand_is_obeyed_on_the_dock(robot):
    there = robot(charge=0.5)
    there.pipeline.tick(Task.MAP)
    there.clock.sleep(0.1)
    assert there.base.read().mode is BaseMode.PASSIVE
    there.lease.take("ann")
    for _ in range(5):
        there.shared.hold()
        there.pipeline.tick(Task.MAP)
    assert there.base.read().mode is BaseMode.SAFE


def looking_for_its_dock(robot):
    """A robot whose base looks for a dock that is not there."""
    lonely = robot(planar(0.0, 0.0, 0.0), dock=None)
    while lonely.pipeline.tick(Task.DOCK).activity != "docking":
        pass
    return lonely


@pytest.mark.slow
def test_another_map_changes_nothing_of_what_the_base_does(robot):
    there = robot(charge=0.5)
    assert there.do(Task.DOCK)[0] is Outcome.ARRIVED
    there.pipeline.begin_map(None)
    there.pipeline.tick(Task.MAP)
    assert there.base.read().mode is BaseMode.PASSIVE
    assert there.do(Waypoint(-1.5, 0.0))[0] is Outcome.ARRIVED
    lonely = looking_for_its_dock(robot)
    lonely.pipeline.begin_map(None)
    lonely.pipeline.tick(Task.MAP)
    lonely.clock.sleep(1.0)
    assert lonely.base.read().mode is BaseMode.SAFE


@pytest.mark.slow
def test_a_robot_that_was_pushed_off_its_dock_goes_back(robot):
    there = robot(charge=0.5)
    assert there.do(Task.DOCK)[0] is Outcome.ARRIVED
    there.floor.place(planar(0.6, 0.1, math.pi))
    assert there.do(Task.DOCK) == (Outcome.ARRIVED, "it is on its dock")
    assert np.linalg.norm(there.xy) < 0.2


def test_who_presses_clean_ends_the_docking(robot):
    there = looking_for_its_dock(robot)
    there.clock.sleep(0.5)
    there.stub.press(Buttons.CLEAN)
    assert there.do(Task.DOCK, 2.0) == (Outcome.GAVE_UP, "somebody pressed Clean on the base")
    there.clock.sleep(1.0)
    assert there.base.read().mode is BaseMode.SAFE


@pytest.mark.slow
def test_where_it_cannot_get_before_its_dock_the_base_is_not_let_loose(robot):
    there = robot()
    there.do(Waypoint(-2.5, 0.0))
    wall = np.array([[-1.8, -9.0], [-1.7, -9.0], [-1.7, 9.0], [-1.8, 9.0]], np.float32)
    there.pipeline.keep_out = (wall,)
    outcome, reason = there.do(Task.DOCK)
    assert (outcome, reason) == (Outcome.GAVE_UP, "the map shows no way to that place")
    assert there.base.read().mode is BaseMode.SAFE


@pytest.mark.slow
def test_a_dock_that_is_gone_is_given_up_and_the_base_obeys_again(robot):
    there = robot(planar(0.0, 0.0, 0.0), dock=None)
    began = there.clock.now()
    outcome, reason = there.do(Task.DOCK)
    assert outcome is Outcome.GAVE_UP
    assert "not found its dock within 40 s" in reason
    assert there.clock.now() - began > 40.0
    there.clock.sleep(1.0)
    assert there.base.read().mode is BaseMode.SAFE


def test_another_task_takes_a_base_that_looks_for_its_dock_back(robot):
    there = looking_for_its_dock(robot)
    there.clock.sleep(0.2)
    assert there.base.read().mode is BaseMode.PASSIVE
    there.pipeline.tick(Task.MAP)
    there.clock.sleep(1.0)
    assert there.base.read().mode is BaseMode.SAFE
    assert there.stub.mode is BaseMode.SAFE


def test_a_low_battery_keeps_it_from_everything_but_its_dock(robot):
    there = robot(planar(0.8, 0.3, math.pi), charge=0.02)
    assert "battery is at" in there.do(Waypoint(1.0, 0.0))[1]
    assert there.do(Task.DOCK)[0] is Outcome.ARRIVED
