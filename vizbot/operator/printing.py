"""What is printed, in which no text from a file, a person or a program can steer the terminal."""

from __future__ import annotations

import logging
import re
from types import TracebackType
from typing import TypeAlias

import typer

_STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters but tab and newline, changes of direction, and halves of characters."""
_ExceptionInfo: TypeAlias = (
    tuple[type[BaseException], BaseException, TracebackType | None] | tuple[None, None, None]
)


def printable(text: str) -> str:
    r"""The same text with `\u001b` and the like for what steers a terminal; JSON stays JSON."""
    return _STEERING.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def echo(text: object, *, err: bool = False) -> None:
    """Print a line to standard output or, with `err`, to standard error."""
    typer.echo(printable(str(text)), err=err)


class PrintableFormatter(logging.Formatter):
    """Formats log records; only its format itself may steer the terminal."""

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802
        """Format the record, its message made printable."""
        record.message = printable(record.message)
        return super().formatMessage(record)

    def formatException(self, ei: _ExceptionInfo) -> str:  # noqa: N802
        """Format a traceback, made printable."""
        return printable(super().formatException(ei))
