"""`--rerun` in a run that leaves its map for another one."""

import numpy as np
import pytest

from tests.helpers.rrd import at, rows
from tests.helpers.served import step as standing
from tests.helpers.two_maps import EMPTY, EMPTY_ON, KEPT, KEPT_ON, OLD


@pytest.mark.parametrize("then", [[EMPTY, EMPTY_ON], [KEPT, KEPT_ON]])
def test_a_run_goes_on_in_another_map(recorded, then):
    path = recorded(*OLD, *then)
    for name in ("elements", "cloud", "occupancy", "closures", "track", "path", "answers"):
        cleared = [row["step"] for row in rows(path, f"map/{name}") if "Clear:is_recursive" in row]
        assert cleared == [3], name
    places = at(path, "map/keyframes", 4)["Points3D:positions"]
    np.testing.assert_allclose(places, then[-1].keyframe_places, atol=1e-6)
    shown = at(path, "map/elements/0000", 4)["Points3D:positions"]
    np.testing.assert_allclose(shown, then[-1].points, atol=1e-5)
    assert "another map begins" in [row["TextLog:text"][0] for row in rows(path, "events")]


def test_clouds_and_track_begin_anew_with_the_map(recorded):
    path = recorded(*OLD, EMPTY, EMPTY_ON)
    clouds = [row["step"] for row in rows(path, "map/cloud/0") if row.get("Points3D:positions")]
    assert clouds == [0, 3]
    assert not [row for row in rows(path, "map/cloud/9") if row["step"] > 2]
    (track,) = at(path, "map/track/0000", 4)["LineStrips3D:strips"]
    np.testing.assert_allclose(np.array(track)[:, 0], [0.3, 0.4], atol=1e-6)


def test_the_floor_is_sent_again_though_it_is_the_same(recorded):
    path = recorded(*OLD, EMPTY)
    floors = [row["step"] for row in rows(path, "map/occupancy") if row.get("GridMap:data")]
    assert floors == [0, 3]


def test_patches_of_a_kept_map_are_not_boxed_in_pictures_of_this_run(recorded):
    path = recorded(*OLD, KEPT, KEPT_ON)
    boxed = [
        row["step"] for row in rows(path, "map/robot/camera/matches") if row.get("Boxes2D:labels")
    ]
    assert boxed == [0, 1, 2, 3]  # the last is of frame 40, which arrived a step later


def test_a_long_track_is_one_line_from_block_to_block(recorded):
    path = recorded(*[standing(index, 0.05 * index) for index in range(100)])
    lines = [at(path, f"map/track/{block:04d}", 99)["LineStrips3D:strips"][0] for block in (0, 1)]
    first, second = (np.array(line)[:, 0] for line in lines)
    np.testing.assert_allclose(first, 0.05 * np.arange(64), atol=1e-5)
    np.testing.assert_allclose(second, 0.05 * np.arange(63, 100), atol=1e-5)


def test_who_stands_draws_no_track(recorded):
    path = recorded(*[standing(index, 0.5) for index in range(5)])
    assert not rows(path, "map/track/0000")
