"""`report.html` in a real browser, as it is read on a phone."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.browsing import found_by_axe, touch_screen, until
from tests.helpers.served import scored
from tests.helpers.served import step as standing
from vizbot.core.observer import Candidate, Effort, GoalReport, Outcome
from vizbot.core.types import Tracking
from vizbot.operator.report.report import VIDEO, Report

UNBROKEN = "chair_" * 12
PLACES = tuple(
    Candidate(np.array([x, 0.1, -0.001]), 0.9 - x, frame, np.array([8, 4, 24, 20], np.int32))
    for frame, x in enumerate((0.2, 0.5, 0.7))
)
GOALS = (
    GoalReport("sofa", Outcome.ARRIVED, "70% sure", PLACES, effort=Effort(73.0, 21.1)),
    GoalReport(UNBROKEN, Outcome.NOT_FOUND, "nothing is likely enough", (), effort=Effort(9, 2)),
)


@pytest.fixture
def small_run(tmp_path):
    """The page of a run that has found one thing, not another, and was lost meanwhile."""
    report = Report(tmp_path, "rehearsal model")
    for index in range(12):
        step = scored(standing(index, 0.05 * index), [[0.2, 0.1, 0.4]], [0.05 * index])
        lost = Tracking.LOST if index == 8 else Tracking.TRACKING
        step = replace(step, estimate=replace(step.estimate, tracking=lost))
        numbers = np.arange(index + 1, dtype=np.int32)
        step = replace(step, goal=GOALS[index // 6].text, frames=numbers)
        report.on_step(step)
        if index % 6 == 5:
            report.on_goal(GOALS[index // 6])
    metrics = {"success": False, "judged": True, "error": None, "run": f"/home/{UNBROKEN}"}
    home = np.full((60, 80, 3), 120, np.uint8)
    return report.finish(metrics, home, [f"Sofa by {UNBROKEN}"]).as_uri()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_report_fits_a_phone_and_is_accessible_by_day_and_night(
    open_page, small_run, snapshot, scheme
):
    page = open_page(small_run, **touch_screen(360, 640), color_scheme=scheme)
    for closed in page.locator("details:not([open]) summary").all():
        closed.tap()
    pictures = page.locator("img")
    assert pictures.count() == 3 + 5
    until(page, lambda: pictures.evaluate_all("all => all.every((one) => one.naturalWidth > 0)"))
    snapshot(page, f"report-{scheme}")
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    assert cut_off(page) == []
    assert found_by_axe(page) == []
    text = page.locator("body").inner_text()
    assert "Found the sofa after 73 s, 21 m" in text and "-0.00" not in text
    assert not any(word in text for word in ("True", "False", "None"))
    assert page.complaints == []


def test_before_it_is_played_the_video_shows_how_the_run_ended(open_page, small_run):
    page = open_page(small_run, viewport={"width": 360, "height": 640})
    size = page.locator("video").evaluate(
        """async (video) => {
            const poster = new Image();
            poster.src = video.poster;
            await poster.decode();
            return [poster.naturalWidth, poster.naturalHeight];
        }"""
    )
    assert size == [*VIDEO]


def cut_off(page):
    """What stands to the right of the page's edge, and is not in a box of its own that scrolls."""
    return page.evaluate(
        """[...document.querySelectorAll("main *")]
            .filter((one) => one.closest(".wide") === null)
            .filter((one) => one.getBoundingClientRect().right > innerWidth)
            .map((one) => one.outerHTML.slice(0, 80))"""
    )
