from pathlib import Path

import cv2
import numpy as np
import pytest

from sim_stubs.homes.furniture.appearance import Appearance, appearance, colour_word
from sim_stubs.homes.furniture.shapes.curved_solids import translucent
from sim_stubs.homes.geometry.solids import Piece, box


def piece(name, *parts):
    return Piece("chair", name, np.ones(3), parts, "")


@pytest.mark.parametrize(
    ("rgb", "word"),
    [
        ((0.8, 0.08, 0.08), "red"),
        ((0.95, 0.5, 0.1), "orange"),
        ((0.95, 0.86, 0.05), "yellow"),
        ((0.05, 0.5, 0.15), "green"),
        ((0.08, 0.2, 0.75), "blue"),
        ((0.45, 0.1, 0.6), "purple"),
        ((0.9, 0.5, 0.6), "pink"),
        ((0.42, 0.27, 0.18), "brown"),
        ((0.07, 0.07, 0.08), "black"),
        ((0.5, 0.5, 0.5), "grey"),
        ((0.86, 0.87, 0.88), "white"),
        ((0.85, 0.76, 0.6), "beige"),
    ],
)
def test_colours_have_their_common_names(rgb, word):
    assert colour_word(np.array(rgb)) == word


BLACK, RED = (0.07, 0.07, 0.08), (0.8, 0.08, 0.08)
CUBE = (0, 0, 0), (1, 1, 1)
CORE = (0, 0, 0.1), (0.8, 0.8, 0.8)
PANE = translucent(box(*CUBE, (0.7, 0.8, 0.85)), 0.3)


@pytest.mark.parametrize(
    ("parts", "colour"),
    [
        ([box((0, 0, 1), (0.1, 0.1, 0.1), BLACK), box(*CUBE, RED)], "red"),
        ([*3 * [box(*CORE, BLACK)], box(*CUBE, (0.9, 0.9, 0.9))], "white"),
        ([PANE, box(*CORE, RED)], "red"),
        ([PANE], "blue"),
    ],
    ids=["a small part", "hidden inside", "behind clear glass", "clear glass alone"],
)
def test_the_largest_surface_that_is_seen_names_the_colour(parts, colour):
    assert appearance(piece("x", *parts)).colours == (colour,)


def test_two_colours_are_named_together_and_many_are_not_named():
    colours = [(0.8, 0.08, 0.08), (0.9, 0.9, 0.9), (0.08, 0.2, 0.75), (0.05, 0.5, 0.15)]
    boxes = [box((i, 0, 0), (1, 1, 1 - 0.1 * i), colour) for i, colour in enumerate(colours)]
    assert appearance(piece("x", *boxes[:2])).colours == ("red", "white")
    many = appearance(piece("x", *boxes))
    assert many.colours == ()
    assert set(many.traces) == {"red", "white", "blue", "green"}


def test_a_texture_counts_by_its_mean(tmp_path: Path):
    file = tmp_path / "texture.png"
    cv2.imwrite(str(file), np.full((4, 4, 3), (200, 40, 20), np.uint8))
    assert appearance(piece("x", box((0, 0, 0), (1, 1, 1), file))).colours == ("blue",)


def test_the_name_tells_the_material():
    body = box((0, 0, 0), (1, 1, 1), (0.42, 0.27, 0.18))
    assert appearance(piece("Oak chair", body)) == Appearance(("brown",), "wood", ("brown",))
    assert appearance(piece("Winchester sofa", body)).material == "leather"
    assert appearance(piece("Hourglass", body)).material is None
