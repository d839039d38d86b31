"""Results as tables in Markdown: read on a terminal as well as on a page."""

from __future__ import annotations

from collections.abc import Sequence

from vizbot.bench.harness.scores import Rate


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table whose columns are as wide as they need to be; the first one is text.

    Rates are shown in percent, None as a dash.
    """
    cells = [[_shown(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(header, *cells, strict=True)]
    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return "\n".join(_line(row, widths) for row in [list(header), rule, *cells])


def percent(value: float | None) -> str:
    """As the paper prints it."""
    return "-" if value is None else f"{100 * value:.1f}"


def named(scales: Sequence[int]) -> str:
    """A set of scales as the paper writes it."""
    return "{" + ", ".join(map(str, scales)) + "}"


def interval(rate: Rate) -> str:
    """95 % of what the true rate may be, in percent."""
    low, high = rate.interval()
    return f"{100 * low:.0f} to {100 * high:.0f}"


def counted(rate: Rate) -> str:
    """Of few, which a share would hide."""
    return f"{rate.count} of {rate.of}"


def with_interval(rate: Rate) -> str:
    """Counted, and what the true rate may be; a dash where nothing was tried."""
    return f"{counted(rate)} ({interval(rate)} %)" if rate.of else "-"


def _shown(cell: object) -> str:
    match cell:
        case None:
            return "-"
        case Rate():
            return percent(cell.value)
        case float():
            return f"{cell:.2f}"
    return str(cell).replace("|", "\\|")


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    first, *rest = zip(cells, widths, strict=True)
    padded = [first[0].ljust(first[1]), *(cell.rjust(width) for cell, width in rest)]
    return f"| {' | '.join(padded)} |"
