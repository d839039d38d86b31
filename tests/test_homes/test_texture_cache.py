"""Textures are drawn once on a machine, and again when anything that they depend on is another."""

import cv2
import numpy as np
import pytest

from sim_stubs.homes.textures import cache, canvas, finishes, patterns
from sim_stubs.homes.textures.cache import drawn_once


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty cache of the user."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "vizbot" / "textures"


@pytest.fixture
def dots():
    """A texture, and how often it was drawn."""
    drawn = []

    @drawn_once
    def dots(seed, colour, other=None):
        drawn.append(seed)
        image = np.full((4, 4, 3), np.asarray(colour) * (0.5 if other is None else 1.0))
        return canvas.saved(image * (1 + seed) / 10)

    return dots, drawn


def test_the_same_call_is_drawn_once_and_gives_the_same_file(dots):
    draw, drawn = dots
    first = draw(1, (0.1, 0.2, 0.3))
    content = first.read_bytes()
    assert draw(1, (0.1, 0.2, 0.3)) == draw(np.int64(1), np.array([0.1, 0.2, 0.3])) == first
    assert (drawn, first.read_bytes()) == ([1], content)


def test_another_argument_in_its_last_bit_is_another_call(dots):
    draw, drawn = dots
    draw(1, (0.1, 0.2, 0.3))
    draw(1, (0.1, 0.2, np.nextafter(0.3, 1)))
    draw(1, (0.1, 0.2, 0.3), (0.0, 0.0, 0.0))
    draw(2, (0.1, 0.2, 0.3))
    assert drawn == [1, 1, 1, 2]


FLOOR = ("ef0a42d420f7ce26883056fa", "379d1b7cba16e4306607b257")
"""The floor below, by processors of AMD and of Intel."""


def test_a_picture_does_not_depend_on_the_number_of_threads(tmp_path, monkeypatch):
    before, drawn = cv2.getNumThreads(), set()
    for threads in (1, 4):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / str(threads)))
        cv2.setNumThreads(threads)
        try:
            # The floor of a bathroom of home 1003, in which a pixel lies on the edge of rounding.
            light = [float.fromhex(value) for value in ("0x1.9581739c1a5c0p-1",
                     "0x1.846c2640c4743p-1", "0x1.7e47df3424b2cp-1")]  # fmt: skip
            drawn.add(patterns.tiles(48127555, light, light, 5).stem)
            assert cv2.getNumThreads() == threads
        finally:
            cv2.setNumThreads(before)
    assert len(drawn) == 1 and drawn <= {*FLOOR}


@pytest.mark.parametrize("gone", [True, False])
def test_other_sources_or_libraries_and_a_picture_that_is_gone_draw_again(dots, monkeypatch, gone):
    draw, drawn = dots
    picture = draw(1, (0.1, 0.2, 0.3))
    if gone:
        picture.unlink()
    else:
        monkeypatch.setattr(cache, "_drawing", lambda: "another")
    assert draw(1, (0.1, 0.2, 0.3)).is_file()
    assert drawn == [1, 1]


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b"../../secret.png", b"f" * 24 + b".png"])
def test_a_torn_note_is_drawn_again_and_mended(dots, folder, content):
    draw, drawn = dots
    path = draw(1, (0.1, 0.2, 0.3))
    (note,) = (folder / "drawn").iterdir()
    note.write_bytes(content)
    assert draw(1, (0.1, 0.2, 0.3)) == path
    assert note.read_text() == path.name
    assert drawn == [1, 1]


@pytest.mark.parametrize(
    ("draw", "arguments"),
    [
        (patterns.outdoors, (3,)),
        (patterns.fabric, (3, (0.4, 0.3, 0.2), (0.1, 0.1, 0.1))),
        (finishes.bricks, (3, (0.5, 0.2, 0.1), (0.8, 0.8, 0.8), 20)),
    ],
)
def test_a_texture_found_is_the_one_that_would_be_drawn(draw, arguments):
    assert [draw(*arguments) for _ in range(2)] == [draw.__wrapped__(*arguments)] * 2
