"""What the console shows and asks before and after an arrival, in a real browser."""

import cv2
import numpy as np
import pytest

from tests.helpers.browsing import box_of, says, touch_screen, until
from tests.helpers.failing import raising
from tests.test_console.person import save_map
from vizbot.core.errors import ConfigError
from vizbot.operator.figures.image_encoding import jpeg

TITLE = "Found the yellow chair after 50 s, 12 m"
SEEN = "I see something like a yellow chair"


def chair():
    """A picture with a box around something yellow."""
    picture = np.full((300, 400, 3), (150, 140, 130), np.uint8)
    cv2.rectangle(picture, (150, 100), (250, 240), (230, 200, 30), -1)
    cv2.rectangle(picture, (140, 90), (260, 250), (30, 150, 60), 2)
    return jpeg(picture)


def focus_by_keyboard(page, name):
    for _ in range(40):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.id") == name:
            return
    raise AssertionError(f"{name} is not reached by Tab")


def test_an_arrival_is_shown_with_its_picture_and_yes_confirms_it(page, robot):
    says(page, "#activity", "Mapping what it sees")
    card, picture = page.locator("#arrival"), page.locator("#arrival-picture")
    assert not card.is_visible()
    robot.arrive("yellow chair", chair())
    says(page, "#arrival-title", TITLE)
    says(page, "#arrival-question", "Is this it?")
    says(page, "#goals li.good b", TITLE)
    says(page, "#goals li.good span", "92% sure")
    until(page, lambda: picture.evaluate("one => one.naturalWidth") == 400)
    page.get_by_role("button", name="Yes", exact=True).click()
    says(page, "#arrival-question", "Yes: this is it.")
    assert not page.locator("#arrival-answers").is_visible()
    assert robot.session.arrival.confirmed is True and robot.pipeline.refuted == 0

    robot.session.ask(["sofa"])
    card.wait_for(state="hidden")


def test_no_by_keyboard_has_the_robot_search_on(page, robot):
    robot.arrive("yellow chair", chair())
    says(page, "#arrival-title", TITLE)
    focus_by_keyboard(page, "arrival-no")
    page.keyboard.press("Enter")
    says(page, "#goals li.running b", "Yellow chair")
    says(page, "#activity", "Looking for “yellow chair”")
    page.locator("#arrival").wait_for(state="hidden")
    assert robot.pipeline.refuted == 1
    says(page, "#log li", "you say that is not it")


def test_what_others_have_said_is_seen_and_the_next_arrival_is_asked_about_anew(page, robot):
    robot.arrive("yellow chair")
    says(page, "#arrival-title", TITLE)
    assert not page.locator("#arrival-picture").is_visible()
    robot.session.judge(confirmed=True, who="ann")
    says(page, "#arrival-question", "Yes: this is it.")
    robot.arrive("sofa", chair())
    says(page, "#arrival-question", "Is this it?")
    until(page, page.locator("#arrival-picture").is_visible)


def test_no_broken_picture_is_shown_where_a_request_fails(open_page, server, robot):
    page = open_page("about:blank")
    page.route("**/*.jpg*", lambda route: route.abort())
    page.goto(server.url)
    page.locator("#link.live").wait_for()
    robot.arrive("yellow chair", chair())
    says(page, "#arrival-question", "Is this it?")
    page.locator("#arrival-picture").wait_for(state="hidden")
    assert not page.locator("#arrival-missing").is_visible()
    save_map(page, "home")
    says(page, "#maps b", "home")
    page.locator("#maps img:not([src])").wait_for(state="attached")
    assert not page.locator("#maps img").is_visible()
    assert page.complaints == []


def test_a_place_of_the_saved_map_is_asked_about_without_a_picture(page, robot):
    robot.session._why_no_picture = lambda places: "no picture: so it is"
    robot.arrive("yellow chair")
    says(page, "#arrival-missing", "No picture: so it is.")
    assert not page.locator("#arrival-picture").is_visible()
    robot.session._why_no_picture = lambda places: "no picture: so it is, too"
    robot.approach((3.0, 2.5))
    robot.session.ask(["yellow chair"])
    says(page, "#candidate-missing", "No picture: so it is, too.")
    assert not page.locator("#candidate-picture").is_visible()


def test_why_a_no_is_refused_is_told_and_can_be_said_again(page, robot):
    robot.pipeline.refute = raising(ConfigError("it cannot learn"))
    robot.arrive("yellow chair", chair())
    page.get_by_role("button", name="No, keep looking").click()
    says(page, "#arrival-question", "Not asked: it cannot learn.")
    del robot.pipeline.refute
    page.get_by_role("button", name="No, keep looking").click()
    until(page, lambda: robot.pipeline.refuted == 1)


@pytest.fixture
def going_up(robot):
    """It searches, and approaches something."""
    go_up(robot)
    return robot


def test_what_the_robot_goes_up_to_is_shown_until_it_turns_to_something_else(page, going_up):
    picture = page.locator("#candidate-picture")
    says(page, "#candidate-title", SEEN)
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
    says(page, "#candidate-title", SEEN)
    number = going_up.session.queue.current().number
    focus_by_keyboard(page, "candidate-no")
    going_up.pipeline.refute = lambda place_xy: going_up.approach(None)
    page.keyboard.press("Enter")
    page.locator("#candidate").wait_for(state="hidden")
    says(page, "#log li", "yellow chair: you say that is not it; the search goes on")
    assert going_up.session.queue.current().number == number


def test_go_there_is_taken_and_may_be_taken_back(page, going_up):
    says(page, "#candidate-title", SEEN)
    page.get_by_role("button", name="Go there").click()
    says(page, "#candidate-question", "It goes there, and stops there.")
    assert not page.locator("#candidate-yes").is_visible()
    assert going_up.pipeline.affirmed == [(3.0, 2.5)]
    says(page, "#log li", "yellow chair: you say go there")
    page.get_by_role("button", name="Keep looking").click()
    until(page, lambda: going_up.pipeline.refuted == 1)
    says(page, "#candidate-question", "It takes a closer look.")  # it approaches it all the same


def test_an_answer_that_comes_too_late_is_refused_in_words(page, going_up):
    says(page, "#candidate-title", SEEN)
    judge = going_up.session.judge_candidate
    going_up.session.judge_candidate = lambda number, **said: judge(number - 1, **said)
    page.get_by_role("button", name="Go there").click()
    says(page, "#candidate-question", "Not asked: the robot has turned to something else by now.")
    assert going_up.pipeline.affirmed == []


def arrive(robot):
    robot.arrive("a very yellow chair of a very longwindednameunbrokenbyanyblank", chair())
    return "Is this it?"


def go_up(robot):
    robot.approach((3.0, 2.5), chair())
    robot.session.ask(["yellow chair"])
    return "It takes a closer look."


def ask_on(page, robot, card, ask):
    """Have the robot ask something, and wait until it is shown with its picture."""
    says(page, f"#{card}-question", ask(robot))
    says(page, f"#{card}-title", "yellow chair")
    picture = page.locator(f"#{card}-picture")
    until(page, lambda: picture.evaluate("one => one.naturalWidth") == 400)


CARDS = pytest.mark.parametrize(("card", "ask"), [("arrival", arrive), ("candidate", go_up)])


@CARDS
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_small_phone_has_room_for_the_question(
    open_page, server, robot, snapshot, scheme, card, ask
):
    page = open_page(server.url, **touch_screen(320, 700), color_scheme=scheme)
    ask_on(page, robot, card, ask)
    snapshot(page, f"{card}-phone-{scheme}")
    assert page.evaluate("document.documentElement.scrollWidth") <= 320
    stop = box_of(page.locator("#stop"))
    for name in ("yes", "no"):
        answer = box_of(page.locator(f"#{card}-{name}"))
        assert min(answer["width"], answer["height"]) >= 44
        assert answer["y"] + answer["height"] <= stop["y"]
    assert page.complaints == []


@CARDS
def test_on_a_wide_screen_the_question_stands_beside_the_pictures(
    open_page, server, robot, snapshot, card, ask
):
    page = open_page(server.url, viewport={"width": 1280, "height": 900})
    ask_on(page, robot, card, ask)
    snapshot(page, f"{card}-desktop")
    assert box_of(page.locator(f"#{card}"))["x"] > 800
