"""Programs whose output cannot be written."""

import os
from contextlib import contextmanager


def _closed_pipe():
    reading, writing = os.pipe()
    os.close(reading)
    return writing


BROKEN = {
    "a closed pipe": _closed_pipe,
    "a full disk": lambda: os.open("/dev/full", os.O_WRONLY),
    "nothing": lambda: None,
}
"""What the output goes to; `nothing` is a closed descriptor."""


@contextmanager
def broken_stream(kind, number, command):
    """The file for a stream of a program, by its number, and the command to run it with."""
    file = BROKEN[kind]()
    closing = ["sh", "-c", f'exec "$@" {number}>&-', "sh"] if file is None else []
    try:
        yield file, [*closing, *command]
    finally:
        if file is not None:
            os.close(file)
