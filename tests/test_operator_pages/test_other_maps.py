"""What report and recording show of a run that leaves its map for another one."""

import re
from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.helpers.rrd import at, rows
from tests.helpers.served import scored
from tests.helpers.served import step as standing
from vizbot.core.geometry import planar
from vizbot.core.observer import Candidate, GoalReport, Outcome

RNG = np.random.default_rng(0)
BOX = np.array([8, 4, 16, 12], np.int32)


def mapped(index, number, keyframes, frames, points=None, map_number=0):
    """A step with the frame of this number, and elements of these frames."""
    step = standing(index, 0.1 * index)
    newest = keyframes[-1]
    points = RNG.uniform(-3, 3, (len(frames), 3)) if points is None else points
    return scored(
        step,
        points,
        np.full(len(frames), 0.4),
        frame_number=number,
        map_number=map_number,
        estimate=replace(step.estimate, keyframe=newest, is_keyframe=True),
        keyframe_poses={i: planar(0.1 * i, 0.0, 0.0) for i in keyframes},
        frames=np.array(frames, np.int32),
        boxes=np.tile(BOX, (len(frames), 1)),
    )


POINTS = RNG.uniform(-3, 3, (40, 3))
OLD = [
    mapped(0, 0, [0], [0, 0], POINTS[:2]),
    mapped(1, 4, [0, 4], [0, 0, 4], POINTS[:3]),
    mapped(2, 9, [0, 4, 9], [0, 0, 4, 9], POINTS[:4]),
]
KEPT_FRAMES = [0, 0, 4, 9, 20, 20, 25, 31]
EMPTY = mapped(3, 0, [0], [], map_number=1)
EMPTY_ON = mapped(4, 1, [0], [0], map_number=1)
KEPT = mapped(3, 40, [0, 4, 9, 30, 40], KEPT_FRAMES, map_number=1)
KEPT_ON = mapped(
    4,
    41,
    [0, 4, 9, 30, 40],
    [*KEPT_FRAMES, 40],
    np.vstack([KEPT.points, POINTS[:1]]),
    map_number=1,
)
WHITE, BLACK = np.full((24, 32, 3), 255, np.uint8), np.zeros((24, 32, 3), np.uint8)


def seen(step, rgb):
    return replace(step, frame=replace(step.frame, rgb=rgb))


def located(frame, x=0.2):
    place = Candidate(np.array([x, 0.1, 0.4]), 0.4, frame, BOX)
    return GoalReport("sofa", Outcome.LOCATED, "similar", (place,))


def proofs(report):
    """The pictures of the last answer, decoded."""
    shown = report._matches[max(report._matches)]
    return [cv2.imdecode(np.frombuffer(m.picture, np.uint8), cv2.IMREAD_COLOR) for m in shown]


OLD_WHITE = [seen(step, WHITE) for step in OLD]


def test_a_frame_of_a_new_map_is_not_shown_with_the_picture_of_the_old_one(report_of):
    first = [seen(EMPTY, BLACK), seen(EMPTY_ON, BLACK)]
    report = report_of(*OLD_WHITE, located(0), *first, located(0))
    (picture,) = proofs(report)
    assert picture[:, :5].max() < 30
    report = report_of(*OLD_WHITE, *first, located(9))
    assert not proofs(report)


def test_a_frame_of_a_kept_map_that_this_run_never_saw_has_no_picture(report_of):
    onward = [seen(KEPT, BLACK), seen(KEPT_ON, BLACK)]
    for frame in (0, 4, 9, 31):
        assert not proofs(report_of(*OLD_WHITE, *onward, located(frame)))
    assert len(proofs(report_of(*OLD_WHITE, *onward, located(40)))) == 1


@pytest.mark.slow
def test_an_answer_on_the_old_map_keeps_its_proof(report_of):
    report = report_of(*OLD_WHITE, located(9), EMPTY)
    (picture,) = proofs(report)
    assert picture[:, :5].min() > 225
    assert report.finish({}).read_text().count("was found in") == 1


def test_the_last_map_has_only_what_happened_on_it(page_of):
    page = page_of(*OLD, located(9, x=-0.5), EMPTY, EMPTY_ON, located(0))
    (track,) = re.findall(r'class="track" points="([^"]+)"', page)
    assert len(track.split()) == 2
    assert page.count('class="place"') == 1
    assert page.count("Found the sofa on the map") >= 2 and "another map begins" in page


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
    assert not rows(recorded(*[standing(index, 0.5) for index in range(5)]), "map/track/0000")
