"""`docs/results/belief.md` and its picture: whether the probabilities of places hold."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.bench.fast_world.examination import FALSE_SHARES
from vizbot.bench.harness.tables import markdown_table, percent, percent_range
from vizbot.core.files import write_whole

FILE = "examination.json"
PICTURE = "pictures/belief/curves.png"
"""The picture, from the folder of the page."""
MEASURES = {"belief": "the belief", "cosine": "the best cosine"}
_TITLE = f"""# The belief, examined

`python -m vizbot.bench.fast_world.examination VIEWS --out docs/results/rows/belief/{FILE}` takes
walks in homes on which nothing was fitted: neither the encoder, nor its threshold, nor the numbers
of the belief. The poses are true, the pictures those of the simulator. It asks the probability of
each place that was seen two things: does it hold, and does it tell a thing that the robot passes
near by (within 2 m) from what only looks like it? The best cosine of each place is asked the same;
two numbers, fitted on the homes of the belief's fit, make a probability of it (Platt 1999).

Log loss and calibration error are over all places that were seen (of 0.25 m, 40 % through each walk
and at its end). "Missed" are things that are not believed while views show them near by for the
first time, on the way past them, at the level at which so many of the three likeliest wrong places
of each walk are believed. A search looks at what is likely from more than one spot; this walk does
not."""
COLOURS = {"belief": (160, 70, 30), "cosine": (60, 130, 220)}
_TEXT, _GRID = (60, 60, 60), (225, 225, 225)
_SIZE, _EDGE = 420, 60


def belief_page(folder: Path, page: Path) -> str:
    """The page of the kept examination; empty without any.

    Args:
        folder: Folder of the kept rows.
        page: The file that the text is for.
    """
    if (kept := _kept(folder)) is None:
        return ""
    homes = f"{kept['homes'][0]} to {kept['homes'][-1]}"
    parts = [
        _TITLE,
        f"Commit {kept['commit']}, homes {homes}, {kept['passes']} first passes and"
        f" {kept['wrong_places']} wrong places; encoder {kept['encoder']}.",
        f"![Reliability, and what is missed against what is wrongly believed]({PICTURE})",
        "## Does it hold?",
        markdown_table(
            ("", "log loss", "expected calibration error"),
            [
                [name, f"{kept[key]['log_loss']:.4f}", f"{kept[key]['calibration_error']:.4f}"]
                for key, name in MEASURES.items()
            ],
        ),
        markdown_table(
            ("probability by the belief", "places where it is [%]", "places"),
            [
                [f"{each['mean']:.2f}", percent(each["share"]), each["count"]]
                for each in kept["belief"]["bins"]
            ],
        ),
        "## What is passed near by",
        markdown_table(
            (
                "wrong places that are believed [%]",
                *(f"missed by {name} [%]" for name in MEASURES.values()),
            ),
            [
                [percent(one["false"]), *(_missed(kept[key]["curve"][i]) for key in MEASURES)]
                for i, one in enumerate(kept["belief"]["curve"])
            ],
        ),
        "Intervals are 95 % over homes.",
    ]
    return "\n\n".join(parts) + "\n"


def write_belief_picture(folder: Path, page: Path) -> None:
    """Draw the picture of the page, where there is an examination."""
    if (kept := _kept(folder)) is not None:
        path = page.parent / PICTURE
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, draw_curves(kept))


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


def _missed(one: Mapping[str, Any]) -> str:
    return f"{percent(one['missed'])} ({percent_range(one['over_homes'])})"


def _kept(folder: Path) -> dict[str, Any] | None:
    path = folder / FILE
    if not path.is_file():
        return None
    kept: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return kept
