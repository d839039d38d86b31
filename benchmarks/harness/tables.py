"""Results as tables in Markdown, for terminals and pages."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.harness.scores import Rate


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table with aligned columns; the first column is text, the others are numbers.

    Rates are shown in percent, None as a dash.
    """
    # Two characters at least: a rule without a hyphen is no table.
    cells = [[_shown(cell) for cell in row] for row in rows]
    widths = [max(2, *map(len, column)) for column in zip(header, *cells, strict=True)]
    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return "\n".join(_line(row, widths) for row in [list(header), rule, *cells])


def percent(value: float | None) -> str:
    """A share in percent with one decimal, as the paper prints it; a dash for None."""
    return "-" if value is None else f"{100 * value:.1f}"


def scale_set_text(scales: Sequence[int]) -> str:
    """A set of scales as the paper writes it: {1, 0, -1}."""
    return "{" + ", ".join(map(str, scales)) + "}"


def interval_text(rate: Rate) -> str:
    """The 95 % interval of a rate in percent: 12 to 34."""
    return percent_range(rate.interval())


def percent_range(interval: tuple[float, float] | None) -> str:
    """An interval in percent: 12 to 34; a dash for None."""
    return "-" if interval is None else f"{100 * interval[0]:.0f} to {100 * interval[1]:.0f}"


def fraction_text(rate: Rate) -> str:
    """A rate as a fraction: 3 of 4."""
    return f"{rate.count} of {rate.trials}"


def fraction_with_interval(rate: Rate) -> str:
    """A rate as a fraction with its 95 % interval; a dash without trials."""
    return f"{fraction_text(rate)} ({interval_text(rate)} %)" if rate.trials else "-"


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
