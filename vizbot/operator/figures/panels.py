"""The four pictures of the paper's figure 4, drawn from one step: what a person sees of a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.clip.retrieval import best
from vizbot.core.observer import Step
from vizbot.core.place_scores import UNSEEN, PlaceScores
from vizbot.core.types import OccupancyGrid
from vizbot.operator.figures.colour_scale import painted
from vizbot.operator.figures.wall_direction import wall_direction

TILE = (480, 360)
"""Width and height of one picture [px]."""
LARGE = (960, 720)
"""Those of a map that people may enlarge [px]."""
PRINTED = (1920, 1440)
"""Those of a map that is drawn for a page or a paper, before its empty border is cut off [px]."""
THUMBNAIL = (160, 120)
"""Width and height of the picture of a saved map [px]."""
NAMES = ("colour", "depth", "obstacle map", "likeness")
_MARGIN = 0.5
_FAR = 5.0
_RED, _GREEN, _DARK = (205, 45, 40), (30, 150, 60), (40, 40, 46)
_BLUE = (60, 110, 220)
_CANDIDATES, _APART = 5, 1.0
"""How many candidates are drawn at most, and how far apart they are at least [m]."""
_LEAST_COVER = 0.25
"""How much of the floor plan the colour of the least likely place covers."""
Image = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class MapView:
    """Where `map` lies in a picture: the robot and all that is known inside.

    Attributes:
        corner: (2,) x, y in `map` of the picture's lower left corner [m].
        scale: Pixels for one metre.
        turn: Direction of the picture's rows in `map`, counterclockwise from x [rad].
        size: Width and height of the picture [px], a multiple of `TILE`.
    """

    corner: NDArray[np.float64]
    scale: float
    turn: float = 0.0
    size: tuple[int, int] = TILE

    @staticmethod
    def from_step(step: Step, turn: float = 0.0, size: tuple[int, int] = TILE) -> MapView:
        """The view of the known cells of a step's grid, and of the robot."""
        return MapView.of_grid(step.grid, step.T_map_base[:2, 3][None], turn, size)

    @staticmethod
    def of_grid(
        grid: OccupancyGrid,
        places: NDArray[np.float64],
        turn: float,
        size: tuple[int, int] = TILE,
    ) -> MapView:
        """The view of the known cells of a grid, and of places (N, 2) x, y in `map` [m]."""
        axes = _axes(turn)
        shown = np.vstack([grid.to_xy(_outline(grid)), places]) @ axes.T
        low, high = shown.min(axis=0) - _MARGIN, shown.max(axis=0) + _MARGIN
        scale = float((np.array(size) / (high - low)).min())
        return MapView((low + high - np.array(size) / scale) / 2 @ axes, scale, turn, size)

    @property
    def stroke(self) -> int:
        """Width of a thin line, of which all that is drawn in the picture is a multiple [px]."""
        return self.size[0] // TILE[0]

    @property
    def axes(self) -> NDArray[np.float64]:
        """Directions (2, 2) in `map` of the picture's right and of its upper side."""
        return _axes(self.turn)

    def pixels(self, xy: NDArray[np.float64]) -> NDArray[np.int32]:
        """Pixels (..., 2) column, row of points (..., 2) x, y in `map` [m]."""
        uv = (xy - self.corner) @ self.axes.T * self.scale
        return np.stack([uv[..., 0], self.size[1] - uv[..., 1]], axis=-1).round().astype(np.int32)


def _axes(turn: float) -> NDArray[np.float64]:
    cos, sin = math.cos(turn), math.sin(turn)
    return np.array([[cos, sin], [-sin, cos]])


def _outline(grid: OccupancyGrid) -> NDArray[np.int64]:
    """Known cells (N, 2) row, col that reach farthest in any direction; else the grid's corners."""
    known = grid.occupancy != 0.5
    rows = np.flatnonzero(known.any(axis=1))
    if len(rows) == 0:
        bottom, right = np.array(known.shape) - 1
        return np.array([[0, 0], [0, right], [bottom, 0], [bottom, right]])
    first = known[rows].argmax(axis=1)
    last = known.shape[1] - 1 - known[rows, ::-1].argmax(axis=1)
    return np.column_stack([np.tile(rows, 2), np.concatenate([first, last])])


def panels(step: Step, track: NDArray[np.float64]) -> dict[str, Image]:
    """Colour, depth, obstacle map and likeness map; `track` (N, 2) is x, y in `map` [m].

    Returns:
        RGB pictures of `TILE` size by name.
    """
    return {name: panel(name, step, track) for name in NAMES}


def panel(
    name: str,
    step: Step,
    track: NDArray[np.float64],
    turn: float = 0.0,
    map_size: tuple[int, int] = TILE,
) -> Image:
    """Draw one of them.

    Args:
        name: One of `NAMES`.
        step: What to draw.
        track: (N, 2) x, y of the base so far in `map` [m].
        turn: Direction of the rows of maps in `map`, counterclockwise from x [rad].
        map_size: Width and height of maps [px], a multiple of `TILE`.
    """
    match name:
        case "colour":
            resized = cv2.resize(step.frame.rgb, TILE, interpolation=cv2.INTER_AREA)
            return np.asarray(resized, np.uint8)
        case "depth":
            return _depth(step.frame.depth)
        case "obstacle map":
            return _obstacle_map(step, track, MapView.from_step(step, turn, map_size))
    return _likeness_map(step, MapView.from_step(step, turn, map_size))


def thumbnail(grid: OccupancyGrid) -> Image:
    """The floor plan of a saved map, of `THUMBNAIL` size."""
    view = MapView.of_grid(grid, np.zeros((0, 2)), wall_direction(grid) or 0.0)
    plan = _floor_plan(grid, view)
    return np.asarray(cv2.resize(plan, THUMBNAIL, interpolation=cv2.INTER_AREA), np.uint8)


def map_drawing(
    grid: OccupancyGrid,
    scores: PlaceScores | None,
    places_xy: NDArray[np.float64],
    rooms: Sequence[tuple[str, tuple[float, float]]],
) -> Image:
    """A saved map from above, upright along its walls, for a page or a paper.

    Args:
        grid: The obstacle map with its zones.
        scores: What the places of the plan are coloured by, 0 to 1; None for the map alone.
        places_xy: (N, 2) x, y in `map` of places that get the numbers from 1 on [m].
        rooms: Names of rooms, each with x, y of its middle [m].
    """
    view = MapView.of_grid(grid, places_xy, wall_direction(grid) or 0.0, PRINTED)
    picture, thin = _floor_plan(grid, view), view.stroke
    if scores is not None:
        picture = (picture // 2 + 127).astype(np.uint8)
        _paint(picture, scores, view, 0.0, 1.0)
    for name, middle in rooms:
        _write_centred(picture, name, _point(view, np.array(middle)), 0.4 * thin, _DARK)
    for number, place_xy in enumerate(places_xy, 1):
        at = _point(view, place_xy)
        cv2.circle(picture, at, 9 * thin, (255, 255, 255), -1, cv2.LINE_AA)
        cv2.circle(picture, at, 9 * thin, _DARK, thin, cv2.LINE_AA)
        _write_centred(picture, str(number), at, 0.4 * thin, _DARK)
    return _with_scale_bar(_cropped(picture, grid, places_xy, view), view)


def _cropped(
    picture: Image, grid: OccupancyGrid, places_xy: NDArray[np.float64], view: MapView
) -> Image:
    """The part of a picture that shows known cells and places, with a margin."""
    shown = view.pixels(np.vstack([grid.to_xy(_outline(grid)), places_xy]))
    margin = round(_MARGIN * view.scale)
    low = np.maximum(shown.min(axis=0) - margin, 0)
    high = np.minimum(shown.max(axis=0) + margin, view.size)
    return picture[low[1] : high[1], low[0] : high[0]]


def _with_scale_bar(picture: Image, view: MapView) -> Image:
    """A picture above a bar that is one metre long, or five on a large map."""
    metres = 1 if view.scale * 5 > picture.shape[1] / 3 else 5
    thin, length = view.stroke, round(metres * view.scale)
    foot = np.full((24 * thin, picture.shape[1], 3), 255, np.uint8)
    middle = 12 * thin
    ends = ((10 * thin, middle), (10 * thin + length, middle))
    cv2.line(foot, *ends, _DARK, 2 * thin)
    for column, _ in ends:
        cv2.line(foot, (column, middle - 4 * thin), (column, middle + 4 * thin), _DARK, thin)
    corner = (ends[1][0] + 6 * thin, middle + 4 * thin)
    font = cv2.FONT_HERSHEY_SIMPLEX
    cv2.putText(foot, f"{metres} m", corner, font, 0.4 * thin, _DARK, thin // 2, cv2.LINE_AA)
    return np.vstack([picture, foot])


def video_picture(step: Step, track: NDArray[np.float64]) -> Image:
    """The four pictures as one, above what is done and why: a frame of the run's video."""
    a, b, c, d = (_titled(name, picture) for name, picture in panels(step, track).items())
    pictures = np.vstack([np.hstack([a, b]), np.hstack([c, d])])
    lines = np.full((64, pictures.shape[1], 3), 255, np.uint8)
    text = f"{step.index:4d}  {step.goal}  |  {step.activity}"
    if step.shown_score is not None:
        score, enough = map(step.measure.text, (step.shown_score, step.threshold))
        text += f"  |  {step.measure} {score} (enough: {enough})"
    _write(lines, text, (10, 24), 0.55)
    _write(lines, step.why, (10, 50), 0.55)
    return np.vstack([pictures, lines])


def _depth(depth: NDArray[np.float32]) -> Image:
    near = (255 * (1.0 - np.clip(depth / _FAR, 0.0, 1.0))).astype(np.uint8)
    coloured = cv2.cvtColor(cv2.applyColorMap(near, cv2.COLORMAP_VIRIDIS), cv2.COLOR_BGR2RGB)
    coloured[depth <= 0.0] = 0
    return np.asarray(cv2.resize(coloured, TILE, interpolation=cv2.INTER_NEAREST), np.uint8)


def candidates(step: Step) -> NDArray[np.float64]:
    """Where the goal may be: the places with the highest scores, at least 1 m apart.

    Returns:
        (C, 2) x, y in `map` [m], best first, at most 5; none without a goal, or with nothing above
        the threshold.
    """
    if step.scores is None:
        return np.zeros((0, 2))
    found = np.nonzero(step.scores.values > step.threshold)
    places_xy, scores = step.scores.xy(*found), step.scores.values[found]
    return np.asarray(places_xy[best(scores, places_xy, _CANDIDATES, _APART)])


def known_cells(grid: OccupancyGrid, margin: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The first known cell (row, col) and one past the last; all cells if none is known.

    `margin` is the width of the border around it that counts, too [m].
    """
    known, shape = grid.occupancy != 0.5, np.array(grid.occupancy.shape)
    if not known.any():
        return np.zeros(2, np.int64), shape
    spans = [np.flatnonzero(known.any(axis=axis)) for axis in (1, 0)]
    around = int(np.ceil(margin / grid.resolution))
    first = np.array([span[0] for span in spans]) - around
    last = np.array([span[-1] for span in spans]) + 1 + around
    return np.maximum(first, 0), np.minimum(last, shape)


def shaded(grid: OccupancyGrid) -> Image:
    """Shades (rows, cols) of the cells: free is white, unknown grey, occupied dark."""
    known = np.where(grid.occupancy < 0.5, 255, 60)
    return np.where(grid.occupancy == 0.5, 205, known).astype(np.uint8)


def _floor_plan(grid: OccupancyGrid, view: MapView) -> Image:
    """The cells in shades; keep-out zones are tinted red."""
    plan = _drawn(shaded(grid), grid.to_xy(np.zeros(2, np.int64)), grid.resolution, view, 205.0)
    picture = np.repeat(plan[..., None], 3, axis=2)
    zones = np.zeros(plan.shape, np.uint8)
    for zone in grid.zones:
        cv2.fillPoly(zones, [view.pixels(zone.astype(np.float64))], 1)
    tinted = 0.6 * picture[zones > 0] + 0.4 * np.array(_RED)
    picture[zones > 0] = tinted.astype(np.uint8)
    return np.asarray(picture, np.uint8)


def _obstacle_map(step: Step, track: NDArray[np.float64], view: MapView) -> Image:
    """Robot and trajectory in red, path and goal in green, as in the paper's figure 4.

    Blue rings are around the candidates.
    """
    picture, thin = _floor_plan(step.grid, view), view.stroke
    if len(track):
        cv2.polylines(picture, [view.pixels(track)], False, _RED, thin, cv2.LINE_AA)
    if step.path is not None and len(step.path):
        cv2.polylines(picture, [view.pixels(step.path)], False, _GREEN, 2 * thin, cv2.LINE_AA)
    for place in candidates(step):
        cv2.circle(picture, _point(view, place), 7 * thin, _BLUE, 2 * thin, cv2.LINE_AA)
    if step.target is not None:
        cv2.circle(picture, _point(view, step.target), 6 * thin, _GREEN, -1, cv2.LINE_AA)
    _draw_robot(picture, step, view)
    return picture


def _likeness_map(step: Step, view: MapView) -> Image:
    """Places coloured from the lowest to the highest score; a ring around the best."""
    picture = _floor_plan(step.grid, view) // 2 + 127
    picture = picture.astype(np.uint8)
    if step.scores is not None and step.best_score is not None:
        scores, values = step.scores, step.scores.values
        low, high = values[values > UNSEEN].min(), max(step.best_score, step.threshold)
        _paint(picture, scores, view, float(low), float(high))
        row, column = np.unravel_index(np.argmax(values), values.shape)
        best_xy = scores.xy(np.array([row]), np.array([column]))[0]
        thin = view.stroke
        cv2.circle(picture, _point(view, best_xy), 8 * thin, _DARK, 2 * thin, cv2.LINE_AA)
    _draw_robot(picture, step, view)
    return picture


def _paint(picture: Image, scores: PlaceScores, view: MapView, low: float, high: float) -> None:
    """Colour the places that were seen, from the score `low` to the score `high`."""
    first_xy = scores.xy(np.zeros(1, np.int64), np.zeros(1, np.int64))[0]
    drawn = _drawn(scores.values, first_xy, scores.size, view, UNSEEN)
    shown = drawn > UNSEEN
    levels = (drawn[shown] - low) / max(high - low, 1e-6)
    cover = (_LEAST_COVER + (1.0 - _LEAST_COVER) * levels)[:, None]
    picture[shown] = (cover * painted(levels) + (1.0 - cover) * picture[shown]).astype(np.uint8)


def _drawn(
    cells: NDArray[Any], first_xy: NDArray[np.float64], size: float, view: MapView, around: float
) -> NDArray[Any]:
    """Cells of the plan as a picture; shades are smoothed where it is turned.

    Args:
        cells: (rows, cols) values.
        first_xy: (2,) middle of the first one, in `map` [m].
        size: Edge of a cell [m].
        view: Where `map` lies in the picture.
        around: Value outside of all cells.
    """
    edge = size * view.scale
    left, below = view.axes @ (first_xy - view.corner) * view.scale
    right, up = edge * view.axes
    cells_to_pixels = np.array([[*right, left], [*-up, view.size[1] - below]])
    shades = cells.dtype == np.uint8  # scores lie beside what is no score
    how = cv2.INTER_LINEAR if shades and view.turn else cv2.INTER_NEAREST
    return np.asarray(
        cv2.warpAffine(cells, cells_to_pixels, view.size, flags=how, borderValue=(around,))
    )


def _draw_robot(picture: Image, step: Step, view: MapView) -> None:
    xy, ahead = step.T_map_base[:2, 3], step.T_map_base[:2, 0]
    width = 2 * view.stroke
    radius = max(3 * view.stroke, round(0.175 * view.scale))
    cv2.circle(picture, _point(view, xy), radius, _RED, width, cv2.LINE_AA)
    cv2.line(picture, _point(view, xy), _point(view, xy + 0.3 * ahead), _RED, width, cv2.LINE_AA)


def _point(view: MapView, xy: NDArray[np.float64]) -> tuple[int, int]:
    column, row = view.pixels(xy)
    return int(column), int(row)


def _titled(name: str, picture: Image) -> Image:
    titled = picture.copy()
    titled[:28] = 255
    _write(titled, name, (10, 20), 0.5)
    return titled


def _write_centred(
    picture: Image, text: str, middle: tuple[int, int], size: float, colour: tuple[int, int, int]
) -> None:
    """Write a text around a pixel, with a light edge so that it reads on dark ground."""
    font, width = cv2.FONT_HERSHEY_SIMPLEX, max(1, round(2.5 * size))
    (across, up), _ = cv2.getTextSize(text, font, size, width)
    corner = middle[0] - across // 2, middle[1] + up // 2
    for shade, stroke in (((255, 255, 255), 4 * width), (colour, width)):
        cv2.putText(picture, text, corner, font, size, shade, stroke, cv2.LINE_AA)


def _write(picture: Image, text: str, corner: tuple[int, int], size: float) -> None:
    cv2.putText(picture, text, corner, cv2.FONT_HERSHEY_SIMPLEX, size, _DARK, 1, cv2.LINE_AA)
