import threading

import pytest

from tests.helpers.failing import raising
from vizbot.core.clock import WallClock


def test_what_is_repeated_runs_until_it_is_stopped():
    ran = threading.Event()
    stop = WallClock().repeat(ran.set)
    assert ran.wait(5.0)
    stop()
    ran.clear()
    assert not ran.wait(0.05)


def test_started_work_gives_its_result_or_raises_its_error():
    clock = WallClock()
    assert clock.start(lambda: 6 * 7, latency=100.0).result() == 42
    with pytest.raises(ValueError, match="no"):
        clock.start(raising(ValueError("no")), latency=0.0).result()


def test_time_does_not_go_back():
    clock = WallClock()
    assert clock.now() <= clock.now()
