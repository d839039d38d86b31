"""Interrupts of a program, also those that arrive as another error, and what they must not cut."""

from __future__ import annotations

import ctypes
import logging
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

log = logging.getLogger(__name__)

_SOON = 0.01
"""From an interrupt that a finaliser lost to the next one [s]; the finaliser has ended then."""
_ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_PATIENCE = 2.0
"""From a signal that is held until one more cuts short what holds it [s]: a closed terminal or a
supervisor sends several at once, a person who waits in vain sends another one later."""


class _Hold(threading.local):
    """How many parts that hold interrupts this thread is in, and since when one waits [s]."""

    depth = 0
    since: float | None = None


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
    """Do what must not be left half done: an interrupt ends the program after it.

    It holds those of `ending_on_signals`, so that no signal strikes amid a message, a call of
    compiled code or a `finally`. What takes long calls `raise_held_interrupt` where it may end. An
    error that ends it anyhow goes on instead of the interrupt, which is raised where it may be.
    """
    before = _hold.depth
    _hold.depth = before + 1
    try:
        yield
    finally:
        _hold.depth = before
    if not before:
        raise_held_interrupt()


@contextmanager
def letting_interrupts_through() -> Iterator[None]:
    """Do, amid what holds interrupts, something that may be left at any moment."""
    before = _hold.depth
    raise_held_interrupt()
    _hold.depth = 0
    try:
        yield
    finally:
        _hold.depth = before


def first_error(*parts: Callable[[], object]) -> BaseException | None:
    """Do one part after another, each even if one before it failed.

    Returns:
        The first error, an interrupt as one; those after it are logged. None without any.
    """
    first: BaseException | None = None
    for part in parts:
        try:
            part()
        except BaseException as error:
            if first is None:
                first = KeyboardInterrupt() if is_interrupt(error) else error
            else:
                log.error("%s", one_line(error))
    return first


def one_line(error: BaseException) -> str:
    """An error in one line, without its kind."""
    return " ".join(str(error).split()) or type(error).__name__


def raise_held_interrupt() -> None:
    """Let an interrupt that is held end the program here."""
    if _hold.since is not None:
        _ignore_signals()
        raise KeyboardInterrupt


def _ignore_signals() -> None:
    _hold.since = None
    for each in _ENDING:
        signal.signal(each, signal.SIG_IGN)


@contextmanager
def ending_on_signals() -> Iterator[None]:
    """Turn the first signal that ends a program into an interrupt, so that devices are closed.

    Further signals are ignored until the program has ended, so that nothing cuts the stop short.
    An interrupt that arrives in a finaliser, which lets no error out, comes again after it.
    """
    report = sys.unraisablehook

    def interrupt(number: int, frame: object) -> None:
        if _hold.depth:
            now = time.monotonic()
            if _hold.since is None:
                _hold.since = now
            if now < _hold.since + _PATIENCE:
                return
        _ignore_signals()
        raise KeyboardInterrupt

    def interrupt_again(lost: sys.UnraisableHookArgs) -> None:
        if lost.exc_value is None or not is_interrupt(lost.exc_value):
            report(lost)
            return
        signal.signal(signal.SIGINT, interrupt)
        here = threading.get_ident()
        threading.Timer(_SOON, signal.pthread_kill, (here, signal.SIGINT)).start()

    before = {each: signal.signal(each, interrupt) for each in _ENDING}
    sys.unraisablehook = interrupt_again
    try:
        yield
    finally:
        sys.unraisablehook = report
        for each, handler in before.items():
            if signal.getsignal(each) is interrupt:
                signal.signal(each, handler)
