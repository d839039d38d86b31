"""Questions to the map of a recording: where marks lie, what counts as right, what is refused."""

import json

import cv2
import numpy as np
import pytest

from benchmarks.harness.store import Store
from benchmarks.questions import bench
from benchmarks.questions.bench import (
    MarkedAnswer,
    RecordingAnswers,
    questions_page,
    questions_result,
)
from benchmarks.questions.marks import MarkedPlaces, places_of, read_questions
from benchmarks.questions.poses import estimated_poses, poses_at, recorded_poses, told_poses
from drivers.tum_sequence import RecordedSequence
from mapping.keyframes.config import KeyframeConfig
from mapping.slam.config import SlamConfig
from mapping.tum import write_trajectory
from tests.helpers.checkout import ROOT
from tests.test_benchmarks.printed_table import rows_in
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import camera_mount, invert, planar, yaw_of

FX = 150.0
MARK = '[[question]]\ntext = "sofa"\nmarks = [{{frame = {}, pixel = [80, 60]}}]\n'
FRAMES = {"hololens_office": 373, "nyu_cafe": 782, "tum_fr1_rpy": 694}
"""Frames of each recording that is marked."""


@pytest.fixture
def recording(tmp_path):
    """Two frames of a wall 2 m ahead, 1 m apart along x, with a hole in the depth of the first."""
    folder = tmp_path / "walk"
    folder.mkdir()
    for i in range(2):
        depth = np.full((120, 160), 2000, np.uint16)
        depth[:, :20] = 0
        cv2.imwrite(str(folder / f"{i}.png"), np.full((120, 160, 3), 90, np.uint8))
        cv2.imwrite(str(folder / f"{i}d.png"), depth)
    (folder / "associations.txt").write_text("0 0.png 0 0d.png\n1 1.png 1 1d.png\n")
    camera = {"width": 160, "height": 120, "fx": FX, "fy": FX, "cx": 80.0, "cy": 60.0}
    (folder / "camera.json").write_text(json.dumps(camera | {"depth_scale": 1000}))
    poses = np.array([planar(0.0, 0.0, 0.0), planar(1.0, 0.0, 0.0)])
    write_trajectory(folder / "groundtruth.txt", np.arange(2.0), poses)
    return folder


def questions(tmp_path, text):
    path = tmp_path / "questions.toml"
    path.write_text(text)
    return path


def places(recording, path):
    poses = np.array([planar(0.0, 0.0, 0.0), planar(1.0, 0.0, 0.0)])
    with RecordedSequence(recording) as camera:
        return places_of(camera, read_questions(path), poses)


def test_a_mark_is_where_the_pixel_was_seen(recording, tmp_path):
    path = questions(
        tmp_path,
        '[[question]]\ntext = "sofa"\nmarks = [{frame = 0, pixel = [95, 60]},'
        ' {frame = 1, pixel = [80, 30]}]\n[[question]]\ntext = "dog"\n',
    )
    sofa, dog = places(recording, path)
    np.testing.assert_allclose(sofa.points, [[2 * 15 / FX, 0.0, 2.0], [1.0, -2 * 30 / FX, 2.0]])
    assert dog.points.shape == (0, 3) and dog.nearest(np.zeros(3)) is None


def test_right_is_half_the_way_to_another_thing_and_between_both_bounds(recording, tmp_path):
    # A metre is 75 px: the table is 1 m beside the lamp, and the vase 0.2 m.
    path = questions(
        tmp_path,
        '[[question]]\ntext = "lamp"\nmarks = [{frame = 0, pixel = [40, 60]}]\n'
        '[[question]]\ntext = "table"\nmarks = [{frame = 0, pixel = [115, 60]},'
        " {frame = 1, pixel = [150, 60]}]\n"
        '[[question]]\ntext = "vase"\nmarks = [{frame = 0, pixel = [40, 75]}]\n',
    )
    lamp, table, vase = places(recording, path)
    assert [*lamp.tolerances, *vase.tolerances] == [0.25, 0.25]
    np.testing.assert_allclose(table.tolerances, [0.5, 0.75], atol=0.02)


def test_the_mark_with_which_a_point_is_right_decides():
    places = MarkedPlaces(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), np.array([0.25, 0.75]))
    assert places.nearest(np.array([0.4, 0.0, 0.0])) == pytest.approx((0.6, 0.75))
    xy = np.array([[0.2, 0.0], [-0.3, 0.0], [0.3, 0.0], [1.8, 0.0]])
    assert places.on_plan(xy).tolist() == [True, False, True, False]


@pytest.mark.parametrize(
    ("mark", "said"),
    [
        ("{frame = 2, pixel = [80, 60]}", "in none of the 2 frames"),
        ("{frame = 0, pixel = [160, 60]}", "outside of the picture of 160 x 120"),
        ("{frame = 0, pixel = [80, -1]}", "outside of the picture"),
        ("{frame = 0, pixel = [3, 60]}", "has no depth"),
    ],
)
def test_a_mark_that_is_nowhere_is_refused_by_its_question(recording, tmp_path, mark, said):
    path = questions(tmp_path, f'[[question]]\ntext = "sofa"\nmarks = [{mark}]\n')
    with pytest.raises(ConfigError, match=f"question 'sofa'.*{said}"):
        places(recording, path)


@pytest.mark.parametrize(
    "text", ["", "[[question]]\n", '[[question]]\ntext = ""\n', "[[question]\n", "question = 3\n"]
)
def test_a_spoilt_list_of_questions_is_refused_with_its_name(tmp_path, text):
    with pytest.raises(ConfigError, match=r"questions .*questions\.toml cannot be read"):
        read_questions(questions(tmp_path, text))


@pytest.mark.parametrize("path", sorted((ROOT / "docs/results/questions").glob("*.toml")))
def test_what_is_marked_in_a_real_recording_can_be_asked(path):
    asked = read_questions(path)
    assert len({question.text for question in asked}) == len(asked)
    assert sum(bool(question.marks) for question in asked) >= 15
    assert sum(not question.marks for question in asked) == 8
    for question in asked:
        assert len(set(question.marks)) == len(question.marks), question.text
        for mark in question.marks:
            (u, v), where = mark.pixel, (question.text, mark)
            assert mark.frame < FRAMES[path.stem], where
            assert 0 <= u < 640 and 0 <= v < 480, where


def answer(text, score, distance, exists=True):
    return MarkedAnswer(text, exists, score, 0.5, distance, 0.75, 0.125 * exists)


ANSWERS = (
    answer("sofa", 0.6, 0.75),
    answer("chair", 0.5, 0.1),
    answer("door", 0.9, 0.76),
    answer("cup", None, None),
    answer("dog", 0.51, None, exists=False),
    answer("cat", 0.5, None, exists=False),
)


def answers_of(recording, model, kind="probability"):
    return RecordingAnswers(recording, model, "a toy", 2, kind, ANSWERS, False, 0)


def test_right_is_within_the_radius_and_believed_is_over_the_threshold():
    assert [a.right for a in ANSWERS] == [True, True, False, False, False, False]
    assert [a.believed for a in ANSWERS] == [True, False, True, False, True, False]
    outcome = questions_result(answers_of("walk", "tiny"))
    assert outcome.summary == {
        "questions": 4, "right": 0.5, "right_by_chance": 0.125, "found": 0.25,
        "absent": 2, "refused": 0.5,
    }  # fmt: skip
    assert "First place right: 2 of 4" in outcome.text and "A toy." in outcome.text
    assert "where a random place of the map is right in 12.5 %" in outcome.text
    said = [row[6] for row in rows_in(outcome.text)[2:]]
    assert [row[5] for row in rows_in(outcome.text)[2:]] == ["12.5"] * 4 + ["0.0"] * 2
    assert said == ["right", "right", "wrong", "wrong", "there is none", "there is none"]


def test_the_page_shows_the_newest_answers_of_each_recording(tmp_path):
    store = Store(tmp_path / "answers.jsonl", RecordingAnswers)
    for name, model in (("walk", "old"), ("flat", "one"), ("walk", "new")):
        store.add("key", "c0ffee", "2 cores", answers_of(name, model))
    page = questions_page(tmp_path, tmp_path / "questions.md")
    assert page.count("## ") == 2 and "c0ffee" in page
    assert "asked with new." in page and "asked with old." not in page


@pytest.mark.parametrize("kind", ["probability", "similarity"])
def test_page_and_rows_name_scores_as_what_they_are(tmp_path, kind):
    store = Store(tmp_path / "answers.jsonl", RecordingAnswers)
    store.add("key", "c0ffee", "2 cores", answers_of("walk", "tiny", kind))
    page = questions_page(tmp_path, tmp_path / "questions.md")
    assert f"| {kind} | has to exceed |" in page
    assert ("by which the robot of that commit decided" in page) == (kind == "similarity")
    assert questions_result(answers_of("walk", "tiny", kind)).rows[0]["score"] == 0.6


@pytest.mark.parametrize(("method", "kind"), [("belief", "probability"), ("paper", "similarity")])
def test_a_recording_is_mapped_asked_and_its_answers_kept(recording, tmp_path, method, kind):
    path = questions(tmp_path, MARK.format(0) + '[[question]]\ntext = "dog"\n')
    config = Config.model_validate({"clip": "embedded", "objectnav": {"method": method}})
    outcome = bench.run_questions(recording, path, config, tmp_path / "out")
    [kept] = Store(tmp_path / "out" / "answers.jsonl", RecordingAnswers).all()
    assert [a.exists for a in kept.result.answers] == [True, False]
    assert (kept.result.frames, kept.result.score_kind) == (2, kind)
    assert kept.result.model.startswith("embedded")
    assert questions_result(kept.result) == outcome
    assert "Its poses are the recorded ones." in outcome.text
    (recording / "groundtruth.txt").unlink()  # the frames are alike: SLAM is lost in the second
    again = bench.run_questions(recording, path, config, tmp_path / "out").text
    assert "of our own SLAM, as none were recorded; frames without one, left out: 1." in again


def test_poses_are_interpolated_where_their_neighbours_are_near():
    stamps, poses = np.array([0.0, 0.1, 0.3]), [planar(x, 0.0, min(x, 1.0)) for x in (0, 1, 3)]
    wanted = np.array([-0.02, 0.0, 0.05, 0.105, 0.2, 0.305, 0.32])
    found = poses_at(wanted, stamps, np.array(poses))
    np.testing.assert_allclose(found[:, 0, 3], [np.nan, 0.0, 0.5, 1.05, np.nan, 3.0, np.nan])
    assert yaw_of(found[2]) == pytest.approx(0.5)
    assert np.isnan(poses_at(wanted, stamps[:0], np.zeros((0, 4, 4)))).all()


def test_a_frame_without_a_pose_is_left_out_and_said(recording, tmp_path, caplog):
    truth, mark = recording / "groundtruth.txt", questions(tmp_path, MARK.format(1))
    write_trajectory(truth, np.zeros(1), np.eye(4)[None])
    with RecordedSequence(recording) as camera:
        poses = recorded_poses(camera, recording)
        for found in (poses, estimated_poses(camera, SlamConfig())):
            assert np.isnan(found[:, 0, 0]).tolist() == [False, True]
        assert caplog.text.count("has no pose of 1 of 2 frames: they are left out") == 2
        with pytest.raises(ConfigError, match=r"mark 1, \(80, 60\) is in a frame without a pose"):
            places_of(camera, read_questions(mark), poses)
        write_trajectory(truth, np.arange(5.0, 7.0), np.array([np.eye(4)] * 2))
        with pytest.raises(ConfigError, match=r"of 5\.0.* 2 of 2 frames; the frames are of 0\.0"):
            recorded_poses(camera, recording)


@pytest.mark.parametrize(("second", "now"), [(1.0, "tracking"), (np.nan, "lost")])
def test_told_poses_are_seen_from_the_floor_under_the_first(recording, second, now):
    poses = np.array([planar(2.0, 0.0, 0.0), second * planar(3.0, 0.0, 0.0)])
    with RecordedSequence(recording) as camera:
        slam = told_poses(camera, poses, KeyframeConfig())
        told = [slam.track(camera.frame(i), None) for i in range(2)]
    assert [each.tracking.value for each in told] == ["tracking", now]
    np.testing.assert_allclose(told[0].T_map_cam, camera_mount(1.5, 0.0, 0.0), atol=1e-9)
    T_first_second = invert(told[0].T_map_cam) @ told[1].T_map_cam
    np.testing.assert_allclose(T_first_second, planar(now == "tracking", 0.0, 0.0), atol=1e-9)
