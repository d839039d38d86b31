import ctypes
import signal
import threading
import time

import pytest

from vizbot.core.program import interrupts
from vizbot.core.program.interrupts import (
    ending_on_signals,
    first_error,
    holding_interrupts,
    is_interrupt,
    letting_interrupts_through,
    raise_held_interrupt,
)


def wrapped(error, times, kind=SystemError):
    for _ in range(times):
        outer = kind("returned a result with an exception set")
        outer.__cause__ = error
        error = outer
    return error


DISGUISED = wrapped(KeyboardInterrupt(), 1, ImportError)


def test_an_interrupt_is_known_in_imports_by_its_name_and_however_often_it_was_wrapped():
    for times in range(4):
        assert is_interrupt(wrapped(KeyboardInterrupt(), times))
    assert is_interrupt(DISGUISED)
    assert is_interrupt(ctypes.ArgumentError("argument 1: KeyboardInterrupt: "))


@pytest.mark.parametrize(
    "error",
    [ctypes.ArgumentError("argument 1: TypeError: wrong type"), ImportError("no such module"),
     ValueError("no"), wrapped(ValueError("no"), 2), SystemError("nothing inside")],
)  # fmt: skip
def test_other_errors_are_none(error):
    assert not is_interrupt(error)


class SlowToEnd:
    """Something that is signalled while Python finalises it."""

    def __del__(self):
        signal.raise_signal(signal.SIGTERM)
        time.sleep(10.0)


def test_a_signal_within_a_finaliser_ends_the_program_all_the_same(signals):
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt), ending_on_signals():
        ending = SlowToEnd()
        del ending
        threading.Event().wait(10.0)
    assert time.monotonic() - began < 5.0


def test_a_second_signal_does_not_cut_the_stop_short(signals):
    stopped = False
    with pytest.raises(KeyboardInterrupt), ending_on_signals():
        try:
            signal.raise_signal(signal.SIGTERM)
        finally:
            signal.raise_signal(signal.SIGHUP)
            signal.raise_signal(signal.SIGINT)
            stopped = True
    assert stopped


def test_a_held_signal_ends_the_program_after_the_change(signals):
    done = []
    with pytest.raises(KeyboardInterrupt), ending_on_signals():
        with holding_interrupts():
            with holding_interrupts():
                signal.raise_signal(signal.SIGTERM)
                done.append("inner")
            done.append("outer")
        done.append("after")
    assert done == ["inner", "outer"]


def test_a_change_that_holds_no_signal_ends_nothing(signals):
    with ending_on_signals():
        with holding_interrupts():
            pass
        with pytest.raises(ValueError, match="wrong"), holding_interrupts():
            raise ValueError("wrong")
    with pytest.raises(KeyboardInterrupt), ending_on_signals():
        signal.raise_signal(signal.SIGTERM)


def test_other_errors_of_finalisers_are_reported_as_before(monkeypatch):
    reported = []
    monkeypatch.setattr("sys.unraisablehook", lambda lost: reported.append(lost.exc_type))

    class Broken:
        def __del__(self):
            raise ValueError

    with ending_on_signals():
        broken = Broken()
        del broken
    assert reported == [ValueError]


def test_what_holds_signals_ends_where_it_may_end(signals):
    done = []
    with pytest.raises(KeyboardInterrupt), ending_on_signals(), holding_interrupts():
        raise_held_interrupt()
        signal.raise_signal(signal.SIGHUP)
        done.append("to its end")
        raise_held_interrupt()
        done.append("more")
    assert done == ["to its end"]


def test_several_signals_at_once_are_held_and_a_later_one_cuts_short(signals, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(interrupts.time, "monotonic", lambda: now[0])
    done = []
    with pytest.raises(KeyboardInterrupt), ending_on_signals(), holding_interrupts():
        signal.raise_signal(signal.SIGINT)
        now[0] += 1.9
        signal.raise_signal(signal.SIGTERM)
        done.append("at once")
        now[0] += 0.2
        signal.raise_signal(signal.SIGINT)
        done.append("later")
    assert done == ["at once"]


def test_amid_what_holds_signals_something_may_be_left_at_any_moment(signals):
    done = []
    with pytest.raises(KeyboardInterrupt), ending_on_signals(), holding_interrupts():
        done.append("held")
        with letting_interrupts_through():
            signal.raise_signal(signal.SIGTERM)
            done.append("not left")
    assert done == ["held"]


def test_what_is_held_comes_before_what_may_be_left(signals):
    done = []
    with pytest.raises(KeyboardInterrupt), ending_on_signals(), holding_interrupts():
        signal.raise_signal(signal.SIGTERM)
        with letting_interrupts_through():
            done.append("begun")
    assert done == []


def test_a_signal_that_is_held_hides_no_error(signals):
    with ending_on_signals():
        with pytest.raises(ValueError, match="wrong"), holding_interrupts():
            signal.raise_signal(signal.SIGTERM)
            raise ValueError("wrong")
        with pytest.raises(KeyboardInterrupt):
            raise_held_interrupt()


def test_each_part_is_done_whatever_becomes_of_those_before(caplog):
    done = []

    def fail(error):
        done.append(error)
        raise error

    first, second = ValueError("first"), KeyboardInterrupt("second")
    assert first_error(lambda: fail(first), lambda: fail(second), lambda: done.append(3)) is first
    assert done == [first, second, 3] and caplog.messages == ["second"]
    assert isinstance(first_error(lambda: fail(DISGUISED)), KeyboardInterrupt)
    assert first_error(lambda: None) is None
