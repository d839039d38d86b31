"""axe-core finds nothing on the console, in what people meet: by day and night, large and small."""

import pytest

from tests.helpers.browsing import found_by_axe, says, take_lease, touch_screen
from tests.test_console.person import ask
from tests.test_console.test_console_arrival import TITLE, chair


def looking(page, robot):
    says(page, "#activity", "Mapping what it sees")


def searching(page, robot):
    ask(page, "sofa, then the bed")
    says(page, "#goals li.running b", "Sofa")


def driving(page, robot):
    take_lease(page)


def arrived(page, robot):
    robot.arrive("yellow chair", chair())
    says(page, "#arrival-title", TITLE)


def going_up_to_something(page, robot):
    robot.approach((3.0, 2.5), chair())
    robot.session.ask(["yellow chair"])
    says(page, "#candidate-title", "I see something like a yellow chair")


def stopped(page, robot):
    page.keyboard.press("Space")
    says(page, "#activity", "Stopped")


def misunderstood(page, robot):
    ask(page, "make me a sandwich")
    page.locator("#answer:not(:empty)").wait_for()


STATES = (
    looking, searching, driving, going_up_to_something, arrived, stopped, misunderstood
)  # fmt: skip
PAGES = {
    "desktop": {"viewport": {"width": 1280, "height": 800}},
    "desktop, by night": {"viewport": {"width": 1280, "height": 800}, "color_scheme": "dark"},
    "phone, by night": touch_screen(360, 640) | {"color_scheme": "dark"},
}


@pytest.mark.sampled
@pytest.mark.parametrize("settings", PAGES.values(), ids=PAGES)
@pytest.mark.parametrize("state", STATES, ids=lambda state: state.__name__)
def test_axe_finds_nothing(open_page, server, robot, state, settings):
    page = open_page(server.url, **settings)
    page.locator("#link.live").wait_for()
    state(page, robot)
    assert found_by_axe(page) == []


def test_axe_would_find_a_button_without_a_name_and_a_pale_text(page):
    page.evaluate(
        """() => {
            const pale = document.createElement("p");
            pale.textContent = "pale";
            Object.assign(pale.style, { color: "#ddd", background: "#fff" });
            document.querySelector("main").append(document.createElement("button"), pale);
        }"""
    )
    found = " ".join(found_by_axe(page))
    assert "button-name" in found and "color-contrast" in found
