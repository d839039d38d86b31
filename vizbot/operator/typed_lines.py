"""Lines that are typed while a command runs."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator

_MOST = 4096
"""As many bytes of a line count."""


def typed_lines() -> Iterator[str]:
    """The lines of standard input without their ends, as they come.

    Nothing is buffered: a thread that waits here in Python's own buffer when the program ends
    would hold its lock, and abort the program.
    """
    begun = b""
    while read := os.read(sys.stdin.fileno(), _MOST):
        *lines, begun = (begun + read).split(b"\n")
        begun = begun[:_MOST]
        for line in lines:
            yield line.decode(errors="replace")
    if begun:
        yield begun.decode(errors="replace")
