"""Embeddings and decisions take the time that they took on a machine."""

import threading
from collections import Counter

import numpy as np
import pytest

from benchmarks import loop_latency
from benchmarks.episodes.latency import DecidedBase, Latencies, slow_devices
from benchmarks.loop_latency import LoopTimes, TimedClock
from vizbot.config import Config
from vizbot.core.interfaces import Devices
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import STOP, Twist

AHEAD, ROUND = Twist(0.2, 0.0), Twist(0.0, 1.0)
MEASURED = Latencies("c0ffee", "2 cores", 0.1, (0.03, 0.3), (0.06, 0.15))


class Base:
    """Notes when it is commanded what."""

    def __init__(self, clock):
        self._clock = clock
        self.heard = []

    def drive(self, twist):
        self.heard.append((round(self._clock.now(), 3), twist))

    def read(self):
        return "state"

    def resume(self):
        self.heard.append("resume")


@pytest.fixture
def clock():
    return SimulatedClock()


def slowed(clock, seed=1, latencies=MEASURED):
    base = Base(clock)
    return base, slow_devices(Devices(clock, None, base, None, False), latencies, Config(), seed)


def test_a_command_comes_after_its_decision_and_the_one_before_holds_meanwhile(clock):
    base, devices = slowed(clock, latencies=Latencies("", "", 0.0, (0.1,), (0.06,)))
    for twist in (AHEAD, ROUND):
        assert devices.base.read() == "state"
        devices.base.drive(twist)
    devices.base.drive(STOP)  # of nobody who decided
    assert base.heard == [(0.0, STOP), (0.06, AHEAD), (0.06, AHEAD), (0.12, ROUND), (0.12, STOP)]


def test_a_base_that_was_asked_to_obey_again_does_not_go_on_as_before(clock):
    base, devices = slowed(clock)
    devices.base.drive(AHEAD)
    devices.base.resume()
    devices.base.read()
    devices.base.drive(ROUND)
    assert [each if each == "resume" else each[1] for each in base.heard] == [
        AHEAD, "resume", STOP, ROUND
    ]  # fmt: skip


def delays(clock, seed):
    """How long 60 embeddings and 60 decisions take."""
    _, devices = slowed(clock, seed)
    embeddings, decisions = [], []
    for _ in range(60):
        began = clock.now()
        devices.clock.start(lambda: None, Config().perception.embedding_latency).result()
        embeddings.append(round(clock.now() - began, 3))
        began = clock.now()
        devices.base.read()
        devices.base.drive(AHEAD)
        decisions.append(round(clock.now() - began, 3))
    return embeddings, decisions


def test_each_takes_one_of_the_measured_times_and_a_seed_gives_them_again():
    embeddings, decisions = delays(SimulatedClock(), 1)
    assert set(embeddings) == {0.03, 0.3} and set(decisions) == {0.06, 0.15}
    assert min(*Counter(embeddings).values(), *Counter(decisions).values()) > 15
    assert delays(SimulatedClock(), 1) == (embeddings, decisions)
    again = delays(SimulatedClock(), 2)
    assert again[0] != embeddings and again[1] != decisions


def test_slownesses_of_a_clock_multiply(clock):
    for factor in (2.0, 3.0):
        clock.slow_down(lambda factor=factor: factor)
    clock.start(lambda: None, 0.05).result()
    assert clock.now() == pytest.approx(0.3)


def test_the_kept_measurement_is_of_hundreds_of_embeddings_and_decisions():
    kept = Latencies.kept()
    assert kept.commit and kept.hardware
    for values in (kept.embedding, kept.decision):
        assert len(values) >= 200
        assert 0.005 < np.median(values) < 0.5 and max(values) < 2.0


def test_the_embedding_beside_a_decision_is_not_counted_twice(clock, monkeypatch):
    driving, seconds = threading.get_ident(), {True: iter([0.0, 6.0]), False: iter([1.0, 4.0])}
    monkeypatch.setattr(
        loop_latency.time, "thread_time", lambda: next(seconds[threading.get_ident() == driving])
    )
    times = LoopTimes()
    base = DecidedBase(Base(clock), times.end_decision, times.begin_decision)
    base.read()
    assert TimedClock(clock, times).start(lambda: "done", 0.0).result() == "done"
    base.drive(AHEAD)
    base.drive(STOP)
    assert (times.embedding, times.decision) == ([3.0], [6.0])
