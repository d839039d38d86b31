"""A robot that is left on for days has a report that is no larger for it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.served import step as standing
from vizbot.core.observer import Candidate, GoalReport, Outcome
from vizbot.core.types import STOP
from vizbot.operator.figures.steps import Track
from vizbot.operator.report import frame_store, report, timeline
from vizbot.operator.report.frame_store import FrameStore
from vizbot.operator.report.report import Report


def waiting(index, x=0.0, **changes):
    """Nothing is asked of the robot; one patch of its first frame is on the map."""
    frames = np.zeros(1, np.int32)
    return replace(standing(index, x), goal="", activity="mapping", frames=frames, **changes)


def size(kept):
    """So many pictures in the video, places in the track, bytes on the disk."""
    files = sum(segment._file.seek(0, 2) for segment in kept._frame_store._segments)
    return kept._drawn, len(kept._track.xy), files


def test_who_waits_adds_nothing(report_of):
    kept = report_of(waiting(0))
    before = size(kept)
    for index in range(1, 400):
        kept.on_step(waiting(index, 0.002 * (index % 3)))
    assert size(kept) == before
    assert len(kept._frame_store._waiting) == frame_store._WAITING
    page = kept.finish({}).read_text()
    assert "<video" in page and "<td>0.0<td>0<td>mapping" in page


@pytest.mark.parametrize(
    "step",
    [waiting(2, 0.02), waiting(2, command=STOP), replace(waiting(2), goal="sofa")],
    ids=["moved", "commanded", "asked"],
)
def test_who_does_something_is_drawn(report_of, step):
    kept = report_of(waiting(0), step)
    assert size(kept)[:2] == (2, 2)
    kept.finish({})  # what waits to be drawn would be in a later test


@pytest.fixture
def drawn(monkeypatch):
    """The numbers of the steps that are drawn."""
    drawn = []
    monkeypatch.setattr(Report, "_draw", lambda _, step, *__: drawn.append(step.index))
    return drawn


def test_a_usual_run_is_drawn_as_ever(report_of, drawn):
    ended = replace(standing(301), ended=(Outcome.ARRIVED, "near by"))
    kept = report_of(*map(standing, range(301)), ended)
    kept.finish({})
    assert drawn == [*range(0, 301, 2), 301]
    assert len(kept._track.xy) == 302


def test_a_long_video_grows_ever_more_slowly_and_ends(page_of, drawn, monkeypatch):
    monkeypatch.setattr(report, "_PICTURES", 9)
    monkeypatch.setattr(report, "_THINNED", 3)
    page_of(*map(standing, range(200)))
    assert drawn == [0, 2, 4, 8, 12, 16, 24, 32, 40]


def test_a_track_keeps_its_ends_and_is_thinned_between_them():
    way = Track(capacity=8)
    for x in range(30):
        way.add(np.array([x, 0.0]))
        assert len(way.xy) <= 8 and way.xy[0, 0] == 0.0 and way.xy[-1, 0] == x
    assert (np.diff(way.xy[:, 0]) > 0).all()


def test_a_track_leaves_out_what_is_too_near_to_its_end():
    way = Track(spacing=0.05)
    assert [way.add(np.array([x, 0.0])) for x in (0.0, 0.04, 0.06, 0.1, 0.12)] == [
        True, False, True, False, True,
    ]  # fmt: skip
    np.testing.assert_allclose(way.xy[:, 0], [0.0, 0.06, 0.12])


def test_long_curves_are_thinned_and_the_rate_is_still_that_of_all_steps(monkeypatch):
    monkeypatch.setattr(timeline, "_MOST_STEPS", 20)
    run = timeline.Timeline()
    for index in range(101):
        run.add(standing(index))
    (goal,) = run.goals
    for curve in (run._steps, goal.steps):
        assert len(curve) <= 20 and curve[0] == 0 and curve[-1] == 100
        assert curve == sorted(set(curve))
    assert len(goal.best) == len(goal.thresholds) == len(goal.steps)
    assert run.rate == pytest.approx(10.0)


def test_the_frame_store_keeps_pictures_of_what_is_on_the_map(tmp_path):
    kept = FrameStore(tmp_path)
    for number in range(150):
        kept.add(number, np.full((24, 32, 3), number, np.uint8))
    kept.keep(np.array([70, 70, 90], np.int32))
    assert [number for number in range(150) if kept.get(number)] == [70, *range(90, 150)]
    assert kept._segments[-1]._extents.keys() == {70, 90}
    picture, scale = kept.get(90)
    assert np.abs(picture.astype(int) - 90).max() < 3 and scale == 1.0
    kept.clear()
    assert kept.get(90) is None and kept.get(149) is None
    kept.close()


def test_the_frame_store_of_a_long_run_has_the_newest_pictures(tmp_path, monkeypatch):
    monkeypatch.setattr(frame_store, "_SEGMENT", 10)
    kept = FrameStore(tmp_path)
    for number in range(45):
        kept.add(number, np.full((24, 32, 3), 90, np.uint8))
        kept.keep(np.array([number], np.int32))
    assert [number for number in range(45) if kept.get(number)] == list(range(30, 45))
    kept.close()


def test_only_the_last_goals_have_pictures(page_of, monkeypatch):
    monkeypatch.setattr(report, "_ILLUSTRATED", 3)
    place = Candidate(np.array([0.2, 0.1, 0.4]), 0.4, 0, np.array([8, 4, 16, 12], np.int32))
    sofas = (GoalReport(f"sofa {i}", Outcome.LOCATED, "similar", (place,)) for i in range(5))
    page = page_of(waiting(0), *sofas)
    assert page.count("was found in") == 3 and "Found the sofa 0 on the map" in page
