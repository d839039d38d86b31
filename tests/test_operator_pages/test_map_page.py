"""A saved map and its answer, drawn as a page and a picture."""

import base64
import re
from dataclasses import replace

import cv2
import numpy as np
import pytest

from mapping import map_bundle
from tests.helpers.bundles import bundle_of
from vizbot.commands.map import query, show
from vizbot.commands.options import MapQueryOptions
from vizbot.core.errors import ConfigError
from vizbot.core.place_scores import UNSEEN, PlaceScores
from vizbot.core.types import OccupancyGrid
from vizbot.operator.figures.panels import map_drawing


@pytest.fixture
def home(tmp_path, monkeypatch, mean_colours):
    monkeypatch.setattr("vizbot.rig.require_encoder", lambda *_: None)
    monkeypatch.setattr("vizbot.rig.open_encoder", lambda *_: mean_colours)
    map_bundle.save(replace(bundle_of(), model_id=mean_colours.model_id), tmp_path / "home")
    return tmp_path / "home"


def page_of(folder):
    assert sorted(path.name for path in folder.iterdir()) == ["index.html", "map.png"]
    return (folder / "index.html").read_text()


def test_an_answer_is_drawn_with_its_places_in_order(home, tmp_path, capsys):
    query(MapQueryOptions(home, "red", out=tmp_path / "drawn", as_json=True))
    page = page_of(tmp_path / "drawn")
    numbers = re.findall(r"<tr(?: class=\"quiet\")?><td>(\d+)</td>", page)
    assert numbers == [str(number) for number in range(1, len(numbers) + 1)] and numbers
    [embedded] = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    assert base64.b64decode(embedded) == (tmp_path / "drawn" / "map.png").read_bytes()
    assert "Maps hold no pictures" in page and "https://" not in page and "<script" not in page


def test_a_map_is_drawn_without_a_question(home, tmp_path):
    show(home, tmp_path / "plan")
    page = page_of(tmp_path / "plan")
    assert "What the map shows" in page and "<table" not in page


def test_what_cannot_be_drawn_is_refused_before_the_map_is_read(tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "letter").write_text("dear")
    for refuse in (
        lambda: show(tmp_path / "nowhere", tmp_path / "full"),
        lambda: query(MapQueryOptions(tmp_path / "nowhere", "red", out=tmp_path / "full")),
    ):
        with pytest.raises(ConfigError, match="full is not a new or empty folder"):
            refuse()
    with pytest.raises(ConfigError, match="--method paper has no probabilities to draw"):
        query(MapQueryOptions(tmp_path / "nowhere", "red", method="paper", out=tmp_path / "drawn"))
    assert [path.name for path in tmp_path.iterdir()] == ["full"]


def test_the_likeliest_place_is_the_reddest_and_has_its_number():
    occupancy = np.full((60, 80), 0.1, np.float32)
    grid = OccupancyGrid(occupancy, 0.05, np.zeros(2))
    values = np.full((12, 16), UNSEEN, np.float32)
    values[2, 3], values[8, 12] = 1.0, 0.05
    scores = PlaceScores(np.zeros(2, np.int64), 0.25, values)
    plain = map_drawing(grid, None, np.zeros((0, 2)), [])
    drawn = map_drawing(grid, scores, np.zeros((0, 2)), [])
    numbered = map_drawing(grid, scores, np.array([[0.875, 0.625]]), [("kitchen", (2.0, 1.5))])
    assert plain.shape == drawn.shape == numbered.shape
    assert (plain[:1000, :, 0] == plain[:1000, :, 2]).all(), "shades of grey, above the bar"
    redness = drawn[..., 0].astype(int) - drawn[..., 2]
    row, column = np.unravel_index(redness.argmax(), redness.shape)
    assert column < drawn.shape[1] / 2 and row > drawn.shape[0] / 2, "south-west, rows go down"
    changed = cv2.absdiff(drawn, numbered).max(axis=2) > 40
    assert changed[row - 20 : row + 20, column - 20 : column + 20].any()
