"""The console in a real browser, on a robot without a world."""

import re
from contextlib import closing

import httpx
import numpy as np
import pytest

from tests.helpers.browsing import box_of, says, stand_in, take_lease, touch_screen, until
from tests.test_console.cut_line import Line
from tests.test_console.person import ask, middle_of, press
from vizbot.core.types import Tracking
from vizbot.objectnav.tasks import Task
from vizbot.operator.api.console_routes import FILES
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service


def test_the_page_is_served_whole_and_may_load_nothing_from_elsewhere(server):
    with httpx.Client(base_url=server.url) as client:
        page = client.get("/")
        assert page.headers["content-type"] == "text/html; charset=utf-8"
        assert "default-src 'self'" in page.headers["content-security-policy"]
        assert "//" not in page.text
        for path, (_, media_type) in FILES.items():
            assert client.get(path).headers["content-type"].startswith(media_type)


def knob(page):
    """Whether the stick's knob is right (1) or left (-1), and below (1) or above (-1)."""
    stick, knob = (middle_of(page.locator(part)) for part in ("#stick", "#knob"))
    return tuple(np.sign(np.round(np.subtract(knob, stick))))


def test_a_person_asks_drives_and_stops(page, robot):
    image = page.locator("figure.shown img")
    until(page, lambda: image.evaluate("image => image.naturalWidth") >= 480)
    says(page, "#battery", "50 %")
    says(page, "#feels", "bump left")
    ask(page, '"a <b>yellow</b> chair"')
    says(page, "#goals li.running b", "A <b>yellow</b> chair")
    says(page, "#activity", "Looking for “a <b>yellow</b> chair”")
    says(page, "#detail", "Exploring")

    take_lease(page)
    says(page, "#activity", "You drive")
    assert re.fullmatch("somebody [0-9a-z]{6}", robot.session.lease.holder)
    page.keyboard.down("w")
    until(page, lambda: robot.twist.linear == 0.2)
    assert knob(page) == (0, -1)
    page.keyboard.down("ArrowLeft")
    until(page, lambda: robot.twist.linear == 0.2 and robot.twist.angular == 0.9)
    page.keyboard.up("w")
    until(page, lambda: robot.twist.linear == 0.0 and robot.twist.angular == 0.9)
    until(page, lambda: knob(page) == (-1, 0))
    page.keyboard.up("ArrowLeft")
    until(page, lambda: robot.rests)
    assert knob(page) == (0, 0)

    page.keyboard.down("w")
    until(page, lambda: not robot.rests)
    page.keyboard.press("Space")
    until(page, lambda: robot.session.stopped.is_set() and robot.session.lease.holder is None)
    says(page, "#activity", "Stopped")
    says(page, "#goals li.poor span", "Stopped by you")
    page.keyboard.up("w")
    until(page, lambda: robot.rests)


def test_the_stick_drives_while_it_is_held_and_leaving_the_page_stops(page, robot):
    take_lease(page)
    page.get_by_role("button", name="Slow").click()
    stick = page.locator("#stick")
    stick.hover()
    page.mouse.down()
    x, y = middle_of(stick)
    page.mouse.move(x, y - box_of(stick)["height"])
    until(page, lambda: robot.twist.linear == pytest.approx(0.1))
    page.mouse.up()
    until(page, lambda: robot.rests)

    for leave in ("new Event('blur')", "new Event('pagehide')"):
        page.keyboard.down("s")
        until(page, lambda: robot.twist.linear == pytest.approx(-0.1))
        page.evaluate(f"window.dispatchEvent({leave})")
        until(page, lambda: robot.rests)
        page.keyboard.up("s")
    until(page, lambda: robot.session.lease.holder is None)


def test_nothing_is_sent_but_one_zero_while_nothing_is_held(open_page, server, robot):
    page = open_page("about:blank")
    sent = []
    page.on(
        "websocket",
        lambda link: (
            "/drive" in link.url and link.on("framesent", lambda frame: sent.append(frame))
        ),
    )
    page.goto(server.url)
    page.locator("#link.live").wait_for()
    take_lease(page)
    page.wait_for_timeout(200)
    assert sent == []
    page.keyboard.down("d")
    until(page, lambda: len(sent) > 3)
    page.keyboard.up("d")
    until(page, lambda: '"linear":0,"angular":0' in sent[-1])
    told = len(sent)
    page.wait_for_timeout(300)
    assert len(sent) == told


def test_who_drives_is_shown_and_the_wheel_is_handed_over(page, robot):
    other = robot.session.take_lease("ada")
    for told, text in (("#holder", "Ada drives by hand."), ("#activity", "Ada drives by hand")):
        until(page, lambda: page.locator(told).inner_text() == text)  # noqa: B023
    page.locator("#name").fill("Bo")
    page.get_by_role("button", name="Take the wheel from ada").click()
    says(page, "#holder", "You drive.")
    assert robot.session.lease.holder == "Bo" and not robot.session.lease.holds(other)
    page.keyboard.down("w")
    until(page, lambda: not robot.rests)
    robot.session.take_lease("Ada", over=True)
    says(page, "#holder", "Ada drives")
    until(page, lambda: robot.rests)
    page.keyboard.up("w")

    page.get_by_role("button", name="Take the wheel from Ada").click()
    says(page, "#holder", "You drive.")
    page.keyboard.down("w")
    until(page, lambda: not robot.rests)
    robot.session.stop("Ada")
    says(page, "#holder", "The robot was stopped.")
    says(page, "#activity", "Stopped")
    until(page, lambda: robot.rests and robot.session.lease.holder is None)
    robot.session.ask(["sofa"])
    says(page, "#holder", "Nobody drives by hand.")
    robot.session.stop("Ada")
    says(page, "#goals li.poor span", "Stopped by Ada")


def test_the_page_says_you_to_its_person_and_asks_once_for_a_name(page, robot):
    for who in ("ada", "somebody 1a2b3c"):
        robot.session.stop(who)
    page.keyboard.press("Space")
    for text in ("stopped by ada", "stopped by somebody else", "stopped by you"):
        page.locator("#log span", has_text=re.compile(f"^{text}$")).wait_for()
    page.get_by_label("Your name").fill("Bo (2)")
    page.keyboard.press("Enter")
    says(page, "#name-shown", "Others see you as Bo (2).")
    robot.session.log.write("wheel", "Bo (2) drives instead of ada")
    says(page, "#log span", "you drive instead of ada")
    robot.session.ask(["bo (2)"])
    robot.session.stop("Bo (2)")
    says(page, "#goals li.poor span", "Stopped by you")
    page.reload()
    says(page, "#name-shown", "Others see you as Bo (2).")
    page.get_by_role("button", name="Change").click()
    page.get_by_label("Your name").fill("")
    page.keyboard.press("Enter")
    says(page, "#name-shown", "Others see you as somebody else.")
    robot.session.take_lease("somebody 1a2b3c")
    says(page, "#holder", "Somebody else drives by hand.")


def test_escape_stops_from_a_text_field_and_space_is_a_letter_there(page, robot):
    page.locator("#goal").focus()
    page.keyboard.type("red sofa")
    assert page.locator("#goal").input_value() == "red sofa"
    assert not robot.session.stopped.is_set()
    page.keyboard.press("Escape")
    until(page, robot.session.stopped.is_set)
    says(page, "#activity", "Stopped")


def test_all_can_be_done_by_keyboard_alone(page, robot):
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "stop"
    page.keyboard.press("Tab")
    page.keyboard.type("lamp")
    press(page, *4 * ["Tab"], "Enter")
    says(page, "#answer", "Asked to explore.")
    press(page, *3 * ["Tab"], "Enter")
    says(page, "#holder", "You drive.")
    page.keyboard.press("Space")
    until(page, robot.session.stopped.is_set)
    assert [task.text for task in robot.session.queue.tasks()] == ["explore"]


def test_a_line_that_breaks_stops_the_robot_is_told_and_comes_back(open_page, server, robot):
    line = Line(server.url)
    page = open_page(line.url)
    page.locator("#link.live").wait_for()
    take_lease(page)
    page.keyboard.down("w")
    until(page, lambda: not robot.rests)
    line.cut()
    until(page, lambda: robot.rests)
    says(page, "#alarm", "The link to the robot is lost")
    says(page, "#holder", "The link broke: the robot has stopped.")
    says(page, "#activity", "Out of touch")
    driven = len(robot.driven)
    line.restore()
    page.locator("#link.live").wait_for()
    page.locator("#alarm").wait_for(state="hidden")
    page.wait_for_timeout(300)
    assert len(robot.driven) == driven
    page.keyboard.up("w")
    page.reload()
    page.locator("#link.live").wait_for()
    assert page.complaints == []
    line.close()


def test_who_gives_the_wheel_back_lets_the_robot_go_on_and_who_closes_the_page_does_not(
    page, robot
):
    robot.session.ask(["sofa"])
    take_lease(page)
    page.get_by_role("button", name="Give the wheel back").click()
    until(page, lambda: robot.session.lease.holder is None)
    assert not robot.session.stopped.is_set()
    take_lease(page)
    page.goto("about:blank")
    until(page, lambda: robot.session.lease.holder is None)
    assert robot.session.stopped.is_set()
    assert robot.session.queue.current().text == "sofa"


def numbers(robot):
    return [task.number for task in robot.session.queue.tasks()]


def test_what_waits_is_moved_and_cancelled_and_what_is_over_asked_again_and_cleared(page, robot):
    robot.session.ask(["sofa", "bed", "sink"])
    assert robot.session.queue.current().text == "sofa"  # it has begun; else any may be the next
    says(page, "#goals li.running b", "Sofa")
    assert not page.get_by_role("button", name="Do bed next").is_visible()
    page.get_by_role("button", name="Do sink next").click()
    until(page, lambda: numbers(robot) == [1, 3, 2])
    page.get_by_role("button", name="Cancel sink").press("Enter")
    says(page, "#goals li.poor b", "Gave up on the sink")
    says(page, "#goals li.poor span", "Called off by")
    assert page.evaluate("document.activeElement.id") == "goals"
    page.get_by_role("button", name="Cancel sofa").click()
    says(page, "#goals li.running b", "Bed")
    page.get_by_role("button", name="Ask again: sink").click()
    until(page, lambda: robot.session.queue.tasks()[-1].number == 4)
    page.get_by_role("button", name="Clear what is over").press("Enter")
    until(page, lambda: numbers(robot) == [2, 4])
    assert page.evaluate("document.activeElement.id") == "goals"


def test_a_press_counts_although_the_list_changes_before_it_is_let_go(page, robot):
    robot.session.ask(["sofa", "bed", "sink"])
    assert robot.session.queue.current().text == "sofa"  # it has begun; else any may be the next
    page.get_by_role("button", name="Do sink next").hover()
    page.mouse.down()
    robot.session.ask(["lamp"])
    says(page, "#goals li:nth-child(4) b", "Lamp")
    page.mouse.up()
    until(page, lambda: numbers(robot) == [1, 3, 2, 4])
    shown = page.locator("#goals li b")
    until(page, lambda: shown.all_text_contents() == ["Sofa", "Sink", "Bed", "Lamp"])


def test_after_a_lost_link_somebody_has_the_robot_go_on(page, robot):
    robot.session.ask(["sofa"])
    robot.session.release_lease(robot.session.take_lease("ann"), given_back=False)
    says(page, "#detail", "It rests until somebody has it go on, or drives.")
    page.get_by_role("button", name="Go on").click()
    until(page, lambda: not robot.session.stopped.is_set())
    page.locator("#go-on").wait_for(state="hidden")
    assert robot.session.queue.current().text == "sofa"


def test_stop_works_even_where_no_script_runs(open_page, server, robot):
    page = open_page(server.url, java_script_enabled=False)
    page.get_by_role("button", name="STOP").click()
    until(page, robot.session.stopped.is_set)


def test_what_a_lost_robot_does_about_it_is_told(page, robot):
    robot.tracking = Tracking.LOST
    says(page, "#tracking", "no, it is lost")
    says(page, "#detail", "asked for something, it looks for its place first")
    robot.session.stop("ann")
    says(page, "#activity", "Stopped")
    says(page, "#detail", "asked for something, it looks for its place first")
    robot.session.ask([Task.FIND_PLACE])
    says(page, "#goals li.running b", "Find its place on the map")
    until(page, lambda: "looks for its place first" not in page.locator("#detail").inner_text())


@pytest.fixture
def locked(robot, tmp_path, monkeypatch):
    """The address of a robot that asks for its token, and the token."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    with Server(robot.session, Service(host="0.0.0.0", port=0)) as server:
        yield server.url.replace("0.0.0.0", "127.0.0.1"), server.token


def use_token(page, token):
    page.get_by_label("This robot answers only").fill(token)
    page.get_by_role("button", name="Use it").click()


def assert_opens(page):
    page.locator("#link.live").wait_for()
    page.locator("#token-form").wait_for(state="hidden")
    assert page.complaints == []


def test_the_token_is_asked_for_and_leaves_the_address(open_page, locked):
    url, token = locked
    page = open_page(f"{url}/?token={token}")
    page.locator("#link.live").wait_for()
    assert page.url == f"{url}/"
    page = open_page(url)
    page.get_by_label("This robot answers only").wait_for()
    use, stop = (box_of(page.locator(part)) for part in ("#token-form button", "#stop"))
    assert use["x"] + use["width"] < stop["x"]
    use_token(page, token)
    assert_opens(page)


def test_a_wrong_token_is_called_wrong_and_nothing_is_told_of_what_was_never_shown(
    open_page, locked
):
    url, token = locked
    page = open_page(url)
    refused, shown = page.locator("#token-refused"), page.locator("figure.shown img").first
    says(page, "#link", "locked")
    assert refused.inner_text() == "" and not shown.is_visible()
    assert page.locator("#activity").inner_text() == "It wants its token"
    assert page.locator("#detail").inner_text() == ""
    for _ in range(2):  # it is said again
        refused.evaluate("one => one.textContent = ''")
        use_token(page, "wrong")
        says(page, "#token-refused", "That is not this robot's token.")
    page = open_page(f"{url}/?token=wrong")
    says(page, "#token-refused", "That is not this robot's token.")
    use_token(page, token)
    page.locator("figure.shown img").first.wait_for(state="visible")
    assert_opens(page)


def test_the_page_tells_a_program_that_has_ended_from_a_link_that_is_lost(open_page, robot):
    with Server(robot.session, Service(port=0)) as server, closing(Line(server.url)) as line:
        cut, watching = open_page(line.url), open_page(server.url)
        for page in (cut, watching):
            page.locator("#link.live").wait_for()
        line.cut()
        says(cut, "#alarm", "as long as its program runs")
    says(watching, "#alarm", "The robot's program has ended")
    says(watching, "#link", "ended")
    watching.wait_for_timeout(3500)  # it tries again meanwhile
    assert "lost" not in watching.locator("#alarm").inner_text()
    with Server(robot.session, Service(port=httpx.URL(server.url).port)):
        watching.locator("#link.live").wait_for()
        watching.locator("#alarm").wait_for(state="hidden")


GAMEPAD = """
globalThis.pad = { connected: true, axes: [0, 0], buttons: [{ pressed: false }] };
navigator.getGamepads = () => [globalThis.pad];
"""


def test_a_gamepad_drives_after_its_rest_and_any_of_its_buttons_stops(page, robot):
    page.evaluate(GAMEPAD + "pad.axes = [0, -1]")
    take_lease(page)
    page.wait_for_timeout(300)
    assert robot.rests
    page.evaluate("pad.axes = [0, 0]")
    page.wait_for_timeout(200)
    page.evaluate("pad.axes = [0, -1]")
    until(page, lambda: robot.twist.linear == pytest.approx(0.2))
    page.evaluate("pad.buttons = [{ pressed: true }]")
    until(page, lambda: robot.session.stopped.is_set() and robot.rests)


@pytest.mark.parametrize("height", [640, 740])
def test_a_phone_held_upright_has_all_in_its_width_and_stop_at_the_thumb(open_page, server, height):
    page = open_page(server.url, **touch_screen(360, height))
    page.locator("#link.live").wait_for()
    assert page.locator("figure:visible").count() == 1
    page.get_by_role("button", name="Map", exact=True).tap()
    page.get_by_alt_text("The map of the floor").wait_for()
    take_lease(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    stop, stick = (box_of(page.locator(name)) for name in ("#stop", "#stick"))
    assert stop["y"] + stop["height"] <= height and stop["width"] > 300 and stop["height"] > 60
    assert stick["y"] + stick["height"] <= stop["y"]


FAULTS_OF_FOCUSED = """() => {
  const [one, stop] = [document.activeElement, document.getElementById("stop")];
  const [box, red] = [one, stop].map((each) => each.getBoundingClientRect());
  const beside = box.right <= red.left || box.bottom <= red.top || box.top >= red.bottom;
  return Object.entries({
    "it is not marked": getComputedStyle(one).outlineStyle === "none",
    "it lies under STOP": one !== stop && !beside,
    "it lies outside": box.top < 0 || box.bottom > innerHeight,
    "it is small": one.matches("button, input") && Math.min(box.width, box.height) < 44,
  }).flatMap(([fault, is]) => (is ? [`${one.id} ${one.textContent}: ${fault}`] : []));
}"""


@pytest.mark.parametrize("settings", [touch_screen(360, 640), {}], ids=["phone", "desktop"])
def test_what_has_the_focus_is_seen_beside_stop_and_large_enough_for_a_finger(
    open_page, server, settings
):
    page = open_page(server.url, **settings)
    says(page, "#activity", "Mapping what it sees")
    met, faults = [], []
    while met[-1:] != ["log"]:
        page.keyboard.press("Tab")
        met.append(page.evaluate("document.activeElement.id"))
        faults += page.evaluate(FAULTS_OF_FOCUSED)
        assert len(met) < 40
    assert faults == []
    assert {"stop", "goal", "talk", "dock", "wheel", "map-new"} <= set(met)


PHRASES = ["kitchen", "kitchen cabinet", "red sofa", "sofa"]


def offered(page):
    return page.locator("#suggestions option").evaluate_all("all => all.map(one => one.value)")


def test_the_last_words_are_completed_to_what_the_map_finds(page):
    stand_in(page, "/map/vocabulary", lambda _: {"phrases": PHRASES})
    goal = page.locator("#goal")
    assert goal.get_attribute("list") == "suggestions"
    goal.fill("k")
    until(page, lambda: offered(page) == ["kitchen", "kitchen cabinet"])
    goal.fill("where is the Red s")
    until(page, lambda: offered(page) == ["where is the red sofa", "where is the Red sofa"])
    goal.fill("sofa, then the kitchen")
    until(page, lambda: offered(page) == ["sofa, then the kitchen cabinet"])
    for text in ("asdf", "", "the "):
        goal.fill(text)
        until(page, lambda: offered(page) == [])


def test_a_robot_that_does_not_answer_offers_nothing(page):
    page.route("**/map/vocabulary", lambda route: route.abort())
    page.locator("#goal").fill("kit")
    until(page, lambda: page.locator("#goal").input_value() == "kit")
    assert offered(page) == []
