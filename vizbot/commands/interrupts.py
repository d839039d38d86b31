"""Interrupts in whatever disguise they arrive."""

from __future__ import annotations


def is_interrupt(error: BaseException) -> bool:
    """Whether `error` is Ctrl-C or a signal, which compiled code wraps into a `SystemError`."""
    if isinstance(error, SystemError):
        return isinstance(error.__cause__ or error.__context__, KeyboardInterrupt)
    return isinstance(error, KeyboardInterrupt)
