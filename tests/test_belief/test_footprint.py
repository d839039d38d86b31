"""Which places of the plan the patches of a frame show."""

import numpy as np
import pytest

from mapping.clip.config import ClipMapperConfig
from mapping.clip.patches import patch_boxes
from mapping.clip.places.footprint import PLACE, footprint
from vizbot.core.geometry import transform
from vizbot.core.types import Intrinsics

CAMERA = Intrinsics(640, 480, 617.0, 617.0, 319.5, 239.5)
LEVEL = np.array([[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.6], [0, 0, 0, 1]])
"""T_map_cam of a camera at the origin that looks along x."""


def boxes(scales=(1, 0, -1)):
    return patch_boxes(640, 480, ClipMapperConfig(scales=scales))


def wall(depth):
    return np.full((480, 640), depth, np.float32)


def test_a_wall_is_seen_where_it_stands():
    shown = footprint(wall(2.1), CAMERA, LEVEL, boxes())
    in_map = transform(LEVEL, shown.points_cam)
    assert len(shown.shares) > 5
    assert in_map[:, 0] == pytest.approx(2.1)
    places = np.floor(in_map[:, :2] / PLACE).astype(int)
    assert len(np.unique(places, axis=0)) == len(places)
    assert np.abs(in_map[:, 1]).max() < 1.2


def test_a_thing_before_a_wall_is_apart_from_it():
    depth = wall(3.1)
    depth[150:330, 260:380] = 1.6
    shown = footprint(depth, CAMERA, LEVEL, boxes())
    ranges = transform(LEVEL, shown.points_cam)[:, 0]
    assert {round(float(each), 1) for each in ranges} == {1.6, 3.1}


def test_false_depth_beyond_a_cameras_range_shows_no_place():
    depth = wall(3.1)
    depth[150:330, 260:380] = 12.0
    shown = footprint(depth, CAMERA, LEVEL, boxes())
    assert transform(LEVEL, shown.points_cam)[:, 0] == pytest.approx(3.1)


def test_every_place_has_the_patch_that_shows_most_of_it_and_those_around():
    shown, all_boxes = footprint(wall(2.1), CAMERA, LEVEL, boxes()), boxes()
    widths = all_boxes[:, 2] - all_boxes[:, 0]
    for point, (fine, middle, coarse) in zip(shown.points_cam, shown.patches, strict=True):
        assert (widths[fine], widths[middle], widths[coarse]) == (112, 224, 448)
        u = point[0] / point[2] * CAMERA.fx + CAMERA.cx
        assert all_boxes[fine, 0] - 60 < u < all_boxes[fine, 2] + 60
        centres = (all_boxes[[fine, middle], :2] + all_boxes[[fine, middle], 2:]) / 2
        assert np.abs(centres[0] - centres[1]).max() <= 112
    assert (shown.shares > 0.08).all() and (shown.shares <= 1.0).all()


@pytest.mark.parametrize("scales", [(0,), (1, 0)])
def test_a_missing_scale_is_stood_in_for(scales):
    shown = footprint(wall(2.1), CAMERA, LEVEL, boxes(scales))
    widths = boxes(scales)[:, 2] - boxes(scales)[:, 0]
    assert (widths[shown.patches[:, 0]] == widths.min()).all()
    assert (widths[shown.patches[:, 2]] == widths.max()).all()


def test_of_more_than_three_scales_the_coarsest_three_count():
    more, three = boxes((1, 0, -1, -2)), boxes()
    shown, expected = (footprint(wall(2.1), CAMERA, LEVEL, each) for each in (more, three))
    np.testing.assert_array_equal(shown.points_cam, expected.points_cam)
    np.testing.assert_array_equal(shown.shares, expected.shares)
    np.testing.assert_array_equal(more[shown.patches], three[expected.patches])


def test_without_depth_or_patches_nothing_is_shown():
    assert len(footprint(wall(0.0), CAMERA, LEVEL, boxes()).shares) == 0
    assert len(footprint(wall(2.0), CAMERA, LEVEL, boxes()[:0]).shares) == 0
