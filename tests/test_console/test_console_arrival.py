"""What the console shows after an arrival, and asks, in a real browser."""

import cv2
import numpy as np
import pytest

from tests.helpers.browsing import box_of, says, touch_screen, until
from tests.helpers.failing import raising
from vizbot.core.errors import ConfigError
from vizbot.operator.figures.image_encoding import jpeg

TITLE = "Found the yellow chair after 50 s, 12 m"


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
    page.get_by_label("Keep this map as").fill("home")
    page.keyboard.press("Enter")
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


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_small_phone_has_room_for_the_question(open_page, server, robot, snapshot, scheme):
    page = open_page(server.url, **touch_screen(320, 700), color_scheme=scheme)
    robot.arrive("a very yellow chair of a very longwindednameunbrokenbyanyblank", chair())
    says(page, "#arrival-question", "Is this it?")
    until(page, lambda: page.locator("#arrival-picture").evaluate("one => one.naturalWidth") == 400)
    snapshot(page, f"arrival-phone-{scheme}")
    assert page.evaluate("document.documentElement.scrollWidth") <= 320
    answers = [box_of(page.locator(name)) for name in ("#arrival-yes", "#arrival-no")]
    stop = box_of(page.locator("#stop"))
    for answer in answers:
        assert min(answer["width"], answer["height"]) >= 44
        assert answer["y"] + answer["height"] <= stop["y"]
    assert page.complaints == []


def test_on_a_wide_screen_the_question_stands_beside_the_pictures(
    open_page, server, robot, snapshot
):
    page = open_page(server.url, viewport={"width": 1280, "height": 900})
    robot.arrive("yellow chair", chair())
    says(page, "#arrival-title", TITLE)
    until(page, lambda: page.locator("#arrival-picture").evaluate("one => one.naturalWidth") == 400)
    snapshot(page, "arrival-desktop")
    assert box_of(page.locator("#arrival"))["x"] > 800
