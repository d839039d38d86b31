"""Programs whose output cannot be written."""

import os
import socket
from contextlib import contextmanager, suppress


def _closed_pipe():
    reading, writing = os.pipe()
    os.close(reading)
    return writing


def _filled(asleep, writing):
    """An end that takes nothing more, for nobody reads the other; that stays open for as long."""
    os.set_blocking(writing, False)
    for size in (4096, 64, 1):
        with suppress(BlockingIOError):
            while True:
                os.write(writing, b"x" * size)
    os.set_blocking(writing, True)
    _ASLEEP.append(asleep)
    return writing


_ASLEEP = []
"""Ends that nobody reads."""
BROKEN = {
    "a closed pipe": _closed_pipe,
    "a full disk": lambda: os.open("/dev/full", os.O_WRONLY),
    "nothing": lambda: None,
}
"""What the output goes to; `nothing` is a closed descriptor."""
ASLEEP = {
    "a full pipe": lambda: _filled(*os.pipe()),
    "a paused terminal": lambda: _filled(*os.openpty()),
    "a stalled journal": lambda: _filled(*(end.detach() for end in socket.socketpair())),
}
"""What takes nothing more, and says so only to who asks."""


@contextmanager
def broken_stream(kind, number, command):
    """The file for a stream of a program, by its number, and the command to run it with."""
    file = (BROKEN | ASLEEP)[kind]()
    closing = ["sh", "-c", f'exec "$@" {number}>&-', "sh"] if file is None else []
    try:
        yield file, [*closing, *command]
    finally:
        if file is not None:
            os.close(file)
        while _ASLEEP:
            os.close(_ASLEEP.pop())
