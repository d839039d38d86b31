"""Interrupts of a program, also those that arrive as another error."""

from __future__ import annotations

import ctypes
import signal
from collections.abc import Iterator
from contextlib import contextmanager


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
def ending_on_signals() -> Iterator[None]:
    """Turn the first signal that ends a program into an interrupt, so that devices are closed.

    Further signals are ignored until the program has ended, so that nothing cuts the stop short.
    """
    ending = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def interrupt(number: int, frame: object) -> None:
        for each in ending:
            signal.signal(each, signal.SIG_IGN)
        raise KeyboardInterrupt

    before = {each: signal.signal(each, interrupt) for each in ending}
    try:
        yield
    finally:
        for each, handler in before.items():
            if signal.getsignal(each) is interrupt:
                signal.signal(each, handler)
