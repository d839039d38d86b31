"""Push-to-talk in a real browser whose microphone is simulated, up to what the robot does."""

import pytest

from tests.helpers.browsing import (
    KEPT_BROWSER,
    MICROPHONE,
    chromium,
    says,
    stand_in,
    take_lease,
    understood,
    until,
)
from tests.helpers.spoken import SpokenSample, record, speaking
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.voice.sound import read_sound

HOLD = "Hold to talk"
COUNT_MICROPHONES = """
globalThis.streams = [];
const given = navigator.mediaDevices.getUserMedia.bind(navigator.mediaDevices);
navigator.mediaDevices.getUserMedia = async (wanted) => {
  const stream = await given(wanted);
  streams.push(stream);
  return stream;
};
null
"""
OPEN_MICROPHONES = """
streams.flatMap((one) => one.getTracks()).filter((track) => track.readyState === "live").length
"""


@pytest.fixture
def browser():
    return KEPT_BROWSER.started(*MICROPHONE)


@pytest.fixture
def page(page):
    page.evaluate(COUNT_MICROPHONES)
    return page


@pytest.fixture
def recordings(page):
    """What has come to the robot, which understands the same each time."""
    recordings = []

    def hear(request):
        recordings.append((request.headers["content-type"], request.post_data_buffer))
        return understood("The sofa is in the living room.", heard="where is the sofa")

    stand_in(page, "/heard", hear)
    return recordings


def microphone_is_closed(page):
    return page.evaluate(OPEN_MICROPHONES) == 0


def hold_key(page):
    page.keyboard.down("t")
    says(page, "#answer", "Listening.")


def hold_button(page):
    page.locator("#talk").hover()
    page.mouse.down()
    says(page, "#answer", "Listening.")
    assert page.locator("#talk[aria-pressed=true]").inner_text().startswith("Let go to send")


def test_what_is_said_while_the_button_is_held_is_sent_and_understood(page, recordings):
    hold_button(page)
    assert not microphone_is_closed(page)
    page.wait_for_timeout(500)  # what is shorter than a tenth of a second holds no sound
    page.mouse.up()
    says(page, "#answer", "Heard: “where is the sofa”")
    says(page, "#answer", "The sofa is in the living room.")
    says(page, "#talk", HOLD)
    ((kind, sound),) = recordings
    assert kind.startswith("audio/webm") and len(read_sound(sound)) > 0
    assert microphone_is_closed(page)


def test_a_key_talks_too_but_not_in_a_text_field(page, recordings):
    page.keyboard.down("t")
    hold_key(page)
    page.keyboard.up("t")
    says(page, "#answer", "Heard:")
    page.locator("#goal").focus()
    page.keyboard.type("to the sofa")
    page.keyboard.press("Tab")
    page.locator("#talk").focus()
    page.keyboard.down("Enter")
    says(page, "#answer", "Listening.")
    page.keyboard.up("Enter")
    until(page, lambda: len(recordings) == 2)
    assert page.locator("#goal").input_value() == "to the sofa"


def test_stop_works_while_somebody_talks_and_nothing_is_sent(page, robot, recordings):
    for stop in (
        lambda: page.keyboard.press("Space"),
        lambda: page.locator("#stop").click(),
    ):
        robot.session.ask(["sofa"])
        until(page, lambda: not robot.session.stopped.is_set())
        hold_key(page)
        stop()
        until(page, robot.session.stopped.is_set)
        says(page, "#answer", "What you said was not sent.")
        page.keyboard.up("t")
        until(page, lambda: microphone_is_closed(page))
        robot.session.go_on()
    assert recordings == []


def test_stop_calls_off_what_is_still_being_worked_out(page, robot):
    held = []
    page.route("**/heard?*", lambda route: held.append(route))
    hold_key(page)
    page.keyboard.up("t")
    says(page, "#answer", "Working out what you said.")
    until(page, lambda: held)
    page.keyboard.press("Space")
    says(page, "#answer", "What you asked was not sent on.")
    until(page, robot.session.stopped.is_set)
    until(page, lambda: held[0].request.failure is not None)


@pytest.mark.parametrize("leave", ["window.dispatchEvent(new Event('blur'))", "hide()"])
def test_who_leaves_the_page_is_not_heard(page, recordings, leave):
    page.evaluate(
        "globalThis.hide = () => document.dispatchEvent(new Event('visibilitychange')); null"
    )
    hold_key(page)
    page.evaluate(leave)
    says(page, "#answer", "What you said was not sent.")
    page.keyboard.up("t")
    until(page, lambda: microphone_is_closed(page))
    assert recordings == []


def test_nobody_is_listened_to_for_longer_than_a_quarter_of_a_minute(page, recordings):
    page.clock.install()
    hold_button(page)
    page.clock.fast_forward(10_000)
    assert recordings == []
    page.clock.fast_forward(5_000)
    until(page, lambda: len(recordings) == 1)
    page.mouse.up()
    assert microphone_is_closed(page)
    assert len(recordings) == 1


def test_a_key_that_is_let_go_before_the_microphone_is_there_sends_nothing(page, recordings):
    page.evaluate(
        "const open = navigator.mediaDevices.getUserMedia;"
        "navigator.mediaDevices.getUserMedia = (wanted) => new Promise((given) => {"
        "  globalThis.give = () => given(open(wanted)); }); null"
    )
    page.keyboard.down("t")
    says(page, "#talk", "Just a moment")
    page.keyboard.up("t")
    says(page, "#answer", "Hold it for as long as you speak.")
    page.evaluate("give()")
    until(page, lambda: page.evaluate("streams.length") == 1 and microphone_is_closed(page))
    assert recordings == []


def test_it_says_why_it_does_not_listen(page, recordings):
    page.evaluate(
        "navigator.mediaDevices.getUserMedia ="
        " () => Promise.reject(new DOMException('no', 'NotAllowedError')); null"
    )
    page.keyboard.press("t")
    says(page, "#answer", "This page may not use the microphone")
    says(page, "#talk", HOLD)
    page.route(
        "**/heard?*", lambda route: route.fulfill(status=503, json={"detail": "no speech model"})
    )
    page.reload()
    page.locator("#link.live").wait_for()
    hold_button(page)
    page.mouse.up()
    says(page, "#answer", "Not asked: no speech model.")


def test_who_drives_may_talk(page, robot, recordings):
    take_lease(page)
    page.keyboard.down("w")
    hold_key(page)
    until(page, lambda: not robot.rests)
    page.keyboard.up("t")
    says(page, "#answer", "Heard:")
    until(page, lambda: not robot.rests)
    page.keyboard.up("w")
    until(page, lambda: robot.rests)
    assert len(recordings) == 1


def test_where_the_browser_gives_no_microphone_the_page_says_why(open_page, server):
    page = open_page("about:blank")
    page.add_init_script("Object.defineProperty(window, 'isSecureContext', { value: false })")
    page.goto(server.url)
    says(page, "#no-talk", "on the robot's own machine or over https")
    page.locator("#talk").wait_for(state="hidden")
    page.keyboard.press("t")
    assert page.locator("#answer").inner_text() == ""
    assert page.complaints == []


def test_the_microphone_is_allowed_for_this_page_alone(page):
    headers = page.request.get(page.url).headers
    assert headers["permissions-policy"] == "microphone=(self)"


def test_a_spoken_yes_answers_the_question_that_waits(page):
    heard, typed = iter(["go to the so far", "Yes, please."]), []
    doubt = understood(question="Did you mean the sofa?", meant="go to the sofa")

    def hear(_):
        said = next(heard)  # it is the robot that takes a spoken yes
        answer = doubt if said.startswith("go") else understood("Going to the sofa.")
        return answer | {"heard": said}

    def take(request):
        typed.append(request.post_data_json["text"])
        return understood("Going to the sofa.")

    stand_in(page, "/heard", hear)
    stand_in(page, "/said", take)
    for answer in ("Did you mean the sofa?", "Going to the sofa."):
        says(page, "#talk", HOLD)
        hold_button(page)
        page.mouse.up()
        says(page, "#answer", answer)
    assert typed == []


@pytest.mark.slow
@speaking
def test_a_robot_hears_through_the_page_with_the_model_it_was_given(
    whisper, session, monkeypatch, tmp_path
):
    monkeypatch.setattr(LiveMap, "vocabulary", lambda live_map: ["kitchen"])
    said = record(SpokenSample("go to the kitchen, then the sofa", "en-us", 150, None), tmp_path)
    heard = f"--use-file-for-fake-audio-capture={said}%noloop"
    with (
        Server(session, Service(port=0, speech=whisper)) as server,
        chromium(*MICROPHONE, heard) as browser,
    ):
        page = browser.new_page()
        page.goto(server.url)
        hold_key(page)
        page.wait_for_timeout(4000)
        page.keyboard.up("t")
        says(page, "#answer", "asked for: go to kitchen, then sofa")
    assert [task.request for task in session.queue.tasks()] == ["kitchen", "sofa"]
