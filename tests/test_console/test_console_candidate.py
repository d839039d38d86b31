"""What the console shows while the robot goes up to what may be the goal, in a real browser."""

import pytest

from tests.helpers.browsing import box_of, says, touch_screen, until
from tests.test_console.test_console_arrival import chair, focus_by_keyboard

TITLE = "I see something like a yellow chair"


@pytest.fixture
def going_up(robot):
    """It searches, and goes up to something."""
    robot.approach((3.0, 2.5), chair())
    robot.session.ask(["yellow chair"])
    return robot


def test_what_the_robot_goes_up_to_is_shown_until_it_turns_to_something_else(page, going_up):
    picture = page.locator("#candidate-picture")
    says(page, "#candidate-title", TITLE)
    says(page, "#candidate-question", "It takes a closer look.")
    until(page, lambda: picture.evaluate("one => one.naturalWidth") == 400)
    assert not page.locator("#arrival").is_visible()
    shown = picture.get_attribute("src")
    going_up.approach((0.5, 0.5))
    until(page, lambda: picture.get_attribute("src") != shown)
    until(page, lambda: not picture.is_visible())  # of that no picture was kept
    going_up.approach(None)
    page.locator("#candidate").wait_for(state="hidden")
    says(page, "#goals li.running b", "Yellow chair")


def test_keep_looking_has_the_robot_believe_that_place_less_and_search_on(page, going_up):
    says(page, "#candidate-title", TITLE)
    number = going_up.session.queue.current().number
    focus_by_keyboard(page, "candidate-no")
    going_up.pipeline.refute = lambda place_xy: going_up.approach(None)
    page.keyboard.press("Enter")
    page.locator("#candidate").wait_for(state="hidden")
    says(page, "#log li", "yellow chair: you say that is not it; the search goes on")
    assert going_up.session.queue.current().number == number


def test_go_there_is_taken_and_may_be_taken_back(page, going_up):
    says(page, "#candidate-title", TITLE)
    page.get_by_role("button", name="Go there").click()
    says(page, "#candidate-question", "It goes there, and stops there.")
    assert not page.locator("#candidate-yes").is_visible()
    assert going_up.pipeline.affirmed == [(3.0, 2.5)]
    says(page, "#log li", "yellow chair: you say go there")
    page.get_by_role("button", name="Keep looking").click()
    until(page, lambda: going_up.pipeline.refuted == 1)
    says(page, "#candidate-question", "It takes a closer look.")  # it goes up to it all the same


def test_an_answer_that_comes_too_late_is_refused_in_words(page, going_up):
    says(page, "#candidate-title", TITLE)
    judge = going_up.session.judge_candidate
    going_up.session.judge_candidate = lambda number, **said: judge(number - 1, **said)
    page.get_by_role("button", name="Go there").click()
    says(page, "#candidate-question", "Not asked: the robot has turned to something else by now.")
    assert going_up.pipeline.affirmed == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_small_phone_has_room_for_it(open_page, server, robot, snapshot, scheme):
    page = open_page(server.url, **touch_screen(320, 700), color_scheme=scheme)
    robot.approach((3.0, 2.5), chair())
    robot.session.ask(["yellow chair"])
    picture = page.locator("#candidate-picture")
    until(page, lambda: picture.evaluate("one => one.naturalWidth") == 400)
    snapshot(page, f"candidate-phone-{scheme}")
    assert page.evaluate("document.documentElement.scrollWidth") <= 320
    stop = box_of(page.locator("#stop"))
    for name in ("#candidate-yes", "#candidate-no"):
        button = box_of(page.locator(name))
        assert min(button["width"], button["height"]) >= 44
        assert button["y"] + button["height"] <= stop["y"]
    assert page.complaints == []


def test_on_a_wide_screen_it_stands_beside_the_pictures(open_page, server, going_up, snapshot):
    page = open_page(server.url, viewport={"width": 1280, "height": 900})
    says(page, "#candidate-title", TITLE)
    picture = page.locator("#candidate-picture")
    until(page, lambda: picture.evaluate("one => one.naturalWidth") == 400)
    snapshot(page, "candidate-desktop")
    assert box_of(page.locator("#candidate"))["x"] > 800
