import base64
import re
from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.helpers.watched_robot import first_step
from vizbot.core.geometry import planar
from vizbot.core.observer import Candidate, Effort, GoalReport, Outcome
from vizbot.core.place_scores import PlaceScores
from vizbot.core.types import Tracking
from vizbot.operator.figures.panels import TILE, panels
from vizbot.operator.report.report import VIDEO

RED, GREEN = (205, 45, 40), (30, 150, 60)
POINTS = np.array([[3.5, 2.5, 0.4], [1.5, 1.5, 0.4]])
CANDIDATE = Candidate(np.array([3.5, 2.5, 0.4]), 0.4, 0, np.array([16, 8, 48, 40]))


@pytest.fixture
def step():
    rng = np.random.default_rng(0)
    plain = first_step()
    depth = rng.uniform(0.5, 4.0, (48, 64)).astype(np.float32)
    depth[:10] = 0.0
    plain.grid.occupancy[20, 20:80] = 0.9
    rgb = rng.integers(0, 255, (48, 64, 3), np.uint8)
    return replace(
        plain,
        frame=replace(plain.frame, rgb=rgb, depth=depth),
        goal="yellow <chair>",
        activity="looking closer",
        path=np.array([[2.0, 2.0], [2.5, 2.0], [3.5, 2.5]]),
        target=np.array([3.5, 2.5]),
        distance_to_go=1.6,
        scores=PlaceScores.of_points(POINTS, np.array([0.4, 0.1], np.float32), 0.25),
        points=POINTS,
        frames=np.array([0, 0], np.int32),
        boxes=np.array([[16, 8, 48, 40], [0, 0, 16, 16]], np.int32),
        keyframe_poses={0: planar(1.5, 2.0, 0.0), 1: planar(2.0, 2.0, 0.5)},
        closures=[(0, 1)],
        frontiers=np.array([[4.0, 1.0]]),
    )


def has_colour(picture, colour):
    return bool((np.abs(picture.astype(int) - colour).max(axis=2) < 12).any())


def test_there_are_four_pictures_of_one_size(step):
    drawn = panels(step, np.array([[1.5, 2.0], [2.0, 2.0]]))
    assert list(drawn) == ["colour", "depth", "obstacle map", "likeness"]
    assert all(picture.shape == (TILE[1], TILE[0], 3) for picture in drawn.values())


def test_the_obstacle_map_has_the_robot_in_red_and_path_and_goal_in_green(step):
    picture = panels(step, np.array([[1.5, 2.0], [2.0, 2.0]]))["obstacle map"]
    assert has_colour(picture, RED)
    assert has_colour(picture, GREEN)
    assert {60, 205, 255} <= set(np.unique(picture[..., 0]))


def test_unmeasured_depth_is_black(step):
    assert (panels(step, np.zeros((0, 2)))["depth"][0] == 0).all()


def test_north_is_up_on_the_map(step):
    picture = panels(step, np.zeros((0, 2)))["obstacle map"]
    wall_rows = np.flatnonzero((picture[..., 0] == 60).sum(axis=1) > 100)
    assert wall_rows.min() > TILE[1] / 2  # the wall is at the southern edge of what is known


def test_the_page_is_one_file_that_plays_the_video_and_escapes_the_goal(step, report_of, tmp_path):
    found = GoalReport("yellow <chair>", Outcome.ARRIVED, "similarity", (CANDIDATE,))
    report = report_of(step, step, step, found, notice="rehearsal model")
    page = report.finish({"success": True}, attributions=["Sofa by A. N. Author"]).read_text()
    assert "Sofa by A. N. Author" in page
    assert "yellow &lt;chair&gt;" in page and "<chair>" not in page
    assert "rehearsal model" in page
    sources = re.findall(r'src="([^"]{0,20})', page)
    assert len(sources) == 6
    assert all(source.startswith("data:") for source in sources)
    readable, frame = cv2.VideoCapture(str(tmp_path / "run.webm")).read()
    assert readable and frame.shape == (*VIDEO[::-1], 3)


def test_the_last_map_shows_the_path_to_what_was_found(step, page_of):
    at_the_end = replace(step, index=1, path=step.path[-1:])
    pages = page_of(step, at_the_end), page_of(at_the_end)
    maps = [picture_of(page, "obstacle map").astype(int) for page in pages]
    green = [(np.abs(each - GREEN).max(axis=2) < 12).sum() for each in maps]
    assert green[0] > green[1] + 50


def test_a_run_without_a_frame_has_a_page_too(page_of):
    assert "<video" not in page_of()


@pytest.fixture
def told(step, report_of):
    """Makes the page of a run that found the chair after some steps."""

    def told(**changes):
        frames = [replace(step.frame, stamp=0.5 * index) for index in range(5)]
        steps = (replace(step, index=i, frame=f, **changes) for i, f in enumerate(frames))
        sure = {"effort": Effort(50.0, 12.3), "threshold": 0.32}
        found = GoalReport(step.goal, Outcome.ARRIVED, "seen from near by", (CANDIDATE,), **sure)
        return report_of(*steps, found).finish({"steps": 5}).read_text()

    return told


def picture_of(page, alt):
    encoded = re.findall(rf'alt="{alt}" src="data:image/[a-z]+;base64,([^"]+)', page)[0]
    bgr = cv2.imdecode(np.frombuffer(base64.b64decode(encoded), np.uint8), cv2.IMREAD_COLOR)
    return bgr[..., ::-1]


def points_of(page, curve):
    points = re.findall(rf'class="{curve}" points="([^"]+)"', page)[0]
    return np.array([point.split(",") for point in points.split()], np.float64)


def test_the_score_of_the_answer_stands_beside_what_was_enough(told):
    assert "seen from near by\n  <br><span" in (page := told())
    assert ">32% was enough at the end<" in page


def in_grey(step):
    return replace(step, frame=replace(step.frame, rgb=np.full((48, 64, 3), 90, np.uint8)))


def test_the_patch_that_was_found_is_boxed_in_its_picture(step, page_of):
    found = GoalReport(step.goal, Outcome.ARRIVED, "", (CANDIDATE,))
    page = page_of(in_grey(step), replace(step, index=1, frame_number=3), found)
    picture = picture_of(page, "what place 1 was found in").astype(int)
    greener = picture[..., 1] - picture[..., 0]
    assert min(greener[35, 16], greener[35, 47], greener[39, 20], greener[39, 40]) > 40
    assert np.abs(picture[32:35, 22:42] - 90).max() < 30
    assert np.abs(picture[:, 56:] - 90).max() < 30


def test_the_picture_of_the_latest_answer_is_its_best_place(step, report_of):
    report = report_of(step, replace(step, index=1, frame_number=3))
    first, later = (GoalReport("sofa", Outcome.ARRIVED, "", (CANDIDATE,)) for _ in range(2))
    unseen = replace(later, candidates=(replace(CANDIDATE, frame=99), CANDIDATE))
    assert report.picture_of(first) is None
    report.on_goal(first)
    assert report.picture_of(first)[:2] == b"\xff\xd8"
    report.on_goal(later)
    assert report.picture_of(first) is None and report.picture_of(later) is not None
    report.on_goal(unseen)
    assert report.picture_of(unseen) is None


def test_a_place_has_its_picture_before_there_is_an_answer(step, report_of):
    report = report_of(in_grey(step))
    encoded = np.frombuffer(report.picture_of_place(CANDIDATE), np.uint8)
    picture = cv2.imdecode(encoded, cv2.IMREAD_COLOR).astype(int)
    greener = picture[..., 1] - picture[..., 2]
    assert min(greener[35, 16], greener[35, 47]) > 40 and np.abs(picture[:, 56:] - 90).max() < 30
    assert report.picture_of_place(replace(CANDIDATE, frame=99)) is None


def test_pictures_that_were_not_kept_are_left_out(told):
    page = told(frame_number=7)
    assert "was found in" not in page and "Found the yellow &lt;chair&gt; after 50 s, 12 m" in page


def test_score_and_threshold_are_curves_over_the_steps(step, page_of):
    steps = []
    for index, best in enumerate((0.1, 0.2, 0.4)):
        scores = PlaceScores.of_points(POINTS, np.array([best, 0.0], np.float32), 0.25)
        steps.append(replace(step, index=index, scores=scores))
    page = page_of(*steps)
    best, threshold = points_of(page, "curve best"), points_of(page, "curve threshold")
    assert len(best) == len(threshold) == 3
    x, y = best.T
    assert x[1] - x[0] == pytest.approx(x[2] - x[1], abs=0.2) and x[2] > x[0]
    assert (y[0] - y[1]) * 2 == pytest.approx(y[1] - y[2], abs=0.3)  # up is less
    assert threshold[0, 1] == threshold[2, 1] == pytest.approx((y[1] + y[2]) / 2, abs=0.2)
    assert "not ended" in page


def test_the_map_has_track_keyframes_and_closed_loops_where_they_were(step, page_of):
    first = replace(step, T_map_base=planar(1.5, 2.0, 0.0))
    found = GoalReport(step.goal, Outcome.ARRIVED, "", (CANDIDATE,))
    page = page_of(first, replace(step, index=1), found)
    # Known are x from 1 to 4 m and y from 1 to 3 m; 0.3 m around it belong to the drawing.
    assert 'viewBox="0 0 360.0 260.0"' in page
    np.testing.assert_allclose(points_of(page, "track"), [[80.0, 130.0], [130.0, 130.0]])
    assert re.findall(r'class="keyframe" cx="([0-9.]+)" cy="([0-9.]+)"', page) == [
        ("80.0", "130.0"), ("130.0", "130.0"),
    ]  # fmt: skip
    assert 'class="closure" x1="80.0" y1="130.0" x2="130.0" y2="130.0"' in page
    assert 'class="place" cx="280.0" cy="80.0"' in page
    assert 'class="frontier" cx="330.0" cy="230.0"' in page
    assert "2 keyframes" in page and "1 closed loop between" in page


def test_events_and_rates_are_told_with_their_time(step, page_of):
    steps = []
    for index, activity in enumerate(("exploring", "exploring", "going")):
        frame = replace(step.frame, stamp=10.0 + 0.5 * index)
        steps.append(replace(step, index=index, frame=frame, activity=activity))
    page = page_of(*steps)
    assert "<td>0.0<td>0<td>exploring" in page and "<td>1.0<td>2<td>going" in page
    assert "<th>steps per second<td>2.00" in page and 'class="curve rate"' in page


def test_why_it_does_what_it_does_is_told_where_more_than_numbers_changes(step, page_of):
    closer = "something {} m away may be it ({}%); from near by it tells more"
    whys = closer.format(5, 30), closer.format(4, 35), "what is near by is likely enough (85%)", ""
    page = page_of(*(replace(step, index=index, why=why) for index, why in enumerate(whys)))
    events = re.findall(r"<td>(\d)<td>looking closer(.*)", page)
    assert events == [("0", f": {whys[0]}"), ("2", f": {whys[2]}"), ("3", "")]


def test_only_a_lost_and_a_found_place_are_told_of_tracking(step, page_of):
    course = (Tracking.TRACKING, Tracking.WHEELS_ONLY, Tracking.LOST, Tracking.LOST,
              Tracking.RELOCALISED, Tracking.TRACKING)  # fmt: skip
    estimates = [replace(step.estimate, tracking=tracking) for tracking in course]
    page = page_of(*(replace(step, index=i, estimate=each) for i, each in enumerate(estimates)))
    assert page.count("it has lost its place") == page.count("it knows its place again") == 1
    assert "wheels only" not in page and "relocalised" not in page


def test_what_was_measured_is_told_in_words(step, report_of):
    measured = {"success": True, "judged": False, "error": None, "steps": 3}
    page = report_of(step).finish(measured).read_text()
    for name, words in (("success", "yes"), ("judged", "no"), ("error", "none"), ("steps", "3")):
        assert f"<tr><th>{name}<td>{words}<" in page
    assert 'poster="data:image/jpeg' in page


def test_the_page_needs_nothing_from_elsewhere(told):
    page = told()
    written = re.sub(r"base64,[A-Za-z0-9+/=]+", "", page)
    assert "<script" not in written and "http" not in written
    assert all(source.startswith("data:") for source in re.findall(r'(?:src|href)="([^"]*)', page))


def test_goals_that_were_only_looked_up_show_what_they_were_found_in(step, page_of):
    sofa = GoalReport("sofa", Outcome.LOCATED, "similar", (CANDIDATE,))
    lamp = GoalReport("lamp", Outcome.NOT_FOUND, "nothing", ())
    page = page_of(replace(step, goal="", scores=None), sofa, lamp)
    assert page.count("was found in") == 1 and 'class="curve best"' not in page
    assert "Found the sofa on the map" in page and "Did not find the lamp" in page
