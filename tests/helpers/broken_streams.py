"""Programs whose output cannot be written."""

import os
import socket
from contextlib import contextmanager, suppress


def _closed_pipe():
    reading, writing = os.pipe()
    os.close(reading)
    return writing


def _sleeping_reader():
    """A pipe that is full and is never read; its other end stays open for as long."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    for size in (4096, 1):
        with suppress(BlockingIOError):
            while True:
                os.write(writing, b"x" * size)
    os.set_blocking(writing, True)
    _ASLEEP.append(reading)
    return writing


def _sleeping_terminal():
    """A terminal that nobody reads and that is full."""
    screen, terminal = os.openpty()
    os.set_blocking(terminal, False)
    with suppress(BlockingIOError):
        while True:
            os.write(terminal, b"x" * 64)
    os.set_blocking(terminal, True)
    _ASLEEP.append(screen)
    return terminal


def _sleeping_journal():
    """A socket whose other end is not read."""
    ours, theirs = socket.socketpair()
    ours.setblocking(False)
    for size in (4096, 1):
        with suppress(BlockingIOError):
            while True:
                ours.send(b"x" * size)
    ours.setblocking(True)
    _ASLEEP.append(theirs.detach())
    return ours.detach()


_ASLEEP = []
"""Ends that nobody reads."""
BROKEN = {
    "a closed pipe": _closed_pipe,
    "a full disk": lambda: os.open("/dev/full", os.O_WRONLY),
    "nothing": lambda: None,
}
"""What the output goes to; `nothing` is a closed descriptor."""
ASLEEP = {
    "a full pipe": _sleeping_reader,
    "a paused terminal": _sleeping_terminal,
    "a stalled journal": _sleeping_journal,
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
