"""Standard error that never ends a run: progress and logs are a luxury."""

from __future__ import annotations

import io
import os
import sys

_STANDARD_INPUT, _STANDARD_OUTPUT, _STANDARD_ERROR = range(3)


class LossyFile(io.FileIO):
    """A file that loses what cannot be written to it: its reader has ended, or its disk is full."""

    def write(self, content: object, /) -> int:
        """Write, and say so even where it failed."""
        view = memoryview(content)  # type: ignore[arg-type]
        try:
            return super().write(view) or len(view)
        except OSError:
            return len(view)


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
        LossyFile(_STANDARD_ERROR, "w", closefd=False),
        encoding="utf-8",
        errors="backslashreplace",
        write_through=True,
    )
