"""The console's map is turned to the walls, enlarged and moved, and pointing at it goes along."""

import numpy as np
import pytest

from tests.helpers.boxes import ASKEW_MIDDLE, askew_room
from tests.helpers.browsing import MapPicture, box_of, says, stand_in, touch_screen, until
from tests.test_console.person import fingers_on, middle_of, press, scale_bar, tasks
from vizbot.objectnav.tasks import Waypoint

ANGLE = 0.4
PHONE = touch_screen(360, 740)


@pytest.fixture
def turned(page, picture, robot):
    """The map of a room whose walls lie askew."""
    robot.see(askew_room(ANGLE))

    def is_turned():
        picture.update()
        return picture.turn != 0.0

    until(page, is_turned)
    assert picture.turn == pytest.approx(ANGLE, abs=0.02)
    shown = page.locator("#overlay .metres")
    until(page, lambda: shown.text_content() == "2 m")  # the page has that view, too
    return picture


def went(page, robot):
    """Where the robot is sent once there is a place to send it to."""
    says(page, "#map-said", "Chosen:")
    page.get_by_role("button", name="Go here").click()
    until(page, lambda: tasks(robot) != [])
    (place,) = tasks(robot)
    return place.xy


def width(page):
    return box_of(page.locator("#map img"))["width"]


def enlarge(page, picture, at, times=3):
    """By the wheel; the page rests as it is."""
    before = width(page)
    x, y = picture.on_page(*at)
    page.mouse.move(x, y)
    for _ in range(times):
        page.mouse.wheel(0, -200)
    until(page, lambda: width(page) > 1.3**times * before)
    return x, y


def drag(page, start, end):
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(*end, steps=4)
    page.mouse.up()


def test_a_click_on_a_turned_map_goes_where_it_points(page, turned, robot):
    page.mouse.click(*turned.on_page(300, 120))
    np.testing.assert_allclose(went(page, robot), turned.on_floor(300, 120), atol=turned.pixel)


def test_marks_lie_on_a_turned_map_where_they_are(page, turned, robot):
    stand_in(
        page, "/map/rooms", lambda _: {"rooms": [{"name": "study", "position": [*ASKEW_MIDDLE]}]}
    )
    robot.session.log.write("map", "another line")  # it is read anew
    says(page, "#overlay .room", "study")
    middle = middle_of(page.locator("#overlay .room"))
    np.testing.assert_allclose(turned.seen_at(*middle), ASKEW_MIDDLE, atol=3 * turned.pixel)


def test_the_cross_moves_along_the_walls_of_a_turned_map(page, turned, robot):
    page.locator("#map").focus()
    press(page, "ArrowRight", "ArrowRight", "Shift+ArrowUp")
    says(page, "#map-said", "The cross is 0.2 m right and 0.5 m up from the robot.")
    page.keyboard.press("Enter")
    expected = np.array([2.0, 2.0]) + turned.along(0.2, 0.5)
    np.testing.assert_allclose(went(page, robot), expected, atol=0.003)


def test_a_zone_is_upright_on_a_turned_map(page, turned, robot):
    page.get_by_role("button", name="Keep-out zones").click()
    drag(page, turned.on_page(150, 240), turned.on_page(300, 150))
    says(page, "#zones", "Zone 1")
    (zone,) = robot.pipeline.keep_out
    pixels = [(150, 240), (300, 240), (300, 150), (150, 150)]
    expected = [turned.on_floor(*pixel) for pixel in pixels]
    assert all(np.linalg.norm(zone - corner, axis=1).min() < turned.pixel for corner in expected)
    says(page, "#zones", f"{150 * turned.pixel:.1f} m by {90 * turned.pixel:.1f} m")
    box = box_of(page.locator("#overlay .zone"))
    low, high = turned.on_page(150, 150), turned.on_page(300, 240)
    found = [box["x"], box["y"], box["x"] + box["width"], box["y"] + box["height"]]
    np.testing.assert_allclose(found, [*low, *high], atol=3)


def test_the_wheel_enlarges_about_the_pointer_and_a_click_goes_where_it_points(page, turned, robot):
    before = turned.on_floor(300, 120)
    x, y = enlarge(page, turned, (300, 120))
    np.testing.assert_allclose(turned.seen_at(x, y), before, atol=turned.pixel)
    expected = turned.seen_at(x + 60, y - 40)
    page.mouse.click(x + 60, y - 40)
    middle = middle_of(page.locator("#overlay .chosen:not(.halo)"))
    np.testing.assert_allclose(middle, [x + 60, y - 40], atol=1.5)
    np.testing.assert_allclose(went(page, robot), expected, atol=turned.pixel / 2)


def test_the_page_scrolls_by_the_wheel_where_the_whole_map_is_seen(page, picture):
    page.mouse.move(*picture.on_page(240, 180))
    page.mouse.wheel(0, 300)
    until(page, lambda: page.evaluate("scrollY") > 100)
    assert page.locator("#map.enlarged").count() == 0


def test_a_drag_moves_an_enlarged_map_and_chooses_nothing(page, picture, robot):
    x, y = enlarge(page, picture, (240, 180))
    before = picture.seen_at(x, y)
    drag(page, (x, y), (x + 50, y + 30))
    np.testing.assert_allclose(picture.seen_at(x + 50, y + 30), before, atol=picture.pixel)
    assert page.locator("#chosen").is_hidden()
    page.mouse.click(x + 50, y + 30)
    np.testing.assert_allclose(went(page, robot), before, atol=picture.pixel)


def test_a_map_stays_in_its_frame(page, picture):
    x, y = enlarge(page, picture, (240, 180))
    for way in (2000, -2000):
        drag(page, (x, y), (x + way, y + way))
        image, frame = (box_of(page.locator(part)) for part in ("#map img", "#map"))
        for start, size in (("x", "width"), ("y", "height")):
            assert image[start] <= frame[start] + 0.5
            assert image[start] + image[size] >= frame[start] + frame[size] - 0.5


def test_keys_and_buttons_enlarge_and_reduce_and_show_all(page, picture):
    whole = width(page)
    page.locator("#map").focus()
    for key, share in (("+", 1.5), ("+", 2.25), ("-", 1.5), ("0", 1.0), ("-", 1.0)):
        page.keyboard.press(key)
        assert width(page) == pytest.approx(share * whole, rel=0.01)
    for name, share in (("Enlarge", 1.5), ("Enlarge", 2.25), ("Reduce", 1.5)):
        page.get_by_role("button", name=name, exact=True).click()
        assert width(page) == pytest.approx(share * whole, rel=0.01)
    page.get_by_role("button", name="Show the whole map").click()
    assert width(page) == pytest.approx(whole)
    for _ in range(12):
        page.get_by_role("button", name="Enlarge", exact=True).click()
    assert width(page) == pytest.approx(10 * whole, rel=0.01)


def test_the_bar_and_marks_keep_their_size_while_the_map_is_enlarged(page, picture):
    page.mouse.click(*picture.on_page(240, 180))
    mark = page.locator("#overlay .chosen:not(.halo)")
    size = box_of(mark)["width"]
    page.locator("#map").press("+")
    page.locator("#map").press("+")
    assert box_of(mark)["width"] == pytest.approx(size, abs=0.5)
    metres = float(page.locator("#overlay .metres").text_content().removesuffix(" m"))
    pixels = scale_bar(page)
    assert pixels * picture.pixel / 2.25 == pytest.approx(metres)
    assert pixels <= 120 or metres == 0.5


def test_the_cross_is_kept_in_the_part_that_is_shown(page, picture):
    page.locator("#map").focus()
    press(page, *3 * ["+"], *3 * ["Shift+ArrowRight"])
    middle, _ = middle_of(page.locator("#overlay .cross.halo"))
    frame = box_of(page.locator("#map"))
    assert frame["x"] < middle < frame["x"] + frame["width"]


def test_an_enlarged_map_shows_the_same_floor_when_the_map_grows(page, picture, robot):
    x, y = enlarge(page, picture, (240, 180))
    before = picture.seen_at(x, y)
    metres = width(page) * picture.pixel
    robot.grow()
    until(page, lambda: picture.update() or width(page) * picture.pixel != metres)
    until(page, lambda: np.abs(picture.seen_at(x, y) - before).max() < 2 * picture.pixel)


def test_a_zone_is_drawn_on_an_enlarged_map(page, picture, robot):
    page.get_by_role("button", name="Keep-out zones").click()
    x, y = enlarge(page, picture, (200, 200))
    low, high = picture.seen_at(x - 40, y + 30), picture.seen_at(x + 60, y - 50)
    drag(page, (x - 40, y + 30), (x + 60, y - 50))
    says(page, "#zones", "Zone 1")
    (zone,) = robot.pipeline.keep_out
    np.testing.assert_allclose([zone.min(axis=0), zone.max(axis=0)], [low, high], atol=0.02)


@pytest.fixture
def fingers(open_page, server):
    """A phone that shows the map, and what moves fingers on it."""
    page = open_page(server.url, **PHONE)
    page.get_by_role("button", name="Map", exact=True).tap()
    picture = MapPicture(page, server)
    yield page, picture, fingers_on(page)
    assert page.complaints == []


def test_two_fingers_enlarge_the_map_and_one_moves_it(fingers, robot):
    page, picture, move = fingers
    whole = width(page)
    x, y = picture.on_page(240, 180)
    before = picture.seen_at(x, y)
    move("touchStart", (x - 20, y))
    move("touchStart", (x - 20, y), (x + 20, y))
    for reach in (30, 45, 60):
        move("touchMove", (x - reach, y), (x + reach, y))
    move("touchEnd")
    until(page, lambda: width(page) == pytest.approx(3 * whole, rel=0.05))
    np.testing.assert_allclose(picture.seen_at(x, y), before, atol=2 * picture.pixel)
    assert page.evaluate("visualViewport.scale") == 1
    assert page.locator("#chosen").is_hidden()

    move("touchStart", (x, y))
    for shift in (15, 30, 40):
        move("touchMove", (x + shift, y))
    move("touchEnd")
    until(page, lambda: np.abs(picture.seen_at(x + 40, y) - before).max() < 2 * picture.pixel)
    page.touchscreen.tap(x + 40, y)
    np.testing.assert_allclose(went(page, robot), before, atol=2 * picture.pixel)


def test_two_fingers_draw_no_zone(fingers, robot):
    page, picture, move = fingers
    page.get_by_role("button", name="Keep-out zones").tap()
    whole = width(page)
    x, y = picture.on_page(240, 180)
    move("touchStart", (x - 20, y))
    move("touchStart", (x - 20, y), (x + 20, y + 20))
    move("touchMove", (x - 60, y - 20), (x + 60, y + 60))
    move("touchEnd")
    until(page, lambda: width(page) > 1.5 * whole)
    assert page.locator("#overlay .rectangle").count() == 0
    assert robot.pipeline.keep_out == ()


def test_a_robot_that_is_sent_to_a_place_by_keyboard_goes_there_on_an_enlarged_map(
    page, picture, robot
):
    page.locator("#map").focus()
    press(page, "+", "Shift+ArrowRight", "Enter")
    page.get_by_role("button", name="Go here").press("Enter")
    until(page, lambda: tasks(robot) == [Waypoint(2.5, 2.0)])
