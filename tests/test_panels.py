from dataclasses import replace

import numpy as np

from tests.served import step
from vizbot.operator.panels import TILE, MapView, panel

NO_TRACK = np.zeros((0, 2))


def test_what_is_more_similar_lies_above_what_is_less_wherever_they_overlap():
    rng = np.random.default_rng(3)
    points = np.column_stack([rng.uniform(-0.9, 0.9, (400, 2)), np.zeros(400)])
    scores = rng.uniform(0.0, 0.5, 400).astype(np.float32)
    shown = replace(step(0, x=5.0), points=points, similarities=scores)
    shuffled = rng.permutation(400)
    other = replace(shown, points=points[shuffled], similarities=scores[shuffled])
    np.testing.assert_array_equal(
        panel("similarity", shown, NO_TRACK), panel("similarity", other, NO_TRACK)
    )
    alone = replace(
        shown, points=points[scores > 0.45], similarities=scores[scores > 0.45]
    )  # the scale of colours begins elsewhere, the place of the best does not
    best = MapView.of(shown.grid).pixels(points[np.argmax(scores), :2])
    for picture in (panel("similarity", each, NO_TRACK) for each in (shown, alone)):
        red, green, blue = picture[best[1], best[0]].astype(int)
        assert red > green + 60 and red > blue + 60


def test_zones_are_tinted_where_they_are():
    plain = step(0)
    zone = np.array([[-0.7, 0.2], [-0.2, 0.2], [-0.2, 0.5], [-0.7, 0.5]], np.float32)
    zoned = replace(plain, grid=replace(plain.grid, zones=(zone,)))
    before, after = (panel("obstacle map", each, NO_TRACK) for each in (plain, zoned))
    changed = (before != after).any(axis=2)
    low, _, high, _ = MapView.of(plain.grid).pixels(zone)
    rows, columns = np.nonzero(changed)
    assert abs(columns.min() - low[0]) <= 1 and abs(columns.max() - high[0]) <= 1
    assert abs(rows.max() - low[1]) <= 1 and abs(rows.min() - high[1]) <= 1
    tinted = after[rows[0], columns[0]].astype(int)
    assert tinted[0] > tinted[1] + 30


def test_a_pixel_of_the_map_and_its_place_belong_together():
    view = MapView.of(step(0).grid)
    for xy in ([0.0, 0.0], [-0.7, 0.4]):
        column, row = view.pixels(np.array(xy))
        back = view.corner + np.array([column, TILE[1] - row]) / view.scale
        np.testing.assert_allclose(back, xy, atol=1.0 / view.scale)
