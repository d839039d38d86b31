from dataclasses import replace

import numpy as np

from tests.helpers.served import scored, step
from vizbot.operator.figures.panels import TILE, MapView, candidates, panel

NO_TRACK = np.zeros((0, 2))


def colour_at(picture, view, xy):
    column, row = view.pixels(np.array(xy))
    return picture[row, column].astype(int)


def test_likely_places_are_red_and_unlikely_ones_pale_where_they_are():
    shown = scored(step(0), [[0.6, 0.6, 0.0], [-0.6, -0.6, 0.0]], [0.9, 0.02], 0.4)
    picture, view = panel("likeness", shown, NO_TRACK), MapView.from_step(shown)
    red, green, blue = colour_at(picture, view, [0.45, 0.45])
    assert red > green + 60 and red > blue + 60
    pale = colour_at(picture, view, [-0.6, -0.6])
    assert pale.max() - pale.min() < 60
    plain = panel("likeness", replace(shown, scores=None), NO_TRACK)
    for elsewhere in ([0.6, -0.6], [-0.3, -0.6], [-0.6, -0.3], [0.3, 0.6]):
        np.testing.assert_array_equal(
            colour_at(picture, view, elsewhere), colour_at(plain, view, elsewhere)
        )


def test_zones_are_tinted_where_they_are():
    plain = step(0)
    zone = np.array([[-0.7, 0.2], [-0.2, 0.2], [-0.2, 0.5], [-0.7, 0.5]], np.float32)
    zoned = replace(plain, grid=replace(plain.grid, zones=(zone,)))
    before, after = (panel("obstacle map", each, NO_TRACK) for each in (plain, zoned))
    changed = (before != after).any(axis=2)
    low, _, high, _ = MapView.from_step(plain).pixels(zone)
    rows, columns = np.nonzero(changed)
    assert abs(columns.min() - low[0]) <= 1 and abs(columns.max() - high[0]) <= 1
    assert abs(rows.max() - low[1]) <= 1 and abs(rows.min() - high[1]) <= 1
    tinted = after[rows[0], columns[0]].astype(int)
    assert tinted[0] > tinted[1] + 30


def test_a_pixel_of_the_map_and_its_place_belong_together():
    view = MapView.from_step(step(0))
    for xy in ([0.0, 0.0], [-0.7, 0.4]):
        column, row = view.pixels(np.array(xy))
        back = view.corner + np.array([column, TILE[1] - row]) / view.scale
        np.testing.assert_allclose(back, xy, atol=1.0 / view.scale)


def test_a_robot_that_stands_where_nothing_is_known_is_whole_in_the_picture():
    column, row = MapView.from_step(step(0, x=-2.0)).pixels(np.array([[-2.5, 0.0], [-1.5, 0.0]])).T
    assert (column >= 0).all() and (column <= TILE[0]).all()
    assert (row >= 0).all() and (row <= TILE[1]).all()


def asked(points, scores, **changes):
    """A step of a robot that is elsewhere, and looks for something with threshold 0.3."""
    return scored(step(0, x=5.0), points, scores, 0.01, **changes)


def test_candidates_are_the_best_places_above_the_threshold_apart_from_one_another():
    points = [[0.0, 0.0, 0.4], [0.9, 0.0, 0.4], [1.1, 0.0, 0.4], [-3.0, 0.0, 0.4], [0.0, 1.5, 2.0]]
    shown = asked(points, [0.5, 0.49, 0.4, 0.29, 0.6])
    np.testing.assert_allclose(candidates(shown), [[0, 1.5], [0, 0], [1.1, 0]], atol=0.01)
    assert candidates(replace(shown, threshold=0.7)).shape == (0, 2)
    assert candidates(replace(shown, scores=None)).shape == (0, 2)
    assert candidates(asked(np.zeros((0, 3)), [])).shape == (0, 2)


def test_five_candidates_at_most():
    points = np.column_stack([2.0 * np.arange(9), np.zeros((9, 2))])
    scores = np.linspace(0.4, 0.5, 9)
    found = candidates(asked(points, scores))
    np.testing.assert_allclose(found[:, 0], [16, 14, 12, 10, 8], atol=0.01)


def test_candidates_are_blue_rings_on_the_obstacle_map():
    shown = asked([[0.5, 0.3, 0.4], [-0.7, -0.5, 0.4]], [0.5, 0.4])
    picture, plain = (
        panel("obstacle map", each, NO_TRACK).astype(int)
        for each in (shown, replace(shown, scores=None))
    )
    view = MapView.from_step(shown)
    ringed = (picture != plain).any(axis=2)
    blue = picture[..., 2] - picture[..., :2].max(axis=2) > 60
    for column, row in view.pixels(candidates(shown)):
        around = slice(row - 10, row + 11), slice(column - 10, column + 11)
        assert ringed[around].any() and not ringed[row - 3 : row + 4, column - 3 : column + 4].any()
        assert blue[row, column - 7] and blue[row + 7, column]
        ringed[around] = False
    assert not ringed.any()


def test_what_is_driven_to_is_a_green_disc_in_its_ring():
    shown = asked([[0.5, 0.3, 0.4]], [0.5], target=np.array([0.5, 0.3]))
    picture = panel("obstacle map", shown, NO_TRACK).astype(int)
    ((column, row),) = MapView.from_step(shown).pixels(shown.target[None])
    red, green, blue = picture[row, column]
    assert green > red + 60 and green > blue + 60
    assert picture[row, column - 8, 2] > picture[row, column - 8, 0] + 60
