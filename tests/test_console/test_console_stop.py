"""STOP on the console in a real browser, where the robot does not hear it at once."""

from contextlib import closing

import pytest

from tests.helpers.browsing import (
    box_of,
    says,
    stand_in,
    take_lease,
    touch_screen,
    understood,
    until,
)
from tests.test_console.cut_line import Line
from tests.test_console.person import ask, fingers_on, middle_of
from vizbot.operator.api import sockets


def test_a_stop_is_sent_again_for_as_long_as_nobody_hears_it(page, robot):
    tries = []

    def drop(route):
        tries.append(route)
        route.abort()

    page.clock.install()
    page.route("**/stop", drop)
    page.keyboard.press("Space")
    for told in range(15):
        until(page, lambda: len(tries) > told)  # noqa: B023
        page.clock.fast_forward(500)
        says(page, "#alarm", "STOP has not reached the robot yet.")
    assert not robot.session.stopped.is_set()
    page.unroute("**/stop")
    until(page, robot.session.stopped.is_set)
    page.locator("#alarm").wait_for(state="hidden")
    told = len(robot.session.log.lines())
    page.clock.fast_forward(2000)
    page.wait_for_timeout(200)
    assert len(robot.session.log.lines()) == told


def test_a_stop_that_a_broken_link_swallows_is_sent_as_soon_as_the_link_lives(
    open_page, server, robot
):
    with closing(Line(server.url)) as line:
        page = open_page(line.url)
        page.locator("#link.live").wait_for()
        line.cut()
        page.keyboard.press("Space")
        says(page, "#alarm", "STOP has not reached the robot yet.")
        says(page, "#alarm", "The link to the robot is lost")
        page.wait_for_timeout(4000)
        says(page, "#alarm", "STOP has not reached the robot yet.")
        assert not robot.session.stopped.is_set()
        line.restore()
        page.locator("#link.live").wait_for()
        until(page, robot.session.stopped.is_set)
        page.locator("#alarm").wait_for(state="hidden")
        assert page.complaints == []


def test_a_stop_that_nobody_has_heard_outlives_a_reload_and_is_sent_once(page, robot):
    page.route("**/stop", lambda route: route.abort())
    page.keyboard.press("Space")
    says(page, "#alarm", "STOP has not reached the robot yet.")
    page.reload()
    says(page, "#alarm", "STOP has not reached the robot yet.")
    assert not robot.session.stopped.is_set()
    page.unroute("**/stop")
    until(page, robot.session.stopped.is_set)
    page.locator("#alarm").wait_for(state="hidden")
    stops = robot.session.stops
    page.reload()
    page.locator("#link.live").wait_for()
    page.wait_for_timeout(1000)
    assert robot.session.stops == stops


@pytest.mark.parametrize(
    ("path", "ask_robot"),
    [
        ("said", lambda page: page.locator("#goal").press("Enter")),
        ("explore", lambda page: page.get_by_role("button", name="Explore").click()),
    ],
)
def test_stop_calls_off_what_has_no_answer_yet(page, robot, path, ask_robot):
    held = []
    page.route(f"**/{path}", lambda route: held.append(route))
    page.locator("#goal").fill("sofa")
    ask_robot(page)
    until(page, lambda: held)
    page.keyboard.press("Escape")
    says(page, "#answer", "What you asked was not sent on.")
    until(page, robot.session.stopped.is_set)
    until(page, lambda: held[0].request.failure is not None)
    page.unroute(f"**/{path}")
    assert page.locator("#goal").input_value() == "sofa"
    ask_robot(page)
    says(page, "#answer", "Asked")
    until(page, lambda: not robot.session.stopped.is_set())


SEEN = """
globalThis.seen = Object.assign(new EventTarget(), { height: innerHeight, offsetTop: 0 });
Object.defineProperty(window, "visualViewport", { value: seen });
"""


@pytest.mark.parametrize(("width", "height"), [(360, 640), (1180, 820)], ids=["phone", "tablet"])
def test_stop_is_seen_while_a_keyboard_covers_half_of_the_page(open_page, server, width, height):
    page = open_page("about:blank", **touch_screen(width, height))
    page.add_init_script(SEEN)
    page.goto(server.url)
    meta = page.locator("meta[name=viewport]").get_attribute("content")
    assert "interactive-widget=resizes-content" in meta
    page.locator("#link.live").wait_for()
    stop = page.locator("#stop")
    before = box_of(stop)
    half = height // 2
    for event, part, above in (("resize", half, 0), ("scroll", half, 200), ("resize", height, 0)):
        page.evaluate(
            f"Object.assign(seen, {{ height: {part}, offsetTop: {above} }});"
            f"seen.dispatchEvent(new Event('{event}')); null"
        )
        box = box_of(stop)
        assert above <= box["y"] and box["y"] + box["height"] <= above + part
    assert box == before


def test_a_second_finger_stops_it_while_the_first_drives(open_page, server, robot):
    page = open_page(server.url, **touch_screen(360, 640))
    page.locator("#link.live").wait_for()
    take_lease(page)
    move = fingers_on(page)
    x, y = middle_of(page.locator("#stick"))
    move("touchStart", (x, y))
    move("touchMove", (x, y - 50))
    until(page, lambda: robot.twist.linear > 0)
    move("touchStart", (x, y - 50), middle_of(page.locator("#stop")))
    until(page, robot.session.stopped.is_set)
    until(page, lambda: robot.twist.linear == 0)
    assert page.complaints == []


def test_where_too_many_watch_the_page_says_so_and_its_stop_is_heard(
    open_page, server, robot, monkeypatch
):
    monkeypatch.setattr(sockets, "_MOST_WATCHING", 0)
    page = open_page(server.url)
    says(page, "#alarm", "Too many pages watch the robot already")
    page.wait_for_timeout(3000)
    says(page, "#alarm", "Too many pages watch the robot already")
    page.keyboard.press("Space")
    until(page, robot.session.stopped.is_set)
    monkeypatch.setattr(sockets, "_MOST_WATCHING", 20)
    page.locator("#link.live").wait_for()
    page.locator("#alarm").wait_for(state="hidden")


def test_a_question_that_waited_waits_no_more_after_a_stop(page, robot):
    doubt = understood(question="Did you mean the sofa?", meant="go to the sofa")
    stand_in(page, "/said", lambda _: doubt)
    ask(page, "so far")
    says(page, "#doubt", "Yes")
    page.keyboard.press("Escape")
    page.locator("#doubt").wait_for(state="hidden")
