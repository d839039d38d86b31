from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.helpers.boxes import askew_corners, askew_room
from tests.helpers.served import scored, step
from vizbot.core.geometry import planar
from vizbot.objectnav import reasons
from vizbot.operator.figures.panels import (
    LARGE,
    THUMBNAIL,
    TILE,
    MapView,
    candidates,
    panel,
    thumbnail,
    video_picture,
)

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


def test_a_frame_of_the_video_says_below_the_pictures_what_is_done_and_why():
    plain = replace(step(0), why="")
    drawn = video_picture(plain, NO_TRACK)
    said = {
        "what is done": replace(plain, activity="looking closer"),
        "what is enough": replace(plain, threshold=0.55),
        "why": replace(plain, why="little else is left to see; no place is worth a closer look"),
    }
    below = 2 * TILE[1]
    for name, changed in said.items():
        rows, columns = np.nonzero((video_picture(changed, NO_TRACK) != drawn)[below:].any(axis=2))
        assert len(rows), name
        assert (rows.min() > 32) == (name == "why"), "why has a line of its own"
        assert columns.max() < drawn.shape[1] - 10


def test_every_reason_fits_under_the_pictures():
    longest = f"{reasons.MOST_ALIKE}; {reasons.LESS_WORTH.format(chance='100%')}"
    lines = video_picture(replace(step(0), why=longest), NO_TRACK)[2 * TILE[1] + 34 :]
    assert (lines[:, :40] < 255).any() and (lines[:, -8:] == 255).all()


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


@pytest.mark.parametrize("name", ["obstacle map", "likeness"])
def test_a_large_map_shows_the_same_in_more_pixels(name):
    shown = asked(np.array([[0.2, 0.2, 0.5]]), [0.9], path=np.array([[0.0, 0.0], [0.4, 0.4]]))
    track = np.array([[-0.5, 0.0], [0.0, 0.0]])
    small, large = (panel(name, shown, track, 0.3, size) for size in (TILE, LARGE))
    assert large.shape == (LARGE[1], LARGE[0], 3)
    reduced = cv2.resize(large, TILE, interpolation=cv2.INTER_AREA)
    unlike = np.abs(small.astype(int) - small.mean()).mean()
    assert np.abs(reduced.astype(int) - small).mean() < 0.3 * unlike


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
    found = candidates(asked(points, np.linspace(0.4, 0.5, 9)))
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


def in_room(angle):
    """A step in a room whose walls lie askew."""
    return replace(step(0), grid=askew_room(angle), T_map_base=planar(4.0, 5.5, angle))


@pytest.mark.parametrize("angle", [0.0, 0.5, -0.7])
def test_a_turned_map_has_its_walls_upright_and_all_of_it_inside(angle):
    shown = in_room(angle)
    view = MapView.from_step(shown, angle)
    lower_left, lower_right, upper_right, upper_left = view.pixels(askew_corners(angle))
    assert abs(lower_left[1] - lower_right[1]) <= 1 and abs(upper_left[1] - upper_right[1]) <= 1
    assert abs(lower_left[0] - upper_left[0]) <= 1 and abs(lower_right[0] - upper_right[0]) <= 1
    assert lower_left[0] < lower_right[0] and upper_left[1] < lower_left[1]
    dark = panel("obstacle map", shown, NO_TRACK, angle).max(axis=2) < 100
    rows, columns = np.nonzero(dark)
    assert abs(columns.min() - lower_left[0]) < 12 and abs(columns.max() - lower_right[0]) < 12
    assert abs(rows.min() - upper_left[1]) < 12 and abs(rows.max() - lower_left[1]) < 12
    assert dark[rows.min() + 2, lower_left[0] + 5 : lower_right[0] - 5].all()
    assert dark.any(axis=0)[[0, -1]].sum() == dark.any(axis=1)[[0, -1]].sum() == 0


@pytest.mark.parametrize("angle", [0.0, 0.5, -0.7])
def test_a_pixel_of_a_turned_map_and_its_place_belong_together(angle):
    shown = in_room(angle)
    view = MapView.from_step(shown, angle)
    picture = panel("obstacle map", shown, NO_TRACK, angle)
    column, row = view.pixels(shown.T_map_base[:2, 3])
    around = picture[row - 20 : row + 21, column - 20 : column + 21].astype(int)
    assert (around[..., 0] - around[..., 1] > 100).sum() > 20
    back = view.corner + np.array([column, TILE[1] - row]) / view.scale @ view.axes
    np.testing.assert_allclose(back, shown.T_map_base[:2, 3], atol=1.0 / view.scale)
    wall = (askew_corners(angle)[0] + askew_corners(angle)[1]) / 2 - 0.05 * view.axes[1]
    assert colour_at(picture, view, wall).max() < 100
    assert colour_at(picture, view, wall + 0.4 * view.axes[1]).min() > 240


def test_a_robot_that_looks_along_the_walls_points_along_the_picture():
    shown = in_room(0.5)
    view = MapView.from_step(shown, 0.5)
    plain = panel("obstacle map", shown, NO_TRACK, 0.5).astype(int)
    column, row = view.pixels(shown.T_map_base[:2, 3])
    tip = round(0.28 * view.scale)
    reds = plain[..., 0] - plain[..., 1] > 100
    assert reds[row - 1 : row + 2, column + tip].any()
    assert not reds[row - 1 : row + 2, column - tip].any()


def test_the_likeness_is_turned_as_the_map_is():
    shown = scored(in_room(0.5), [[5.0, 4.2, 0.0], [6.0, 5.0, 0.0]], [0.9, 0.02], 0.4)
    picture, view = panel("likeness", shown, NO_TRACK, 0.5), MapView.from_step(shown, 0.5)
    red, green, blue = colour_at(picture, view, [6.0, 5.0])
    assert max(red, green, blue) - min(red, green, blue) < 60
    hot = colour_at(picture, view, [5.15, 4.05])
    assert hot[0] > hot[2] + 40


def test_a_saved_map_is_small_and_upright():
    picture = thumbnail(askew_room(0.5)).astype(int)
    assert picture.shape == (THUMBNAIL[1], THUMBNAIL[0], 3)
    dark = picture.max(axis=2) < 150
    rows, columns = np.nonzero(dark)
    assert dark[rows.min() + 1 : rows.max(), columns.min() + 1].mean() > 0.9
