"""Where things stand on the console, in every size: in reach, and never under STOP."""

import pytest

from tests.helpers.browsing import box_of, says, take_lease, until
from vizbot.core.observer import Outcome

PHONES = {
    "small": (320, 568),
    "upright": (360, 640),
    "across": (740, 360),
    "small-across": (667, 375),
}
SCREENS = {"tablet": (820, 1180), "laptop": (1280, 720), "wide": (1920, 1080)}
SIZES = PHONES | SCREENS
ASKING = "#goal, #ask-form button"
DRIVING = "#wheel, #stick, #speeds button, figure.shown img"
# The part of each element that no scrolling box around it cuts off.
SEEN = """
const seen = (one) => {
  let { left, top, right, bottom } = one.getBoundingClientRect();
  for (let box = one.parentElement; box; box = box.parentElement) {
    if (getComputedStyle(box).overflowY === "visible") continue;
    const cut = box.getBoundingClientRect();
    [left, top] = [Math.max(left, cut.left), Math.max(top, cut.top)];
    [right, bottom] = [Math.min(right, cut.right), Math.min(bottom, cut.bottom)];
  }
  return { left, top, right, bottom };
};
const shown = (selector) =>
  [...document.querySelectorAll(selector)].filter((one) => one.checkVisibility());
const named = (one) => one.id || one.getAttribute("aria-label") || one.textContent.trim();
"""
SCROLLED_TO = """(share) => {
  for (const box of [document.scrollingElement, ...document.querySelectorAll(".page, .side")]) {
    box.scrollTop = share * (box.scrollHeight - box.clientHeight);
  }
}"""
UNDER_STOP = f"""() => {{
  {SEEN}
  const stop = document.getElementById("stop").getBoundingClientRect();
  return shown("button:not(#stop), input, #stick, #map").filter((one) => {{
    const {{ left, top, right, bottom }} = seen(one);
    const width = Math.min(right, stop.right) - Math.max(left, stop.left);
    const height = Math.min(bottom, stop.bottom) - Math.max(top, stop.top);
    return right > left && bottom > top && width > 0 && height > 0;
  }}).map(named);
}}"""
CUT_OFF = f"""(selector) => {{
  {SEEN}
  return shown(selector).filter((one) => {{
    const [whole, part] = [one.getBoundingClientRect(), seen(one)];
    const edges = ["left", "top", "right", "bottom"];
    const isCut = edges.some((edge) => Math.abs(whole[edge] - part[edge]) > 0.5);
    const [above, below] = [part.top < 0, part.bottom > innerHeight];
    return isCut || above || below || part.left < 0 || part.right > innerWidth;
  }}).map(named);
}}"""


@pytest.fixture(params=SIZES)
def size(request):
    return request.param


@pytest.fixture
def console(open_page, server, size):
    """Opens the page in a size."""

    def console(**settings):
        width, height = SIZES[size]
        touched = {"is_mobile": True, "has_touch": True} if size in PHONES else {}
        viewport = {"width": width, "height": height}
        page = open_page(server.url, viewport=viewport, **touched, **settings)
        page.locator("#link.live").wait_for()
        image = page.locator("figure.shown img")
        until(page, lambda: image.evaluate("image => image.naturalWidth") >= 480)
        return page

    return console


def under_stop(page):
    found = []
    for share in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0):
        page.evaluate(SCROLLED_TO, share)
        found += page.evaluate(UNDER_STOP)
    page.evaluate(SCROLLED_TO, 0.0)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_lies_under_stop_and_all_fits_in_the_width(console, size, robot, snapshot, scheme):
    # Things to show: one that is done, one that runs, two that wait.
    robot.session.ask(["sofa", "bed", "sink", "green plant"])
    robot.session.queue.current()
    robot.session.queue.finish(Outcome.ARRIVED, "92% sure", (2.5, 1.5, 0.4))
    page = console(color_scheme=scheme)
    says(page, "#goals li.running", "Bed")
    snapshot(page, f"layout-{size}-idle-{scheme}")
    assert under_stop(page) == []
    assert page.evaluate(CUT_OFF, ASKING) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= SIZES[size][0]
    take_lease(page)
    snapshot(page, f"layout-{size}-driving-{scheme}")
    assert under_stop(page) == []
    assert page.evaluate(CUT_OFF, DRIVING) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= SIZES[size][0]
    assert page.complaints == []


@pytest.mark.parametrize("size", ["small", "across", "laptop"])
def test_who_drives_has_stick_and_picture_in_sight_while_a_question_waits(console, robot):
    robot.arrive("yellow chair")
    page = console()
    says(page, "#arrival-question", "Is this it?")
    take_lease(page)
    assert page.evaluate(CUT_OFF, DRIVING) == []
    assert under_stop(page) == []


@pytest.mark.parametrize("size", PHONES)
def test_a_picture_that_is_shown_larger_pushes_nothing_under_stop(console, size):
    page = console()
    page.get_by_role("button", name="Map", exact=True).tap()
    page.get_by_role("button", name="Keep-out zones").tap()
    says(page, "#map-said", "Draw over the floor")
    assert under_stop(page) == []
    assert page.evaluate(CUT_OFF, "#map") == []


@pytest.mark.parametrize("size", ["across", "small-across"])
def test_on_a_phone_held_across_the_question_stands_beside_stop(console, size):
    page = console()
    stop, ask = (box_of(page.locator(part)) for part in ("#stop", ".ask"))
    assert 0 < stop["x"] - (ask["x"] + ask["width"]) < 30
    assert stop["width"] >= 96 and stop["height"] > 300
    assert stop["y"] < ask["y"] < stop["y"] + stop["height"]


@pytest.mark.parametrize("size", ["laptop", "wide"])
def test_a_wide_screen_shows_camera_and_map_side_by_side_in_its_whole_width(console, size):
    page = console()
    width, height = SIZES[size]
    camera, floor = (
        box_of(page.locator(part)) for part in ("figure[data-picture=colour] img", "#map")
    )
    assert camera["y"] == floor["y"] and camera["width"] == floor["width"]
    assert camera["width"] > 0.4 * (width - 400)
    assert floor["y"] + floor["height"] < height
    stop = box_of(page.locator("#stop"))
    assert camera["x"] < 20 and width - 20 < stop["x"] + stop["width"] <= width
