import base64
import re
from dataclasses import replace

import cv2
import numpy as np
import pytest

from vizbot.core.geometry import planar
from vizbot.core.observation import Candidate, GoalReport, Outcome, Step
from vizbot.core.types import (
    ImuSamples,
    Intrinsics,
    OccupancyGrid,
    PoseEstimate,
    RGBDFrame,
    Tracking,
)
from vizbot.operator.panels import TILE, board, panels
from vizbot.operator.report import Report

RED, GREEN = (205, 45, 40), (30, 150, 60)


@pytest.fixture
def step():
    rng = np.random.default_rng(0)
    camera = Intrinsics(64, 48, 60.0, 60.0, 31.5, 23.5)
    depth = rng.uniform(0.5, 4.0, (48, 64)).astype(np.float32)
    depth[:10] = 0.0
    occupancy = np.full((80, 100), 0.5, np.float32)
    occupancy[20:60, 20:80] = 0.1
    occupancy[20, 20:80] = 0.9
    estimate = PoseEstimate(0.0, np.eye(4), 0, np.eye(4), True, Tracking.TRACKING)
    return Step(
        index=0,
        frame=RGBDFrame(
            0.0, rng.integers(0, 255, (48, 64, 3), np.uint8), depth, camera, ImuSamples.none()
        ),
        estimate=estimate,
        T_map_base=planar(2.0, 2.0, 0.5),
        grid=OccupancyGrid(occupancy, 0.05, np.zeros(2)),
        goal="yellow <chair>",
        activity="going to what was found",
        path=np.array([[2.0, 2.0], [2.5, 2.0], [3.5, 2.5]]),
        target=np.array([3.5, 2.5]),
        distance_to_go=1.6,
        threshold=0.3,
        points=np.array([[3.5, 2.5, 0.4], [1.5, 1.5, 0.4]]),
        similarities=np.array([0.4, 0.1], np.float32),
        ended=None,
        command=None,
    )


def has_colour(picture, colour):
    return bool((np.abs(picture.astype(int) - colour).max(axis=2) < 12).any())


def test_there_are_four_pictures_of_one_size(step):
    drawn = panels(step, np.array([[1.5, 2.0], [2.0, 2.0]]))
    assert list(drawn) == ["colour", "depth", "obstacle map", "similarity"]
    assert all(picture.shape == (TILE[1], TILE[0], 3) for picture in drawn.values())


def test_the_obstacle_map_has_the_robot_in_red_and_path_and_goal_in_green(step):
    track = np.array([[1.5, 2.0], [2.0, 2.0]])
    picture = panels(step, track)["obstacle map"]
    assert has_colour(picture, RED)
    assert has_colour(picture, GREEN)
    assert {60, 205, 255} <= set(np.unique(picture[..., 0]))


def test_unmeasured_depth_is_black(step):
    assert (panels(step, np.zeros((0, 2)))["depth"][0] == 0).all()


def test_north_is_up_on_the_map(step):
    picture = panels(step, np.zeros((0, 2)))["obstacle map"]
    wall_rows = np.flatnonzero((picture[..., 0] == 60).sum(axis=1) > 100)
    assert wall_rows.min() > TILE[1] / 2  # the wall is at the southern edge of what is known


def test_the_page_is_one_file_that_plays_the_video_and_escapes_the_goal(step, tmp_path):
    report = Report(tmp_path, "rehearsal model")
    for _ in range(3):
        report.on_step(step)
    candidate = Candidate(np.array([3.5, 2.5, 0.4]), 0.4)
    report.on_goal(GoalReport("yellow <chair>", Outcome.ARRIVED, "similarity", (candidate,)))
    page = report.finish({"success": True}, attributions=["Sofa by A. N. Author"]).read_text()
    assert "Sofa by A. N. Author" in page
    assert "yellow &lt;chair&gt;" in page and "<chair>" not in page
    assert "rehearsal model" in page
    sources = re.findall(r'src="([^"]{0,20})', page)
    assert len(sources) == 5
    assert all(source.startswith("data:") for source in sources)
    video = cv2.VideoCapture(str(tmp_path / "run.webm"))
    readable, frame = video.read()
    assert readable and frame.shape == board(step, np.zeros((0, 2))).shape


def test_the_last_map_shows_the_path_to_what_was_found(step, tmp_path):
    at_the_end = replace(step, index=1, path=step.path[-1:])
    pages = []
    for steps in ([step, at_the_end], [at_the_end]):
        report = Report(tmp_path, None)
        for each in steps:
            report.on_step(each)
        page = report.finish({}).read_text()
        picture = re.findall(r'alt="obstacle map" src="data:image/png;base64,([^"]+)', page)[0]
        pixels = np.frombuffer(base64.b64decode(picture), np.uint8)
        pages.append(cv2.imdecode(pixels, cv2.IMREAD_COLOR)[..., ::-1])
    green = [(np.abs(page.astype(int) - GREEN).max(axis=2) < 12).sum() for page in pages]
    assert green[0] > green[1] + 50


def test_a_run_without_a_frame_has_a_page_too(tmp_path):
    page = Report(tmp_path, None).finish({"steps": 0}).read_text()
    assert "<video" not in page
