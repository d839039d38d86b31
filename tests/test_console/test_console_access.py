"""The console can be used by everybody: names, contrast, sizes, seen focus."""

import pytest

from tests.helpers.browsing import says, take_lease, until
from tests.test_console.person import save_map
from vizbot.core.observer import Outcome
from vizbot.core.types import BaseMode

NAMELESS = """() => {
  const ofIds = (ids) =>
    ids.split(" ").map((id) => document.getElementById(id)?.textContent ?? "").join("");
  const nameOf = (one) => [
    one.getAttribute("aria-label"),
    ofIds(one.getAttribute("aria-labelledby") ?? ""),
    one.getAttribute("alt"),
    [...(one.labels ?? [])].map((label) => label.textContent).join(""),
    one.matches("button, a") && one.textContent,
  ].find((name) => name && name.trim());
  const needing = "button, a, input, img, [tabindex='0'], [role=img], [role=group], section";
  return [...document.querySelectorAll(needing)]
    .filter((one) => !one.matches("img[alt='']") && !nameOf(one) && one.checkVisibility())
    .map((one) => one.outerHTML.slice(0, 90));
}"""
REPEATED_IDS = """() => {
  const ids = [...document.querySelectorAll("[id]")].map((one) => one.id);
  return ids.filter((id, index) => ids.indexOf(id) !== index);
}"""
# By WCAG 2: of each text that is shown to the ground on which it stands.
FAINT = """() => {
  const numbers = (colour) => {
    const [red = 0, green = 0, blue = 0, opacity = 1] = colour.match(/[\\d.]+/g).map(Number);
    return [red, green, blue, opacity];
  };
  const over = ([red, green, blue, a], below) =>
    [red, green, blue].map((value, index) => a * value + (1 - a) * below[index]);
  const groundOf = (one) => {
    const layers = [];
    for (let box = one; box; box = box.parentElement) {
      layers.push(numbers(getComputedStyle(box).backgroundColor));
    }
    return layers.reverse().reduce((below, layer) => over(layer, below), [255, 255, 255]);
  };
  const luminance = (colour) => {
    const [r, g, b] = colour.map((value) => value / 255)
      .map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (one, style) => {
    const ground = groundOf(one);
    const both = [ground, over(numbers(style.color), ground)].map(luminance);
    const [dark, light] = [Math.min(...both), Math.max(...both)];
    return (light + 0.05) / (dark + 0.05);
  };
  const hasText = (one) =>
    [...one.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
  const texts = [...document.querySelectorAll("body *")].filter((one) =>
    !one.closest("svg, noscript, :disabled") && one.checkVisibility() && hasText(one));
  const styled = [
    ...texts.map((one) => [one, getComputedStyle(one)]),
    ...[...document.querySelectorAll("input")].flatMap((one) => [
      [one, getComputedStyle(one)], [one, getComputedStyle(one, "::placeholder")]]),
  ];
  return styled.map(([one, style]) => [contrast(one, style), one])
    .filter(([value]) => value < 4.5)
    .map(([value, one]) => `${value.toFixed(2)} ${one.id || one.className} ${one.textContent}`);
}"""
SMALL = """(selector) => [...document.querySelectorAll(selector)]
  .filter((one) => one.checkVisibility())
  .map((one) => [one, one.getBoundingClientRect()])
  .filter(([, box]) => Math.min(box.width, box.height) < 43.9)
  .map(([one, box]) => `${one.id} ${one.textContent.trim()} ${box.width} ${box.height}`)"""


@pytest.fixture(params=["light", "dark"])
def page(request, open_page, server, robot):
    """A page on which much is shown."""
    page = open_page(server.url, color_scheme=request.param)
    page.locator("#link.live").wait_for()
    robot.session.ask(["sofa", "bed", "sink", "plant"])
    for outcome in (Outcome.ARRIVED, Outcome.GAVE_UP):
        robot.session.queue.current()
        robot.session.queue.finish(outcome, "92% sure", (2.5, 1.5, 0.4))
    says(page, "#goals li.running", "Sink")
    save_map(page, "home")
    says(page, "#maps b", "home")
    yield page
    assert page.complaints == []


def open_everything(page, robot):
    """Questions, alarms, zones, a chosen place: whatever is hidden else."""
    page.get_by_role("button", name="Begin a new map").click()
    page.get_by_role("button", name="Rename home").click()
    page.locator("#map").click(position={"x": 100, "y": 100})
    says(page, "#map-said", "Chosen:")
    robot.session.stop("ann")
    until(page, lambda: robot.session.queue.current() is None)
    robot.arrive("yellow chair")
    says(page, "#arrival-title", "Found the yellow chair")
    state = robot.session.robot.base_state()
    robot.session.robot.base_state = lambda: type(state)(
        0.0, state.T_odom_base, True, False, (True,) * 4, (False, False), 0.1, BaseMode.PASSIVE
    )
    says(page, "#held-why", "stopped at an edge")


def test_all_that_is_shown_has_a_name(page, robot):
    open_everything(page, robot)
    take_lease(page)
    assert page.evaluate(NAMELESS) == []
    assert page.evaluate(REPEATED_IDS) == []
    assert page.evaluate("document.documentElement.lang") == "en"


def test_all_text_stands_out_from_its_ground(page, robot):
    assert page.evaluate(FAINT) == []
    open_everything(page, robot)
    assert page.evaluate(FAINT) == []
    take_lease(page)
    assert page.evaluate(FAINT) == []
    page.evaluate("document.getElementById('token-form').hidden = false")
    assert page.evaluate(FAINT) == []


def test_what_is_faint_would_be_found(page):
    page.evaluate("document.getElementById('detail').style.color = '#7a7a7a'")
    until(page, lambda: any("detail" in each for each in page.evaluate(FAINT)))


def test_all_that_is_pressed_is_as_large_as_a_finger(page, robot):
    open_everything(page, robot)
    assert page.evaluate(SMALL, "button, input") == []
    take_lease(page)
    assert page.evaluate(SMALL, "button, input, #stick") == []
