"""A contact sheet: patches that show a thing clearly, and whether an encoder takes them for it."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.encoder.separation import AskedPatches
from training.evaluation import CLEARLY
from vizbot.operator.figures.image_encoding import png

COLUMNS = 12
"""Patches of a thing that are drawn at most."""
TILE = 84
"""Edge of a drawn patch [px]."""
_LABEL, _LINE, _GAP = 170, 16, 6
"""Width of the names, height of a line of text, and what is left between patches [px]."""
_DARK, _ABOVE, _BELOW = (40, 40, 46), (20, 150, 60), (215, 40, 35)


def tile_of(patch: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A patch (H, W, 3) as it is drawn, (TILE, TILE, 3)."""
    return np.asarray(cv2.resize(patch, (TILE, TILE), interpolation=cv2.INTER_AREA), np.uint8)


def contact_sheet(
    title: str,
    tiles: Sequence[NDArray[np.uint8]],
    asked: AskedPatches,
    names: Sequence[str],
    threshold: float,
) -> bytes:
    """Draw a PNG with a row for each thing that a patch shows clearly.

    Below each patch stand its similarity to the name and whether that is above even odds; patches
    are framed in green where it is, else in red.

    Args:
        title: What stands above.
        tiles: (P) patches of `tile_of`.
        asked: What the encoder said of them.
        names: The names (C,) that they were asked for.
        threshold: Similarity at even odds.
    """
    clear = [np.flatnonzero(shown >= CLEARLY) for shown in asked.shown.T]
    rows = [column for column, patches in enumerate(clear) if len(patches)]
    step = TILE + _LINE + _GAP
    sheet = np.full(
        (2 * _LINE + step * len(rows), _LABEL + COLUMNS * (TILE + _GAP), 3), 255, np.uint8
    )
    _write(sheet, f"{title}; even odds at {threshold:.2f}", (6, _LINE))
    for row, column in enumerate(rows):
        top, patches = 2 * _LINE + row * step, clear[column]
        above = asked.similarities[:, column] > threshold
        _write(sheet, names[column], (6, top + 2 * _LINE))
        _write(sheet, f"{above[patches].sum()} of {len(patches)} above", (6, top + 3 * _LINE))
        drawn = patches[np.linspace(0, len(patches) - 1, min(len(patches), COLUMNS)).astype(int)]
        for place, patch in enumerate(drawn):
            left = _LABEL + place * (TILE + _GAP)
            colour, side = (_ABOVE, "above") if above[patch] else (_BELOW, "below")
            sheet[top : top + TILE, left : left + TILE] = tiles[patch]
            cv2.rectangle(sheet, (left, top), (left + TILE - 1, top + TILE - 1), colour, 3)
            text = f"{asked.similarities[patch, column]:.2f} {side}"
            _write(sheet, text, (left, top + TILE + _LINE - 4), colour)
    return png(sheet)


def _write(
    sheet: NDArray[np.uint8],
    text: str,
    corner: tuple[int, int],
    colour: tuple[int, int, int] = _DARK,
) -> None:
    cv2.putText(sheet, text, corner, cv2.FONT_HERSHEY_SIMPLEX, 0.42, colour, 1, cv2.LINE_AA)
