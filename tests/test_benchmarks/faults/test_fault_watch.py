"""What the watch over a drive calls a stop, and what it counts against the robot."""

from types import SimpleNamespace

import pytest

from benchmarks.faults.monitor import FARTHEST_ASTRAY, FaultMonitor
from drivers.roomba.commands import Command, Opcode
from sim_stubs.faults.catalogue import CATALOGUE, FaultSchedule, PlannedFault
from sim_stubs.world.body import Contacts
from vizbot.core.simulated_clock import SimulatedClock

REST, GO = ((0.0, 0.0), False), ((0.2, 0.2), False)
"""What is asked for in a period in which nothing is felt."""


def watching(names, start, lasts, camera_period):
    """A base, the watch over it, their clock, and a step in which wheel speeds are asked for."""
    clock = SimulatedClock()
    body = SimpleNamespace(asked=(0.0, 0.0), contacts=Contacts(), stalls=False)
    base = SimpleNamespace(body=body, heard=True, connected=True, sent=())
    planned = [PlannedFault(CATALOGUE[name], start, lasts) for name in names]
    watch = FaultMonitor(base, FaultSchedule(planned, clock.now, 0), clock, camera_period)

    def step(asked):
        watch.publish()
        body.asked = asked
        watch.advance(0.015)
        clock.sleep(0.015)

    return base, watch, clock, step


def watched(names, course, silent=0, before=(0.2, 0.2), lasts=0.3, camera_period=0.1):
    """Watch a course: what is told and felt in each period of 15 ms, from the time of 1 s.

    The base is silent in the first `silent` periods; a fault that passes does so after `lasts` [s],
    and the camera gives a frame every `camera_period` [s].
    """
    base, watch, clock, step = watching(names, 1.0, lasts, camera_period)
    base.body.asked = before
    while clock.now() < 1.0:
        step(before)
    for period, (asked, felt) in enumerate(course):
        base.heard = period >= silent
        edge = felt and "cliff" in names
        base.body.contacts = Contacts(
            bump_left=felt and "bump" in names, cliffs=(edge, *3 * (False,))
        )
        base.body.stalls = felt and "stuck-wheel" in names
        step(asked)
    return watch


def test_a_stop_counts_from_the_frame_that_tells_to_the_end_of_the_period():
    watch = watched(["bump"], [((0.2, 0.2), False)] * 3 + [((0.2, 0.2), True)] * 2
                    + [((0.0, 0.0), True)])  # fmt: skip
    [stop] = watch.stops()
    assert (stop.rolling, stop.after, stop.within) == (True, 0.045, 0.1)
    assert stop.run_on == pytest.approx(0.006)
    assert not watch.drove_on


@pytest.mark.parametrize("name", ["bump", "cliff", "stuck-wheel"])
def test_it_is_felt_before_it_has_to_be_heeded(name):
    ahead = (0.2, 0.2)
    watch = watched([name], [(ahead, False)] * 12 + [(ahead, True)] * 2 + [((0.0, 0.0), True)])
    [stop] = watch.stops()
    assert (stop.rolling, stop.after) == (True, 0.045) and watch.happened
    assert not watched([name], [(ahead, False)] * 40).happened


@pytest.mark.parametrize("asked", [(0.2, 0.2), (-0.12, 0.13)], ids=["goes on", "turns"])
def test_who_does_not_rest_is_late(asked):
    [stop] = watched(["bump"], [(asked, True)] * 40).stops()
    assert stop.after is None
    assert not stop.in_time


def test_what_nobody_can_have_heard_of_does_not_show_and_a_frozen_camera_loosens_no_reflex():
    course = [((0.2, 0.2), True)] * 12 + [((0.0, 0.0), True)] * 20
    for silent, after in ((0, 0.195), (6, 0.105), (8, 0.075)):
        watch = watched(["bump", "camera-frozen"], course, silent)
        stops = {stop.fault: stop for stop in watch.stops()}
        assert (stops["bump"].after, stops["bump"].within) == (after, 0.1)
        assert stops["bump"].in_time == (after <= 0.1)
    unheard = watched(["bump", "stream-silent"], course, silent=32)
    assert [stop.fault for stop in unheard.stops()] == ["stream-silent"]
    assert not unheard.happened


def test_only_who_goes_ahead_after_it_has_driven_on():
    stopped = [((0.2, 0.2), True), ((0.0, 0.0), True)]
    assert not watched(["bump"], [*stopped, *[((-0.1, -0.1), False)] * 3]).drove_on
    for periods, drove_on in ((30, False), (80, False), (90, True)):
        course = [*stopped, *[REST] * periods, GO]
        assert watched(["stream-silent"], course).drove_on == drove_on


def test_who_rolls_ahead_right_after_a_fault_or_into_what_it_touches_has_not_driven_on():
    for name in ("battery-low", "disk-full", "encoder-jump"):
        assert not watched([name], [GO] * 60).drove_on
        assert watched([name], [GO] * 90).drove_on
    stopped = [((0.0, 0.0), True)] * 70
    assert not watched(["bump"], [*stopped, ((0.2, 0.2), True)]).drove_on
    assert watched(["bump"], [*stopped, GO]).drove_on


def test_a_rest_of_one_period_before_the_robot_goes_on_into_the_contact_is_no_stop():
    [stop] = watched(["bump"], [((0.0, 0.0), True)] + [((0.2, 0.2), True)] * 40).stops()
    assert stop.after is None
    assert stop.run_on == pytest.approx(40 * 0.015 * 0.2)
    away = [((-0.1, -0.1), True)] * 5 + [((-0.12, 0.13), True)] * 5
    [stop] = watched(["bump"], [((0.0, 0.0), True), *away]).stops()
    assert stop.after == 0.015


def test_who_runs_into_it_again_has_to_stop_again():
    touch, free = ((0.0, 0.0), True), ((-0.1, -0.1), False)
    pressed = ((0.2, 0.2), True)
    [soon] = watched(["bump"], [touch, free, *[pressed] * 3, touch]).stops()
    [late] = watched(["bump"], [touch, free, *[pressed] * 9, touch]).stops()
    [never] = watched(["bump"], [touch, free, *[pressed] * 9]).stops()
    assert (soon.after, late.after, never.after) == (0.06, 0.15, None)
    assert soon.in_time and not late.in_time and not never.in_time


@pytest.mark.parametrize(
    "name", ["camera-frozen", "stream-silent", "wheel-drop", "kidnapped", "charger-plugged"]
)
def test_a_rest_that_does_not_last_as_long_as_the_fault_is_no_stop(name, monkeypatch):
    monkeypatch.setattr(FaultMonitor, "_shows", lambda *_: True)
    [stop] = watched([name], [REST] + [GO] * 60, lasts=2.0).stops()
    assert stop.after is None
    [stop] = watched([name], [REST] * 60 + [GO] * 20, lasts=0.8).stops()
    assert stop.after == 0.015


def told(right, left):
    return Command(Opcode.DRIVE_DIRECT, (right, left))


def line_to(courses, names=("lost-bytes",), lasts=9.0):
    """Watch what is sent and done in each period; `False` for sent: the cable is out."""
    base, watch, _, step = watching(names, 0.0, lasts, 0.1)
    base.body.asked = (0.2, 0.2)
    for sent, asked in courses:
        base.connected, base.sent = sent is not False, sent or ()
        step(asked)
    return watch


def test_what_wheels_turn_beyond_what_they_were_told_is_added_up():
    ahead, stop = [told(200, 200)], [told(0, 0)]
    obeyed = line_to([(ahead, (0.2, 0.2)), ([], (0.2, 0.2)), (stop, (0.0, 0.0))])
    assert obeyed.astray == 0.0
    assert line_to([(ahead, (0.1, 0.0))] * 5).astray == 0.0
    for asked, beyond in (((0.5, 0.2), 0.3), ((-0.5, 0.0), 0.5)):
        wild = line_to([(ahead, asked)] * 3 + [(ahead, (0.2, 0.2))] + [(ahead, asked)] * 2)
        assert wild.astray == pytest.approx(3 * 0.015 * beyond)
    assert line_to([(stop, (0.2, 0.2))] * 60).astray > FARTHEST_ASTRAY
    assert line_to([(stop, (0.0, 0.0)), *[(False, (0.2, 0.2))] * 60]).astray == 0.0


@pytest.mark.parametrize(
    ("first", "after"),
    [([told(0, 0), told(100, 100), told(0, 0)], 0.015), ([told(200, 200), told(0, 0)], None)],
)
def test_the_first_command_once_a_cable_is_back_is_a_stop(first, after):
    out = [(False, (0.2, 0.2))] * 30
    [stop] = line_to([*out, (first, (0.0, 0.0))], ("port-vanishes",), 0.3).stops()
    assert stop.after == after
    assert stop.rolling
    assert stop.run_on == pytest.approx(30 * 0.015 * 0.2)


@pytest.mark.parametrize(
    ("asked", "rests"),
    [
        ((0.0, 0.0), True),
        ((-0.1, -0.1), True),
        ((-0.12, 0.13), True),  # it turns on the spot, with speeds that are rounded
        ((0.03, 0.03), False),
        ((0.1, 0.2), False),
        ((-0.3, -0.1), False),  # it backs off in a curve, and does not see where
    ],
)
def test_without_depth_the_robot_must_not_go_ahead(asked, rests):
    [stop] = watched(["black-depth"], [(asked, False)] * 40).stops()
    assert (stop.after is not None) == rests


def test_without_depth_a_turn_is_no_stop_for_good():
    turn = ((-0.1, 0.1), False)
    [straight] = watched(["black-depth"], [GO] * 17 + [REST] * 40).stops()
    [turned] = watched(["black-depth"], [GO] * 9 + [turn] * 2 + [GO] * 6 + [REST] * 40).stops()
    assert turned.rolling and straight.rolling
    assert turned.after == straight.after > 0.1
    assert 0.0 < turned.run_on < straight.run_on


def test_a_robot_that_only_turns_has_nothing_to_stop():
    turn = ((-0.1, 0.1), False)
    [stop] = watched(["black-depth"], [turn] * 40, before=(-0.1, 0.1)).stops()
    assert not stop.rolling


@pytest.mark.parametrize("name", ["camera-frozen", "camera-vanishes", "black-depth"])
@pytest.mark.parametrize(("period", "due"), [(0.1, 1.1), (0.4, 1.2), (0.6, 1.2)])
def test_a_fault_of_the_camera_shows_when_its_next_frame_is_due(name, period, due):
    watch = watched([name], [GO] * 40, lasts=9.0, camera_period=period)
    assert due <= watch.shown[name] + 1e-9 < due + 0.015 + 1e-6


def test_a_virtual_wall_that_is_gone_is_felt_no_more():
    watch = watched(["virtual-wall"], [REST] * 25 + [GO] * 80)
    [stop] = watch.stops()
    assert stop.after == 0.015
    assert watch.drove_on


@pytest.mark.parametrize("name", ["wheel-drop", "kidnapped"])
def test_wheels_that_do_not_hang_show_no_fault(name):
    watch = watched([name], [GO] * 10)
    assert not watch.happened
    assert watch.stops() == ()
