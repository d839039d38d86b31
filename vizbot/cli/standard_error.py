"""Standard error that never ends a run: progress and logs are a luxury."""

from __future__ import annotations

import io
import os
import sys

_STANDARD_INPUT, _STANDARD_ERROR = 0, 2


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
    libraries write to it: a null device takes it instead, and that of a closed standard input.
    """
    while (free := os.open(os.devnull, os.O_RDWR)) <= _STANDARD_ERROR:
        pass
    os.close(free)
    if sys.stdin is None:  # it was closed when Python started
        sys.stdin = open(_STANDARD_INPUT, encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = io.TextIOWrapper(
        LossyFile(_STANDARD_ERROR, "w", closefd=False),
        encoding="utf-8",
        errors="backslashreplace",
        write_through=True,
    )
