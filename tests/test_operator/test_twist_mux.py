"""One base for the program, a person at the wheel, and everybody's stop."""

import threading

import pytest

from tests.helpers.failing import raising
from tests.helpers.scripted_robot import ScriptedBase
from vizbot.core.errors import DeviceError
from vizbot.core.types import STOP, Feedback, Twist
from vizbot.operator.session.drive_lease import DriveLease
from vizbot.operator.session.twist_mux import TwistMux

AHEAD, BACK = Twist(0.2, 0.0), Twist(-0.1, 0.0)


class Shared:
    def __init__(self):
        self.time = 50.0
        self.body = ScriptedBase()
        self.lease = DriveLease(lambda: self.time)
        self.stopped = threading.Event()
        self.base = TwistMux(self.body, self.lease, self.stopped, lambda: self.time)

    def drive_by_hand(self):
        link = self.lease.take("ann")
        self.lease.accept(link, 1, self.time, BACK)
        return link

    @property
    def last(self):
        return self.body.driven[-1] if self.body.driven else None


@pytest.fixture
def shared():
    return Shared()


def test_the_program_drives_while_nobody_else_does(shared):
    shared.base.hold()
    shared.base.drive(AHEAD)
    shared.base.hold()
    assert shared.body.driven == [AHEAD]


def test_who_drives_by_hand_comes_first_and_letting_go_stops_the_wheels_once(shared):
    link = shared.drive_by_hand()
    shared.base.drive(AHEAD)
    shared.base.hold()
    assert shared.body.driven == [BACK]
    shared.lease.release(link)
    shared.base.hold()
    shared.base.hold()
    assert shared.body.driven == [BACK, STOP]
    shared.base.drive(AHEAD)
    assert shared.last == AHEAD


def test_every_command_that_is_sent_is_told_with_who_gave_it(shared):
    told = []
    shared.base.on_drive = lambda *command: told.append(command)
    shared.base.hold()
    shared.base.drive(AHEAD)
    link = shared.drive_by_hand()
    shared.base.drive(AHEAD)
    shared.base.hold()
    shared.lease.release(link)
    shared.base.hold()
    shared.base.hold()
    assert told == [("robot", AHEAD), ("ann", BACK), ("ann", STOP)]
    told.clear()
    shared.stopped.set()
    shared.base.drive(AHEAD)
    shared.base.hold()
    shared.base.rest()
    assert told == [("stop", STOP), ("robot", STOP)]


def test_stop_comes_before_everybody(shared):
    shared.drive_by_hand()
    shared.stopped.set()
    shared.base.drive(AHEAD)
    shared.base.hold()
    assert shared.body.driven == [STOP]


@pytest.mark.parametrize(("state", "age"), [("state", 0.9), ("battery_state", 9.9)])
def test_what_the_base_said_long_ago_tells_nothing(shared, state, age):
    assert getattr(shared.base, state) is None
    said = shared.base.read()
    shared.time += age
    assert getattr(shared.base, state) is said
    shared.time += 0.2
    assert getattr(shared.base, state) is None


def test_a_base_that_is_gone_ends_no_holding(shared, monkeypatch):
    monkeypatch.setattr(shared.body, "drive", raising(DeviceError("gone")))
    told = []
    shared.base.on_drive = lambda *command: told.append(command)
    shared.stopped.set()
    shared.base.hold()
    with pytest.raises(DeviceError):
        shared.base.rest()
    assert told == []


def test_stop_takes_a_base_back_that_looks_for_its_dock(shared):
    shared.base.dock()
    shared.base.hold()
    assert shared.body.asked == ["dock"]
    shared.stopped.set()
    shared.base.hold()
    shared.base.hold()
    assert shared.body.asked == ["dock", "resume"]
    shared.base.dock()
    assert shared.body.asked == ["dock", "resume"]


def test_the_end_of_a_run_takes_it_back_as_well(shared):
    shared.base.dock()
    shared.base.rest()
    assert shared.body.asked == ["dock", "resume"] and shared.last == STOP


def test_a_base_that_charges_is_left_alone_by_stop_and_obeys_who_drives_by_hand(shared):
    shared.base.dock()
    shared.body.feels = {0: {"docked": True}}
    shared.base.read()
    shared.stopped.set()
    shared.base.hold()
    assert shared.body.asked == ["dock"]
    shared.stopped.clear()
    shared.lease.take("ann")
    shared.base.hold()
    shared.base.hold()
    assert shared.body.asked == ["dock", "resume"]


def test_what_is_to_be_shown_is_shown_once(shared):
    shared.base.show_soon(Feedback.DOUBT)
    shared.base.hold()
    shared.base.hold()
    assert shared.body.asked == [Feedback.DOUBT]
