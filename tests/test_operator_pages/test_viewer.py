"""What `--rerun` records is what the robot saw, knew and decided."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from rerun.chunk import RrdReader

from tests.helpers.rrd import at, entities, rows
from tests.helpers.served import resting as standing
from tests.helpers.served import scored
from tests.helpers.served import step as watched
from vizbot.core.geometry import planar
from vizbot.core.observer import Candidate, GoalReport, Outcome
from vizbot.core.types import STOP, OccupancyGrid, Tracking, Twist
from vizbot.operator.viewer.viewer import Viewer

RNG = np.random.default_rng(0)
BOX = np.array([[8, 4, 16, 12]], np.int32)


def mapped(index, points, scores, frames, **changes):
    """A step at x = index/10 with so many elements."""
    return scored(
        standing(index, 0.1 * index),
        np.array(points, np.float64).reshape(-1, 3),
        scores,
        0.01,
        frames=np.array(frames, np.int32),
        boxes=BOX.repeat(len(frames), axis=0),
        **changes,
    )


def test_elements_are_where_the_step_has_them_with_their_scores(recorded):
    points, scores = RNG.uniform(-3, 3, (600, 3)), RNG.uniform(0.0, 0.5, 600)
    frames = np.zeros(600)
    path = recorded(
        mapped(0, points[:10], scores[:10], frames[:10]), mapped(1, points, scores, frames)
    )
    blocks = [at(path, f"map/elements/{block:04d}", 1) for block in range(3)]
    shown = np.concatenate([block["Points3D:positions"] for block in blocks])
    np.testing.assert_allclose(shown, points, atol=1e-5)
    recorded_scores = np.concatenate([block["score"] for block in blocks])
    np.testing.assert_allclose(recorded_scores, scores, atol=1e-6)
    assert len(at(path, "map/elements/0000", 0)["Points3D:positions"]) == 10


def test_elements_are_sent_again_only_where_something_is_new(recorded):
    points, scores, frames = RNG.uniform(-3, 3, (300, 3)), np.full(300, 0.1), np.zeros(300)
    moved = points.copy()
    moved[:256] += 0.1
    other = np.concatenate([scores[:256], scores[256:] + 0.1])
    path = recorded(
        mapped(0, points, scores, frames),
        mapped(1, points + 0.001, scores, frames),
        mapped(2, moved, scores, frames),
        mapped(3, moved, other, frames),
    )
    assert [row["step"] for row in rows(path, "map/elements/0000")] == [0, 2]
    assert [row["step"] for row in rows(path, "map/elements/0001")] == [0, 3]


def test_colours_keep_their_meaning_in_a_search_and_tell_what_is_likely(recorded):
    points, frames = np.eye(2, 3), np.zeros(2)
    path = recorded(
        mapped(0, points, [0.0, 0.33], frames),
        mapped(1, points, [0.1, 0.33], frames, threshold=0.1),
        replace(mapped(2, points, [0.0, 0.0], frames, goal=""), scores=None),
    )
    first, second, none = (row["Points3D:colors"] for row in rows(path, "map/elements/0000"))
    assert first[1] == second[1] != first[0]
    assert none[0] == none[1] == 0x969696FF


def test_matching_patches_are_boxed_in_the_picture_they_were_cut_from(recorded):
    path = recorded(
        mapped(0, [], [], []),
        mapped(1, np.arange(9.0).reshape(3, 3), [0.4, 0.5, 0.1], [0, 0, 0], threshold=0.3),
        mapped(2, np.arange(15.0).reshape(5, 3), [0.4, 0.5, 0.1, 0.2, 0.1], [0, 0, 0, 2, 2]),
    )
    first = at(path, "map/robot/camera/matches", 0)
    assert first["Boxes2D:labels"] == ["40%", "50%"]
    assert first["Boxes2D:centers"] == [[12.0, 8.0]] * 2
    assert first["Boxes2D:half_sizes"] == [[4.0, 4.0]] * 2
    assert first["stamp"] == 0.0
    assert not at(path, "map/robot/camera/matches", 1)["Boxes2D:centers"]
    # Where nothing matched, the best is shown.
    assert at(path, "map/robot/camera/matches", 2)["Boxes2D:labels"] == ["20%"]


def test_keyframes_and_closed_loops_are_where_the_graph_has_them(recorded):
    poses = {4: planar(1.0, 0.0, 0.0), 7: planar(2.0, 1.0, 0.5), 9: planar(1.0, 0.2, 3.0)}
    path = recorded(replace(standing(0), keyframe_poses=poses, closures=[(4, 9)]))
    shown = at(path, "map/keyframes", 0)["Points3D:positions"]
    np.testing.assert_allclose(shown, [[1.0, 0.0, 0.0], [2.0, 1.0, 0.0], [1.0, 0.2, 0.0]])
    (line,) = at(path, "map/closures", 0)["LineStrips3D:strips"]
    np.testing.assert_allclose(line, [[1.0, 0.0, 0.0], [1.0, 0.2, 0.0]], atol=1e-6)


def test_the_obstacle_map_lies_at_its_place_with_north_up(recorded):
    occupancy = np.full((40, 60), 0.5, np.float32)
    occupancy[10:20, 5:25] = 0.1
    occupancy[10, 5:25] = 0.9
    grid = OccupancyGrid(occupancy, 0.05, np.array([-2.0, -1.0]))
    shown = at(recorded(replace(standing(0), grid=grid)), "map/occupancy", 0)
    np.testing.assert_allclose(shown["GridMap:translation"], [[-1.75, -0.5, 0.0]], atol=1e-6)
    np.testing.assert_allclose(shown["GridMap:cell_size"], [0.05])
    (size,) = shown["GridMap:format"]
    assert (size["width"], size["height"]) == (20, 10)
    picture = np.array(shown["GridMap:data"][0], np.uint8).reshape(10, 20)
    assert (picture[-1] == 60).all() and (picture[:-1] == 255).all()


def test_path_target_and_frontiers_come_and_go(recorded):
    way, target = np.array([[0.0, 0.0], [1.0, 0.5]]), np.array([1.0, 0.5])
    going = replace(standing(0), path=way, target=target, frontiers=np.array([[2.0, 3.0]]))
    path = recorded(going, standing(1))
    (strip,) = at(path, "map/path", 0)["LineStrips3D:strips"]
    np.testing.assert_allclose(np.array(strip)[:, :2], way)
    np.testing.assert_allclose(at(path, "map/target", 0)["Points3D:positions"][0][:2], target)
    np.testing.assert_allclose(at(path, "map/frontiers", 0)["Points3D:positions"][0][:2], [2, 3])
    assert not at(path, "map/path", 1)["LineStrips3D:strips"]
    assert not at(path, "map/target", 1)["Points3D:positions"]
    assert not at(path, "map/frontiers", 1)["Points3D:positions"]


def test_the_robot_its_track_and_its_pictures_are_recorded(recorded):
    path = recorded(*[standing(index, 0.1 * index) for index in range(3)])
    np.testing.assert_allclose(
        at(path, "map/robot", 2)["Transform3D:translation"], [[0.2, 0.0, 0.0]], atol=1e-6
    )
    (track,) = at(path, "map/track/0000", 2)["LineStrips3D:strips"]
    np.testing.assert_allclose(np.array(track)[:, 0], [0.0, 0.1, 0.2], atol=1e-6)
    pictures = [row for row in rows(path, "map/robot/camera") if row.get("EncodedImage:blob")]
    assert [row["step"] for row in pictures] == [0, 1, 2]
    assert [row["stamp"] for row in pictures] == pytest.approx([0.0, 0.1, 0.2])
    picture = cv2.imdecode(np.array(pictures[0]["EncodedImage:blob"][0], np.uint8), -1)
    assert picture.shape == (24, 32, 3) and np.abs(picture.astype(int) - 90).max() < 3
    blobs = [row for row in rows(path, "map/robot/depth") if row.get("EncodedDepthImage:blob")]
    depth = cv2.imdecode(np.array(blobs[0]["EncodedDepthImage:blob"][0], np.uint8), -1)
    assert depth.shape == (6, 8) and (depth == 100).all()
    assert blobs[0]["EncodedDepthImage:meter"] == [100.0]


def test_a_robot_that_rests_is_recorded_seldom_until_something_happens(recorded):
    resting = replace(watched(0), goal="", scores=None, activity="mapping")
    steps = [
        replace(resting, index=index, frame=replace(resting.frame, stamp=0.1 * index))
        for index in range(200)
    ]
    steps[30:] = [replace(step, T_map_base=planar(0.0, 0.0, 0.1)) for step in steps[30:]]
    steps[40:] = [replace(step, keyframe_poses={0: np.eye(4), 1: np.eye(4)}) for step in steps[40:]]
    for index, change in ((50, {"command": STOP}), (51, {"goal": "sofa"}), (53, {"activity": "x"})):
        steps[index] = replace(steps[index], **change)
    path = recorded(*steps)
    told = [0, 30, 40, 50, 51, 52, 53, 54, 154]
    for entity in ("map/robot", "map/robot/camera/matches", "plots/map/elements"):
        assert [row["step"] for row in rows(path, entity)] == told
    assert at(path, "plots/rate/steps_per_second", 154)["Scalars:scalars"] == pytest.approx([10.0])


def test_another_map_is_recorded_at_once_though_the_robot_rests(recorded):
    resting = replace(watched(0), goal="", activity="mapping")
    other = replace(resting, index=1, map_number=1, points=resting.points + 1.0)
    shown = at(recorded(resting, other), "map/elements/0000", 1)["Points3D:positions"]
    np.testing.assert_allclose(shown, other.points)


def test_plots_and_events_tell_the_numbers_and_what_happened(recorded):
    lost = replace(standing(0).estimate, tracking=Tracking.LOST)
    answer = Candidate(np.array([0.5, 0.0, 0.4]), 0.2, 0, BOX[0])
    path = recorded(
        replace(standing(0), why="little else is left to see"),
        replace(standing(1), command=Twist(0.2, -0.5), activity="going", estimate=lost),
        GoalReport("sofa", Outcome.LOCATED, "similar", (answer,)),
    )
    for name, number in (
        ("score/best", 0.2), ("score/threshold", 0.3), ("twist/linear", 0.2),
        ("twist/angular", -0.5), ("rate/steps_per_second", 10.0), ("map/elements", 1.0),
        ("map/keyframes", 1.0),
    ):  # fmt: skip
        assert at(path, f"plots/{name}", 1)["Scalars:scalars"] == pytest.approx([number], abs=1e-6)
    assert [row["TextLog:text"][0] for row in rows(path, "events")] == [
        "goal: sofa", "exploring: little else is left to see", "it has lost its place", "going",
        "Found the sofa on the map: similar",
    ]  # fmt: skip
    assert rows(path, "events")[2]["TextLog:level"] == ["WARN"]
    np.testing.assert_allclose(
        at(path, "map/answers", 1)["Points3D:positions"], [[0.5, 0.0, 0.4]], atol=1e-6
    )


def test_the_battery_is_plotted_where_it_is_known_and_has_changed(tmp_path):
    states = iter([None, 0.501, None, 0.499, 0.492, 0.48])
    with Viewer(tmp_path / "run.rrd", lambda: next(states)) as viewer:
        for index in range(6):
            viewer.on_step(standing(index))
    told = rows(tmp_path / "run.rrd", "plots/battery")
    assert [(row["step"], row["Scalars:scalars"][0]) for row in told] == [(1, 50), (4, 49), (5, 48)]


def test_keyframes_leave_a_coloured_cloud_that_moves_with_them(recorded):
    step = standing(0)
    step = replace(step, estimate=replace(step.estimate, is_keyframe=True))
    path = recorded(step, replace(standing(1), keyframe_poses={0: planar(0.5, 0.0, 0.0)}))
    cloud = [row for row in rows(path, "map/cloud/0") if row.get("Points3D:positions")]
    assert len(cloud) == 1 and len(cloud[0]["Points3D:positions"]) == 4
    np.testing.assert_allclose(np.array(cloud[0]["Points3D:positions"])[:, 2], 1.0)
    places = [row.get("Transform3D:translation") for row in rows(path, "map/cloud/0")]
    np.testing.assert_allclose([place[0] for place in places if place], [[0, 0, 0], [0.5, 0, 0]])


def test_a_recording_brings_its_layout(recorded):
    path = recorded(standing(0))
    assert {"map/robot", "map/occupancy", "events"} <= entities(path)
    reader = RrdReader(path)
    (layout,) = reader.blueprints()
    names = [
        chunk.to_record_batch().column("ViewBlueprint:display_name").to_pylist()[0]
        for chunk in reader.stream(store=layout)
        if "ViewBlueprint:display_name" in chunk.to_record_batch().schema.names
    ]
    assert ["Map"] in names and ["Score of the best place"] in names
