import time
from threading import Event

import pytest

from vizbot.core.simulated_clock import SimulatedClock


class Recorder:
    def __init__(self, events, name="device"):
        self.events = events
        self.name = name

    def publish(self):
        self.events.append(f"{self.name} publishes")

    def advance(self, seconds):
        self.events.append(f"{self.name} advances {seconds}")


def test_sleeping_takes_whole_periods():
    clock = SimulatedClock(period=0.01)
    for seconds in (0.025, 0.0):
        clock.sleep(seconds)
        assert clock.now() == pytest.approx(0.03)


def test_rounding_never_costs_a_period():
    clock = SimulatedClock()
    for n in range(1, 2001):
        clock.sleep(0.015)
        assert clock.now() == pytest.approx(0.015 * n, abs=1e-9)


def test_sleeping_takes_no_wall_time():
    before = time.monotonic()
    SimulatedClock().sleep(60.0)
    assert time.monotonic() - before < 5.0


def test_in_every_period_devices_publish_then_steps_run_then_devices_advance():
    clock, events = SimulatedClock(period=0.5), []
    clock.attach(Recorder(events, "base"))
    clock.attach(Recorder(events, "lamp"))
    clock.repeat(lambda: events.append(f"step at {clock.now()}"))
    clock.sleep(1.0)
    period = ["base publishes", "lamp publishes", "step at {}"]
    period += ["base advances 0.5", "lamp advances 0.5"]
    assert events == [event.format(now) for now in (0.0, 0.5) for event in period]


def test_what_was_added_can_be_taken_away_again_even_in_the_middle_of_a_period():
    clock, events = SimulatedClock(), []
    detach = clock.attach(Recorder(events))

    def once():
        events.append("once")
        end()

    end = clock.repeat(once)
    clock.sleep(0.015)
    detach()
    detach()
    clock.sleep(0.15)
    assert events == ["device publishes", "once", "device advances 0.015"]


def test_work_is_done_beside_the_caller_and_shown_after_its_latency():
    clock, goes_on = SimulatedClock(), Event()
    pending = clock.start(lambda: goes_on.wait(10.0) and "embedding", latency=0.04)
    assert not pending.ready()
    clock.sleep(0.03)
    assert not pending.ready()
    clock.sleep(0.015)
    goes_on.set()
    assert pending.ready()
    assert pending.result() == "embedding"
    assert clock.now() == pytest.approx(0.045)


def test_work_sees_the_time_at_which_it_was_started_however_late_it_runs():
    clock, goes_on = SimulatedClock(), Event()
    clock.sleep(0.03)
    pending = clock.start(lambda: goes_on.wait(10.0) and clock.now(), latency=0.0)
    clock.sleep(0.3)
    goes_on.set()
    assert pending.result() == pytest.approx(0.03)
    assert clock.now() == pytest.approx(0.33)


def test_work_that_is_due_and_not_done_is_waited_for():
    clock, done = SimulatedClock(), []
    pending = clock.start(lambda: time.sleep(0.05) or done.append(7), latency=0.0)
    assert pending.ready()
    assert done == [7]


def test_asking_for_a_result_too_early_waits_for_it():
    clock = SimulatedClock()
    assert clock.start(lambda: 7, latency=0.1).result() == 7
    assert clock.now() == pytest.approx(0.105)


def test_the_error_of_work_is_raised_where_its_result_is_asked_for():
    pending = SimulatedClock().start(lambda: 1 / 0, latency=0.0)
    assert pending.ready()
    with pytest.raises(ZeroDivisionError):
        pending.result()


def test_a_step_that_sleeps_is_an_error():
    clock = SimulatedClock()
    clock.repeat(lambda: clock.sleep(1.0))
    with pytest.raises(RuntimeError, match="cannot sleep"):
        clock.sleep(0.015)


def test_an_error_in_a_step_reaches_whoever_sleeps_and_time_can_go_on():
    clock = SimulatedClock()
    end = clock.repeat(lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        clock.sleep(0.015)
    end()
    clock.sleep(0.015)
    assert clock.now() == pytest.approx(0.015)
