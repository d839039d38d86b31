"""Curves over the steps of a run, ready to be drawn as SVG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT = 800, 220
"""Size of a chart with its labels [px]."""
_LEFT, _RIGHT, _TOP, _BOTTOM = 52, 12, 12, 28
_MOST_POINTS = 500
_TICKS = 5


@dataclass(frozen=True, slots=True)
class Tick:
    """A label at an axis.

    Attributes:
        position: Along the axis [px].
        text: What stands there.
    """

    position: float
    text: str


@dataclass(frozen=True, slots=True)
class Chart:
    """Some curves with one pair of axes.

    Attributes:
        curves: By name, the `points` of an SVG `polyline`, `x,y x,y ...` [px].
        across: Ticks of the steps, from left to right.
        up: Ticks of the values.
        left, right, top, bottom: Edges of the area of the curves [px].
    """

    curves: dict[str, str]
    across: list[Tick]
    up: list[Tick]
    left: int = _LEFT
    right: int = WIDTH - _RIGHT
    top: int = _TOP
    bottom: int = HEIGHT - _BOTTOM


def chart(
    steps: Sequence[int], curves: Mapping[str, Sequence[float]], *, from_zero: bool = False
) -> Chart | None:
    """Draw curves; None without two steps, or with nothing to draw.

    Args:
        steps: (N,) rising.
        curves: (N,) values each, by name; NaN leaves a step out.
        from_zero: Whether the axis includes 0.
    """
    x = np.array(steps, np.float64)
    values = {name: np.array(curve, np.float64) for name, curve in curves.items()}
    drawn = {name: curve for name, curve in values.items() if np.isfinite(curve).any()}
    if len(x) < 2 or x[-1] <= x[0] or not drawn:
        return None
    finite = np.concatenate([curve[np.isfinite(curve)] for curve in drawn.values()])
    low, high = float(finite.min()), float(finite.max())
    low = min(low, 0.0) if from_zero else low
    across, up = _ticks(x[0], x[-1], whole=True), _ticks(low, high)
    low, high = min(low, up[0]), max(high, up[-1])

    def column(steps: NDArray[np.float64]) -> NDArray[np.float64]:
        share = (steps - x[0]) / (x[-1] - x[0])
        return np.asarray(_LEFT + share * (WIDTH - _LEFT - _RIGHT))

    def row(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        share = (numbers - low) / (high - low)
        return np.asarray(HEIGHT - _BOTTOM - share * (HEIGHT - _TOP - _BOTTOM))

    lines = {}
    for name, curve in drawn.items():
        known = thinned(np.flatnonzero(np.isfinite(curve)))
        lines[name] = polyline(np.column_stack([column(x[known]), row(curve[known])]))
    return Chart(
        lines,
        [Tick(float(column(np.array(step))), f"{step:.0f}") for step in across],
        [Tick(float(row(np.array(value))), f"{value:.3g}") for value in up],
    )


def polyline(points: NDArray[np.float64]) -> str:
    """The `points` of an SVG `polyline` through (N, 2)."""
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def thinned(indices: NDArray[np.int64], most: int = _MOST_POINTS) -> NDArray[np.int64]:
    """At most `most` of the indices, evenly spread, the first and the last included."""
    if len(indices) <= most:
        return indices
    return indices[np.linspace(0, len(indices) - 1, most).round().astype(np.int64)]


def _ticks(low: float, high: float, *, whole: bool = False) -> list[float]:
    """Some five round numbers, from `low` or below it up to `high` or above it."""
    span = max(high - low, 1e-6)
    power = 10.0 ** np.floor(np.log10(span / _TICKS))
    step = next(power * factor for factor in (1, 2, 5, 10) if span / (power * factor) <= _TICKS)
    if whole:
        step = max(step, 1.0)
        first = np.ceil(low / step)
        last = np.floor(high / step)
    else:
        first, last = np.floor(low / step), np.ceil(high / step)
    return [float(i * step) for i in np.arange(first, max(last, first) + 1)]
