"""The console's map in a real browser: places, keep-out zones, saved maps."""

import httpx
import numpy as np
import pytest

from tests.helpers.browsing import (
    MapPicture,
    says,
    stand_in,
    touch_screen,
    understood,
    until,
)
from tests.test_console.person import ask, fingers_on, middle_of, press, save_map, scale_bar, tasks
from vizbot.core.observer import Outcome
from vizbot.objectnav.tasks import Task, Waypoint

CORNERS = (120, 240), (300, 150)
"""Column, row of two corners in the picture of the map."""
SCROLLED = "document.getElementById('page').scrollTop"
CORRIDOR = [[0.5, 0.5], [1.5, 0.5], [1.5, 3.0]]


def spans(zone, corners, within):
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    return np.allclose([zone.min(axis=0), zone.max(axis=0)], [low, high], atol=within)


def draw(page, picture):
    page.get_by_role("button", name="Keep-out zones").click()
    page.mouse.move(*picture.on_page(*CORNERS[0]))
    page.mouse.down()
    page.mouse.move(*picture.on_page(*CORNERS[1]), steps=3)
    page.locator("#overlay .rectangle").wait_for()
    page.mouse.up()


def test_a_place_is_clicked_on_and_the_robot_sent_there_with_one_more_click(page, picture, robot):
    page.mouse.click(*picture.on_page(300, 120))
    says(page, "#map-said", "Chosen:")
    page.get_by_role("button", name="Cancel").click()
    page.locator("#chosen").wait_for(state="hidden")
    page.mouse.click(*picture.on_page(300, 120))
    page.locator("#overlay .chosen:not(.halo)").wait_for()
    assert tasks(robot) == []
    page.get_by_role("button", name="Go here").click()
    says(page, "#answer", "Asked to go to the place on the map.")
    (place,) = tasks(robot)
    assert np.abs(place.xy - picture.on_floor(300, 120)).max() < picture.pixel
    until(page, lambda: page.locator("#overlay .chosen").count() == 0)


def test_the_mark_of_a_place_lies_under_the_finger_and_stays_there_as_the_map_grows(
    page, picture, robot
):
    page.mouse.click(*picture.on_page(300, 120))
    mark = page.locator("#overlay .chosen:not(.halo)")
    assert np.abs(np.subtract(middle_of(mark), picture.on_page(300, 120))).max() < 1.5
    before = mark.get_attribute("transform")
    robot.grow()
    until(page, lambda: mark.get_attribute("transform") != before)
    page.get_by_role("button", name="Go here").click()
    until(page, lambda: tasks(robot) != [])
    assert np.abs(tasks(robot)[0].xy - picture.on_floor(300, 120)).max() < picture.pixel


def test_a_bar_shows_the_scale_of_the_map(page, picture):
    assert page.locator("#overlay .metres").text_content() == "0.5 m"
    assert scale_bar(page) * picture.pixel == pytest.approx(0.5)


def test_a_place_is_chosen_by_keyboard_alone(page, picture, robot):
    page.locator("#map").focus()
    says(page, "#map-said", "Arrow keys move the cross")
    press(page, "ArrowRight", "ArrowRight", "ArrowRight", "Shift+ArrowUp")
    says(page, "#map-said", "The cross is 0.3 m right and 0.5 m up from the robot.")
    page.keyboard.press("Enter")
    says(page, "#map-said", "Chosen: 0.3 m right and 0.5 m up from the robot.")
    press(page, "Tab", "Enter")
    until(page, lambda: tasks(robot) == [Waypoint(2.3, 2.5)])
    assert page.evaluate("document.activeElement.id") == "map"


def test_a_zone_is_drawn_with_the_mouse_listed_and_removed(page, picture, robot):
    draw(page, picture)
    says(page, "#zones", "Zone 1")
    (zone,) = robot.pipeline.keep_out
    assert spans(zone, [picture.on_floor(*corner) for corner in CORNERS], picture.pixel)
    until(page, lambda: page.locator("#overlay .zone").count() == 1)
    page.get_by_role("button", name="Remove zone 1").click()
    until(page, lambda: robot.pipeline.keep_out == ())
    until(page, lambda: page.locator("#overlay .zone").count() == 0)
    page.get_by_role("button", name="Done").click()
    assert tasks(robot) == []


def test_a_zone_is_drawn_by_keyboard_alone(page, picture, robot):
    page.locator("#zones-open").press("Enter")
    press(page, "Shift+ArrowLeft", "Shift+ArrowDown", "Enter")
    says(page, "#map-said", "Now the opposite corner.")
    press(page, "ArrowRight", "Enter")
    says(page, "#map-said", "That is too narrow")
    press(page, "Shift+ArrowRight", "Shift+ArrowUp", "Enter")
    says(page, "#zones", "0.6 m by 0.5 m")
    assert spans(robot.pipeline.keep_out[0], [(1.5, 1.5), (2.1, 2.0)], 0.001)


def test_a_zone_is_drawn_with_a_finger_and_the_page_stays_where_it_is(open_page, server, robot):
    page = open_page(server.url, **touch_screen(360, 640))
    page.get_by_role("button", name="Map", exact=True).tap()
    picture = MapPicture(page, server)
    page.get_by_role("button", name="Keep-out zones").tap()
    before = page.evaluate(SCROLLED)
    move = fingers_on(page)
    (x, y), (to_x, to_y) = (picture.on_page(*corner) for corner in CORNERS)
    move("touchStart", (x, y))
    move("touchMove", (x, to_y))
    move("touchMove", (to_x, to_y))
    move("touchEnd")
    says(page, "#zones", "Zone 1")
    (zone,) = robot.pipeline.keep_out
    assert spans(zone, [picture.on_floor(*corner) for corner in CORNERS], 2 * picture.pixel)
    assert page.evaluate(SCROLLED) == before
    assert page.complaints == []


def test_zones_that_others_draw_appear_and_are_not_lost(page, picture, robot, server):
    httpx.put(f"{server.url}/map/keep-out", json={"zones": [CORRIDOR]}).raise_for_status()
    says(page, "#zones-open", "Keep-out zones (1)")
    draw(page, picture)
    until(page, lambda: len(robot.pipeline.keep_out) == 2)
    np.testing.assert_allclose(robot.pipeline.keep_out[0], CORRIDOR)
    page.get_by_role("button", name="Done").click()
    says(page, "#zones-open", "Keep-out zones (2)")


def test_a_zone_that_comes_while_another_one_is_sent_is_not_lost(page, picture, robot, server):
    def meanwhile(route):
        if route.request.method != "GET":
            httpx.post(f"{server.url}/map/keep-out", json={"corners": CORRIDOR}).raise_for_status()
        route.continue_()

    page.route("**/map/keep-out", meanwhile)
    draw(page, picture)
    says(page, "#zones", "Zone 2")
    page.unroute("**/map/keep-out")
    assert len(robot.pipeline.keep_out) == 2
    page.get_by_role("button", name="Remove zone 1").click()
    until(page, lambda: len(robot.pipeline.keep_out) == 1)
    httpx.put(f"{server.url}/map/keep-out", json={"zones": []}).raise_for_status()


def test_a_map_is_saved_replaced_left_and_used_again(page, robot):
    save_map(page, "ground floor")
    says(page, "#maps-said", "Saved as “ground floor”.")
    says(page, "#maps b", "ground floor")

    page.get_by_label("Save this map as").fill("ground floor")
    page.get_by_role("button", name="Save", exact=True).click()
    says(page, "#maps-question", "There is a map “ground floor” already. Replace it?")
    page.get_by_role("button", name="Replace it").click()
    says(page, "#maps-said", "Saved as “ground floor”.")

    page.get_by_role("button", name="Begin a new map").click()
    page.locator("#maps-no").click()
    assert robot.pipeline.begun == []
    page.get_by_role("button", name="Begin a new map").click()
    page.get_by_role("button", name="Begin", exact=True).click()
    says(page, "#maps-said", "It has begun an empty map. The map it left is saved as “left ")
    assert robot.pipeline.begun == [None]

    robot.session.ask(["sofa"])
    page.get_by_role("button", name="Use ground floor").click()
    page.get_by_role("button", name="Use it").click()
    says(page, "#maps-said", "Not done: the robot has something to do")
    page.keyboard.press("Escape")
    says(page, "#goals li.poor b", "Gave up on the sofa")
    says(page, "#goals li.poor span", "Stopped by")
    page.get_by_role("button", name="Use ground floor").click()
    page.get_by_role("button", name="Use it").click()
    says(page, "#maps-said", "It goes on in “ground floor”.")
    assert len(robot.pipeline.begun) == 2


def test_what_is_no_name_is_asked_for_again(page):
    save_map(page, "../home")
    says(page, "#maps-said", "Give it a name of letters")
    says(page, "#maps", "None yet.")


def test_a_question_is_answered_with_yes_or_no_and_its_place_is_marked(page, picture):
    asked = []

    def answer(request):
        asked.append(request.post_data_json)
        if asked[-1]["text"] == "where is the sofa":
            return understood("The sofa is in the living room.", place=[3.0, 2.5])
        return understood(question="did you mean “sofa”?", meant="where is the sofa")

    stand_in(page, "/said", answer)
    page.locator("#goal").fill("where is the sopha")
    page.get_by_role("button", name="Now instead").click()
    says(page, "#answer", "did you mean “sofa”?")
    page.get_by_role("button", name="No", exact=True).click()
    says(page, "#answer", "Nothing was asked for.")
    ask(page, "where is the sopha")
    page.get_by_role("button", name="Yes", exact=True).click()
    says(page, "#answer", "The sofa is in the living room.")
    page.locator("#doubt").wait_for(state="hidden")
    assert [(one["text"][-5:], one["at_once"]) for one in asked] == [
        ("sopha", True), ("sopha", False), (" sofa", False)
    ]  # fmt: skip
    np.testing.assert_allclose(marked(page, picture), [3.0, 2.5], atol=1e-6)


def marked(page, picture):
    """Where the page has put its pin, on the floor [m]."""
    shift = page.locator("#overlay .pin").get_attribute("transform")
    column, row = (float(number) for number in shift[len("translate(") : -1].split(","))
    return picture.on_floor(column, row)


def test_where_something_was_found_is_shown_until_the_map_is_left(page, picture, robot):
    robot.session.ask(["sofa"])
    robot.session.queue.current()
    robot.session.queue.finish(Outcome.ARRIVED, "92% sure", (3.0, 2.5, 0.4))
    page.get_by_role("button", name="Show sofa on the map").click()
    np.testing.assert_allclose(marked(page, picture), [3.0, 2.5], atol=1e-6)
    robot.session.queue.forget_places()
    page.get_by_role("button", name="Show sofa on the map").wait_for(state="detached")
    says(page, "#goals li.good", "92% sure")


def test_the_robot_is_sent_back_and_to_its_dock(page, robot):
    page.get_by_role("button", name="Come back").click()
    says(page, "#answer", "Asked to come back.")
    page.get_by_role("button", name="Dock").click()
    says(page, "#answer", "Asked to go to its charger.")
    assert tasks(robot) == [Task.COME_BACK, Task.DOCK]
    ask(page, "go to the sofa, then come back")
    says(page, "#answer", "Asked for: go to sofa, then come back")
    assert tasks(robot)[2:] == ["sofa", Task.COME_BACK]
    ask(page, "stop")
    says(page, "#answer", "Stopped")
    says(page, "#goals", "Not done: stopped by you")
