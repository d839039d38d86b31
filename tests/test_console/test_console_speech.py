"""What is said into the page's microphone, from the sound to what the robot is asked for."""

from tests.helpers.browsing import MICROPHONE, chromium, says
from tests.helpers.spoken import SpokenSample, record, speaking
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service
from vizbot.operator.session.live_map import LiveMap


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
        page.keyboard.down("t")
        says(page, "#answer", "Listening.")
        page.wait_for_timeout(4000)
        page.keyboard.up("t")
        says(page, "#answer", "asked for: go to kitchen, then sofa")
    assert [task.request for task in session.queue.tasks()] == ["kitchen", "sofa"]
