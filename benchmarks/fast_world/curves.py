"""A picture of the examined belief: reliability, and what is missed against wrong beliefs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.fast_world.examination import FALSE_SHARES

MEASURES = {"belief": "the belief", "cosine": "the best cosine"}
COLOURS = {"belief": (160, 70, 30), "cosine": (60, 130, 220)}
_TEXT, _GRID = (60, 60, 60), (225, 225, 225)
_SIZE, _EDGE = 420, 60


def draw_curves(kept: Mapping[str, Any]) -> bytes:
    """Two panels as a PNG: reliability, and what is missed against what is wrongly believed."""
    reliability = {
        key: [(each["mean"], each["share"]) for each in kept[key]["bins"]] for key in MEASURES
    }
    missed = {
        key: [(each["false"], each["missed"]) for each in kept[key]["curve"]] for key in MEASURES
    }
    held = _panel(reliability, "probability", "places where it is", 1.0)
    _line(held, [(0.0, 0.0), (1.0, 1.0)], 1.0, (150, 150, 150), 1)
    most = max(FALSE_SHARES)
    both = [
        held,
        _panel(missed, "wrong places that are believed", "missed at the first pass", most),
    ]
    return bytes(cv2.imencode(".png", np.hstack(both))[1])


def _panel(
    curves: Mapping[str, Sequence[tuple[float, float]]], across: str, up: str, reach: float
) -> NDArray[np.uint8]:
    """Curves of both measures over 0 to `reach`, in the range from 0 to 1."""
    panel = np.full((_SIZE + 2 * _EDGE, _SIZE + 2 * _EDGE, 3), 255, np.uint8)
    for tick in np.linspace(0.0, 1.0, 6):
        _line(panel, [(0.0, tick), (reach, tick)], reach, _GRID, 1)
        _line(panel, [(tick * reach, 0.0), (tick * reach, 1.0)], reach, _GRID, 1)
        (x, _), (_, y) = _at(tick * reach, 0.0, reach), _at(0.0, tick, reach)
        _write(panel, f"{tick:.0%}", (8, y + 5))
        _write(panel, f"{tick * reach:.0%}", (x - 12, _SIZE + _EDGE + 20))
    for row, (key, name) in enumerate(MEASURES.items()):
        _line(panel, curves[key], reach, COLOURS[key], 2)
        for point in curves[key]:
            cv2.circle(panel, _at(*point, reach), 4, COLOURS[key], -1, cv2.LINE_AA)
        x, y = _EDGE + _SIZE - 130, 18 + 20 * row
        cv2.circle(panel, (x - 12, y - 4), 5, COLOURS[key], -1, cv2.LINE_AA)
        _write(panel, name, (x, y))
    _write(panel, across, (_EDGE + _SIZE // 2 - 80, _SIZE + 2 * _EDGE - 12))
    _write(panel, up, (_EDGE, 24))
    return panel


def _at(x: float, y: float, reach: float) -> tuple[int, int]:
    return round(_EDGE + x / reach * _SIZE), round(_EDGE + (1.0 - y) * _SIZE)


def _line(
    panel: NDArray[np.uint8],
    points: Sequence[tuple[float, float]],
    reach: float,
    colour: tuple[int, int, int],
    width: int,
) -> None:
    pixels = np.array([_at(x, y, reach) for x, y in points], np.int32)
    cv2.polylines(panel, [pixels[:, None]], False, colour, width, cv2.LINE_AA)


def _write(panel: NDArray[np.uint8], text: str, at: tuple[int, int]) -> None:
    cv2.putText(panel, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.5, _TEXT, 1, cv2.LINE_AA)
