"""Standard error that never ends or holds up a run: no run depends on progress or logs."""

from __future__ import annotations

import io
import os
import select
import socket
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from stat import S_ISCHR, S_ISFIFO, S_ISSOCK

_STANDARD_INPUT, _STANDARD_OUTPUT, _STANDARD_ERROR = range(3)
_PATIENCE = 0.1
"""A reader that takes nothing for so long has gone to sleep, and is not waited for again [s]."""


class LossyFile(io.FileIO):
    """A file that loses what cannot be written to it.

    Its reader has ended or sleeps (a paused terminal, a stalled connection), or its disk is full.
    """

    def __init__(self, descriptor: int) -> None:
        """Write to an open descriptor, which stays open and as it is for other processes."""
        super().__init__(descriptor, "w", closefd=False)
        self._opened = ExitStack()
        self._put = self._opened.enter_context(_writer(descriptor))
        self._ready = select.poll()
        self._ready.register(descriptor, select.POLLOUT)
        self._asleep = False

    def write(self, content: object, /) -> int:
        """Write, and say so even where it failed."""
        view = memoryview(content).cast("B")  # type: ignore[arg-type]
        left, until = view, time.monotonic() + (0.0 if self._asleep else _PATIENCE)
        with suppress(OSError):
            while left:
                try:
                    left = left[self._put(left) :]
                    self._asleep = False
                except BlockingIOError:
                    wait = max(until - time.monotonic(), 0.0)
                    if not self._ready.poll(1000 * wait):
                        self._asleep = True
                        break
        return len(view)

    def close(self) -> None:
        """Close what was opened for this; twice is fine."""
        self._opened.close()
        super().close()


def lose_what_cannot_be_written() -> None:
    """Have everything that goes to standard error lost where it cannot be written.

    Where standard error is closed, the next file that is opened would take its place, and get what
    libraries write to it: a null device takes it instead. Likewise for the other two.
    """
    while (free := os.open(os.devnull, os.O_RDWR)) <= _STANDARD_ERROR:
        pass
    os.close(free)
    # Python has none of those that were closed when it started.
    sys.stdin = sys.stdin or os.fdopen(_STANDARD_INPUT, closefd=False)
    sys.stdout = sys.stdout or os.fdopen(_STANDARD_OUTPUT, "w", closefd=False)
    sys.stderr = io.TextIOWrapper(
        LossyFile(_STANDARD_ERROR),
        encoding="utf-8",
        errors="backslashreplace",
        write_through=True,
    )


@contextmanager
def _writer(descriptor: int) -> Iterator[Callable[[memoryview], int]]:
    """What writes to a descriptor and raises BlockingIOError rather than wait for its reader."""
    mode = os.fstat(descriptor).st_mode
    if S_ISSOCK(mode):  # the journal of a service
        with socket.socket(fileno=os.dup(descriptor)) as peer:
            yield lambda content: peer.send(content, socket.MSG_DONTWAIT)
            return
    own = descriptor
    if S_ISFIFO(mode) or S_ISCHR(mode):
        # The flag belongs to what was opened, which other programs write to: it is opened again.
        flags = os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
        with suppress(OSError):  # a terminal of another user, or a pipe without a reader
            own = os.open(f"/proc/self/fd/{descriptor}", flags)
    try:
        yield lambda content: os.write(own, content)
    finally:
        if own != descriptor:
            os.close(own)
