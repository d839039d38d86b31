"""The map at the end of a run and what happened on it, ready to be drawn as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import GoalReport, Outcome, Step
from vizbot.operator.figures.image_encoding import data_uri, png
from vizbot.operator.figures.panels import known_cells, shaded
from vizbot.operator.report.chart import polyline, thinned

_PIXELS = 100.0
"""Scale of the drawing [px/m]."""
_MARGIN = 0.3
"""Around the known cells [m]."""
_MOST_POINTS = 4000
_FOUND = (Outcome.ARRIVED, Outcome.LOCATED)


@dataclass(frozen=True, slots=True)
class MapMarker:
    """A point with a name.

    Attributes:
        x: [px]
        y: [px], down.
    """

    x: float
    y: float
    text: str


@dataclass(frozen=True, slots=True)
class MapFigure:
    """All in pixels of the drawing, y down.

    Attributes:
        width: Of the drawing [px].
        height: Of the drawing [px].
        floor: The obstacle map, a picture of that size, as a data URI.
        track: Where the base drove, as the `points` of an SVG `polyline`.
        keyframes: Where the keyframes were taken.
        closures: x, y, x, y of the keyframes that each closed loop joins.
        frontiers: Those of the last search for frontiers.
        start: Where the base began.
        end: Where it is.
        answers: The best place for each goal that was found.
    """

    width: float
    height: float
    floor: str
    track: str
    keyframes: list[MapMarker]
    closures: list[tuple[float, float, float, float]]
    frontiers: list[MapMarker]
    start: MapMarker
    end: MapMarker
    answers: list[MapMarker]


def run_map(step: Step, track: NDArray[np.float64], reports: Sequence[GoalReport]) -> MapFigure:
    """Draw the last step of a run.

    `track` (N, 2) is x, y of the base in `map` [m]; `reports` are of all goals asked for on this
    map.
    """
    grid = step.grid
    first, last = known_cells(grid, _MARGIN)
    low = grid.origin + grid.resolution * first[::-1]
    size = grid.resolution * (last - first)[::-1]
    shade = shaded(grid)[first[0] : last[0], first[1] : last[1]]

    def pixels(xy: NDArray[np.float64]) -> NDArray[np.float64]:
        offset = (xy - low) * _PIXELS
        return np.stack([offset[..., 0], size[1] * _PIXELS - offset[..., 1]], axis=-1)

    def markers(xy: NDArray[np.float64], texts: Sequence[str]) -> list[MapMarker]:
        points = zip(pixels(xy).tolist(), texts, strict=True)
        return [MapMarker(x, y, text) for (x, y), text in points]

    found = [report for report in reports if report.candidates and report.outcome in _FOUND]
    answers = np.array([report.candidates[0].position[:2] for report in found]).reshape(-1, 2)
    start, end = markers(track[[0, -1]], ["start", "end"])
    ids = [f"keyframe {i}" for i in sorted(step.keyframe_poses)]
    closures = pixels(step.closure_ends[..., :2]).reshape(-1, 4).tolist()
    return MapFigure(
        width=float(size[0] * _PIXELS),
        height=float(size[1] * _PIXELS),
        floor=data_uri("image/png", png(np.ascontiguousarray(shade[::-1]))),
        track=polyline(pixels(track[thinned(np.arange(len(track)), _MOST_POINTS)])),
        keyframes=markers(step.keyframe_places[:, :2], ids),
        closures=[(a, b, c, d) for a, b, c, d in closures],
        frontiers=markers(step.frontiers, ["frontier"] * len(step.frontiers)),
        start=start,
        end=end,
        answers=markers(answers, [report.text for report in found]),
    )
