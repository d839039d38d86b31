"""Interrupts in whatever disguise they arrive."""

from __future__ import annotations


def is_interrupt(error: BaseException) -> bool:
    """Whether `error` is Ctrl-C or a signal, which compiled code wraps into `SystemError`s."""
    inner: BaseException | None = error
    while isinstance(inner, SystemError):
        inner = inner.__cause__ or inner.__context__
    return isinstance(inner, KeyboardInterrupt)
