"""`--rerun` in a run that leaves its map for another one."""

from dataclasses import replace

import numpy as np
import pytest

from tests.rrd import at, rows
from tests.served import step as standing
from vizbot.core.geometry import planar
from vizbot.operator.map_change import MapChange
from vizbot.operator.viewer import Viewer

RNG = np.random.default_rng(0)
BOX = np.array([8, 4, 16, 12], np.int32)


def mapped(index, number, keyframes, frames, points=None, **changes):
    """A step with the frame of this number, and elements of these frames."""
    step = standing(index, 0.1 * index)
    newest = keyframes[-1]
    return replace(
        step,
        frame_number=number,
        estimate=replace(step.estimate, keyframe=newest, is_keyframe=True),
        keyframe_poses={i: planar(0.1 * i, 0.0, 0.0) for i in keyframes},
        frames=np.array(frames, np.int32),
        boxes=np.tile(BOX, (len(frames), 1)),
        points=RNG.uniform(-3, 3, (len(frames), 3)) if points is None else points,
        similarities=np.full(len(frames), 0.4, np.float32),
        **changes,
    )


POINTS = RNG.uniform(-3, 3, (40, 3))
OLD = [
    mapped(0, 0, [0], [0, 0], POINTS[:2]),
    mapped(1, 4, [0, 4], [0, 0, 4], POINTS[:3]),
    mapped(2, 9, [0, 4, 9], [0, 0, 4, 9], POINTS[:4]),
]
KEPT_FRAMES = [0, 0, 4, 9, 20, 20, 25, 31]
EMPTY = mapped(3, 0, [0], [])
KEPT = mapped(3, 40, [0, 4, 9, 30, 40], KEPT_FRAMES)
KEPT_ON = mapped(4, 41, [0, 4, 9, 30, 40], [*KEPT_FRAMES, 40], np.vstack([KEPT.points, POINTS[:1]]))


@pytest.fixture
def recorded(tmp_path):
    def record(*steps):
        with Viewer(tmp_path / "run.rrd") as viewer:
            for step in steps:
                viewer.on_step(step)
        return tmp_path / "run.rrd"

    return record


def noticed(steps):
    change = MapChange()
    return [step.index for step in steps if change.begins_with(step)]


def test_a_map_that_grows_and_is_corrected_is_the_same():
    T = planar(0.2, -0.1, 0.4)
    moved = POINTS[:4] @ T[:3, :3].T + T[:3, 3]
    assert not noticed([*OLD, replace(OLD[-1], points=moved), mapped(4, 11, [0, 4, 9, 11],
        [0, 0, 4, 9, 10, 11], np.vstack([moved, POINTS[:2]]))])  # fmt: skip


@pytest.mark.parametrize(
    "other",
    [
        EMPTY,
        KEPT,
        mapped(3, 40, [0, 4, 9], [0, 0, 4], POINTS[:3]),
        mapped(3, 40, [0, 4, 9], [0, 0, 4, 8], POINTS[:4]),
        mapped(3, 40, [0, 4], [0, 0, 4, 9], POINTS[:4]),
        mapped(3, 40, [0, 4, 9, 12], [0, 0, 4, 9], POINTS[4:8]),
        mapped(3, 2, [0, 4, 9, 12], [0, 0, 4, 9], POINTS[:4]),
    ],
    ids=["empty", "kept", "fewer", "other frames", "keyframe gone", "other places", "recounted"],
)
def test_another_map_is_noticed_once(other):
    assert noticed([*OLD, other, replace(other, index=4)]) == [3]


def test_a_kept_map_is_noticed_by_how_much_there_is_at_once():
    waiting = [mapped(0, 0, [0], []), mapped(1, 1, [0], [])]
    assert noticed([*waiting, KEPT]) == [3]


@pytest.mark.parametrize("then", [[EMPTY, mapped(4, 1, [0], [0])], [KEPT, KEPT_ON]])
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
    path = recorded(*OLD, EMPTY, mapped(4, 1, [0], [0]))
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
    path = recorded(*[standing(index, 0.02 * index) for index in range(100)])
    lines = [at(path, f"map/track/{block:04d}", 99)["LineStrips3D:strips"][0] for block in (0, 1)]
    first, second = (np.array(line)[:, 0] for line in lines)
    np.testing.assert_allclose(first, 0.02 * np.arange(64), atol=1e-5)
    np.testing.assert_allclose(second, 0.02 * np.arange(63, 100), atol=1e-5)


def test_who_stands_draws_no_track(recorded):
    path = recorded(*[standing(index, 0.5) for index in range(5)])
    assert not rows(path, "map/track/0000")
