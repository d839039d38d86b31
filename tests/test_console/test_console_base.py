"""What the console tells of the base in a real browser, and what it does about it."""

from dataclasses import replace

import pytest

from tests.helpers.browsing import box_of, says, take_lease, touch_screen, until
from vizbot.behaviours.safety import MAYBE_MOVED
from vizbot.core.observer import Outcome
from vizbot.core.types import BaseMode, Charging

EDGE = {"cliffs": (False, True, False, False)}
LIFTED = {"wheel_drops": (True, False)}


def feel(robot, **felt):
    state = replace(robot.session.robot.base_state(), **felt)
    robot.session.robot.base_state = lambda: state


@pytest.fixture
def resumed(robot):
    """How often the base was asked to obey again; it does once it is on the floor."""
    resumed = []

    def resume():
        resumed.append(True)
        feel(robot, mode=BaseMode.SAFE)

    robot.session.robot.resume_base = resume
    return resumed


@pytest.mark.parametrize(
    ("felt", "why"),
    [
        (LIFTED, "stopped because it was lifted. Put it on the floor."),
        (EDGE, "stopped at an edge. Put it on the floor away from there"),
        ({"plugged_in": True}, "Pull out its cable."),
        ({}, "stopped by an edge, by being lifted, or by a button on it. Put it on the floor."),
    ],
)
def test_a_base_that_was_stopped_at_an_edge_or_lifted_is_let_drive_again(
    page, robot, resumed, felt, why
):
    again = page.get_by_role("button", name="Let it drive again")
    says(page, "#mode", "ready")
    assert not again.is_visible()
    feel(robot, mode=BaseMode.PASSIVE, **felt)
    says(page, "#held-why", why)
    again.click()
    says(page, "#answer", "Asked to let it drive again.")
    again.wait_for(state="hidden")
    assert resumed == [True]


def test_a_base_that_charges_is_left_alone_unless_somebody_drives(page, robot, resumed):
    feel(robot, mode=BaseMode.PASSIVE, docked=True, charging=Charging.TRICKLE)
    feel(robot, bump_left=False)
    says(page, "#feels:not(.alarming)", "on charger")
    assert not page.locator("#held").is_visible()
    take_lease(page)
    says(page, "#held-why", "stands on its charger")
    page.get_by_role("button", name="Let it drive again").click()
    page.locator("#held").wait_for(state="hidden")


def test_a_robot_that_may_have_been_moved_asks_whether_to_go_on(page, robot, resumed):
    robot.session.ask(["sofa"])
    assert not page.locator("#asks").is_visible()
    feel(robot, mode=BaseMode.PASSIVE, maybe_moved=True)
    robot.question = MAYBE_MOVED
    says(page, "#asks-what", "Somebody may have moved me: go on?")
    assert not page.locator("#held").is_visible()
    page.locator("#asks-go-on").click()
    says(page, "#answer", "Asked to go on: it sees where it is first.")
    until(page, lambda: resumed == [True])
    robot.question = None
    page.locator("#asks").wait_for(state="hidden")
    assert robot.session.queue.tasks()[0].outcome is None


def test_nobody_is_told_to_launch_again(page, robot):
    robot.session.ask(["sofa"])
    reason = "the base does not obey since it was lifted; press Clean and launch again"
    robot.session.queue.current()
    robot.session.queue.finish(Outcome.GAVE_UP, reason)
    robot.session.log.write("ended", f"sofa: gave up ({reason})")
    told = "the base does not obey since it was lifted; let it drive again"
    says(page, "#goals li.poor b", "Gave up on the sofa")
    says(page, "#goals li.poor span", told)
    says(page, "#log li", told)


def test_how_sure_the_robot_is_is_told(page, robot):
    robot.session.ask(["sofa"])
    robot.session.queue.current()
    robot.session.queue.finish(Outcome.ARRIVED, "92% sure, seen from near by")
    says(page, "#goals li.good b", "Found the sofa")
    says(page, "#goals li.good span", "92% sure, seen from near by")


def test_of_a_base_that_is_silent_nothing_is_known_and_its_charge_stays_for_a_while(page, robot):
    says(page, "#feels", "bump left")
    page.clock.install()
    robot.session.robot.base_state = lambda: None
    for fact in ("#mode", "#feels"):
        until(page, lambda: page.locator(fact).inner_text() == "unknown")  # noqa: B023
    assert page.locator("#battery").inner_text() == "50 %"
    page.clock.fast_forward(10_000)
    until(page, lambda: page.locator("#battery").inner_text() == "unknown")


def test_the_log_tells_in_words_alone_and_a_phone_has_room_for_them(open_page, server, robot):
    page = open_page(server.url, **touch_screen(360, 640))
    robot.session.log.write(
        "ended", "sofa: not found (nothing like it in all that the robot has seen)"
    )
    line = page.locator("#log li", has_text="nothing like it")
    line.wait_for()
    assert line.locator("> *").count() == 2
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    text = box_of(line.locator("span"))
    assert text["width"] > 150 and text["x"] + text["width"] <= 360
