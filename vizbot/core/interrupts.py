"""Interrupts of a program, also those that arrive as another error."""

from __future__ import annotations

import ctypes
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_SOON = 0.01
"""From an interrupt that a finaliser lost to the next one [s]; the finaliser has ended then."""


class _Hold(threading.local):
    """How many changes that hold interrupts this thread is in, and whether one waits for them."""

    depth = 0
    waits = False


_hold = _Hold()


def is_interrupt(error: BaseException) -> bool:
    """Whether `error` is Ctrl-C or a signal, which compiled code wraps into other errors.

    Calls raise a `SystemError` from it, imports an `ImportError`, and ctypes an `ArgumentError`
    that only mentions its name.
    """
    inner: BaseException | None = error
    while isinstance(inner, SystemError | ImportError):
        inner = inner.__cause__ or inner.__context__
    if isinstance(inner, ctypes.ArgumentError):
        return "KeyboardInterrupt" in str(inner)
    return isinstance(inner, KeyboardInterrupt)


@contextmanager
def ended_by_interrupt() -> Iterator[None]:
    """Do something whose documented end is an interrupt: it is no error there."""
    try:
        yield
    except BaseException as error:
        if not is_interrupt(error):
            raise


@contextmanager
def holding_interrupts() -> Iterator[None]:
    """Change what must not be left half changed: an interrupt ends the program after it.

    It holds those of `ending_on_signals`; keep what is done inside short, the robot still drives.
    """
    _hold.depth += 1
    try:
        yield
    finally:
        _hold.depth -= 1
        if _hold.waits and not _hold.depth:
            _hold.waits = False
            raise KeyboardInterrupt


@contextmanager
def ending_on_signals() -> Iterator[None]:
    """Turn the first signal that ends a program into an interrupt, so that devices are closed.

    Further signals are ignored until the program has ended, so that nothing cuts the stop short.
    An interrupt that arrives in a finaliser, which lets no error out, comes again after it.
    """
    ending = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    report = sys.unraisablehook

    def interrupt(number: int, frame: object) -> None:
        for each in ending:
            signal.signal(each, signal.SIG_IGN)
        if _hold.depth:
            _hold.waits = True
            return
        raise KeyboardInterrupt

    def interrupt_again(lost: sys.UnraisableHookArgs) -> None:
        if lost.exc_value is None or not is_interrupt(lost.exc_value):
            report(lost)
            return
        signal.signal(signal.SIGINT, interrupt)
        here = threading.get_ident()
        threading.Timer(_SOON, signal.pthread_kill, (here, signal.SIGINT)).start()

    before = {each: signal.signal(each, interrupt) for each in ending}
    sys.unraisablehook = interrupt_again
    try:
        yield
    finally:
        sys.unraisablehook = report
        for each, handler in before.items():
            if signal.getsignal(each) is interrupt:
                signal.signal(each, handler)
