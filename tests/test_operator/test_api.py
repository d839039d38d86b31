"""What people and their programs may ask the robot over the network, and what they may not."""

import itertools
import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import httpx
import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from tests.helpers.clients import client_of
from tests.helpers.roomba_rig import wait_for
from tests.helpers.served import arrived, jobs_done, refusal, step, websocket_url
from vizbot.core.errors import ConfigError
from vizbot.core.observer import Candidate, GoalReport, Outcome
from vizbot.core.types import Feedback, Twist
from vizbot.objectnav.tasks import Waypoint
from vizbot.operator.api.auth import MAX_BODY
from vizbot.operator.api.image_stream import Pictures
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service
from vizbot.operator.client.robot_client import RobotClient
from vizbot.operator.session.loop_jobs import MOST
from vizbot.operator.session.session import OperatorSession


def test_goals_are_asked_for_and_told_in_the_state(http, session):
    assert http.post("/goals", json={"texts": ["sofa", " bed "]}).json() == {"numbers": [1, 2]}
    assert http.post("/explore").json() == {"numbers": [3]}
    assert http.post("/place", json={"x": 1.25, "y": -3}).json() == {"numbers": [4]}
    assert http.post("/come-back").json() == {"numbers": [5]}
    assert http.post("/dock").json() == {"numbers": [6]}
    goals = http.get("/state").json()["goals"]
    assert [goal["text"] for goal in goals] == [
        "sofa", "bed", "explore", "go to 1.2 m, -3.0 m", "come back", "dock",
    ]  # fmt: skip
    assert session.queue.tasks()[3].request == Waypoint(1.25, -3.0)
    assert session.queue.current().text == "sofa"


def test_what_is_no_goal_and_no_place_is_refused_with_the_reason(http, session):
    for path, content in (
        ("/goals", {}),
        ("/goals", {"texts": []}),
        ("/goals", {"texts": [" "]}),
        ("/goals", {"texts": ["a" * 201]}),
        ("/goals", {"texts": ["sofa"] * 21}),
        ("/goals", {"texts": ["so\x07fa"]}),
        ("/goals", {"texts": ["sofa"], "speed": 3}),
        ("/place", {}),
        ("/place", {"x": 1}),
        ("/place", {"x": 1, "y": 1e9}),
        ("/place", {"x": "NaN", "y": 0}),
    ):
        assert refusal(http.post(path, json=content), 422), (path, content)
        assert session.queue.tasks() == [], (path, content)


@pytest.mark.parametrize("path", ["/explore", "/come-back", "/dock"])
def test_what_needs_no_words_comes_at_once_where_it_shall(http, session, path):
    http.post("/goals", json={"texts": ["sofa"]})
    assert session.queue.current().text == "sofa"
    assert http.post(path, json={"at_once": False}).json() == {"numbers": [2]}
    assert not session.queue.current().called_off
    assert http.post(path, json={"at_once": True}).json() == {"numbers": [3]}
    assert session.queue.current().called_off
    session.queue.finish(Outcome.GAVE_UP, "another goal took over")
    assert session.queue.current().number == 3
    assert http.post(path, json={"now": True}).status_code == 422


@pytest.mark.slow
def test_a_doubt_is_shown_by_the_base_and_in_the_log(http, session):
    shown = []
    session.robot.show = shown.append
    assert http.post("/doubt", json={"question": 'did you mean "sofa"?'}).json() == {"shown": True}
    assert shown == [Feedback.DOUBT]
    assert http.get("/state").json()["log"][-1]["text"] == 'did you mean "sofa"?'


def asked(http):
    return [(goal["number"], goal["outcome"]) for goal in http.get("/state").json()["goals"]]


def test_a_task_is_called_off_by_its_number_and_the_others_stay(http, session):
    http.post("/goals", json={"texts": ["sofa", "bed", "bed"]})
    session.queue.current()
    assert http.request("DELETE", "/tasks/2", json={"who": "ann"}).json() == {"asked": True}
    assert asked(http) == [(2, "gave_up"), (1, None), (3, None)]
    assert session.log.lines()[-1].text == "bed: gave up (called off by ann)"
    assert not session.queue.current().called_off
    assert http.delete("/tasks/1").status_code == 200
    assert session.queue.current().called_off
    for number in (2, 4):
        refused = refusal(http.delete(f"/tasks/{number}"))
        assert refused.startswith(f"no task {number} runs or waits")
    assert http.delete("/tasks/two").status_code == 422


def test_what_waits_becomes_the_next_by_its_number(http, session):
    http.post("/goals", json={"texts": ["sofa", "bed", "sink"]})
    session.queue.current()
    assert http.post("/tasks/3/next").json() == {"asked": True}
    assert asked(http) == [(1, None), (3, None), (2, None)]
    assert http.post("/tasks/1/next").status_code == 409


def test_what_is_over_is_asked_for_again_or_forgotten(http, session):
    http.post("/place", json={"x": 1.25, "y": -3})
    assert http.post("/tasks/1/again").status_code == 409
    session.queue.current()
    session.queue.finish(Outcome.GAVE_UP, "no way there")
    assert http.post("/tasks/1/again").json() == {"numbers": [2]}
    assert session.queue.tasks()[-1].request == Waypoint(1.25, -3.0)
    assert http.delete("/tasks").json() == {"asked": True}
    assert asked(http) == [(2, None)]


def test_stop_calls_all_off_and_says_who(http, session):
    http.post("/goals", json={"texts": ["sofa"]})
    assert http.post("/stop", json={"who": "ann"}).json() == {"stopped": True}
    state = http.get("/state").json()
    assert state["stopped"] is True
    assert state["goals"][0]["reason"] == "stopped by ann"
    session.begin_step()
    assert http.get("/state").json()["stopped"] is True
    http.post("/goals", json={"texts": ["bed"]})
    session.begin_step()
    assert http.get("/state").json()["stopped"] is False


def test_a_line_of_the_log_that_tells_of_an_end_names_the_outcome(http, session):
    session.log.write_end("sofa", Outcome.GAVE_UP, "no way there")
    session.log.write("map", "the map is kept as 'home'")
    ended, other = http.get("/state").json()["log"]
    assert (ended["code"], ended["outcome"]) == ("ended", "gave_up")
    assert ended["text"] == "sofa: gave up (no way there)"
    assert "outcome" not in other


@pytest.mark.slow
def test_a_flood_of_stops_leaves_the_rest_of_the_log(http, session):
    session.log.write("warning", "the camera is gone")
    for number in range(300):
        http.post("/stop", json={"who": "ann"})
        session.stop(f"somebody {number}")
    lines = [line.text for line in session.log.lines()]
    assert session.stops == 600
    assert lines[0] == "the camera is gone"
    assert lines[-2:] == ["stopped by ann", "stopped by somebody 299"]
    assert len(lines) == 11 and lines.count("stopped by ann") == 1
    session.log.write("resume", "somebody asked the base to obey again")
    session.stop("ann")
    assert [line.text for line in session.log.lines()].count("stopped by ann") == 2


def test_the_base_is_asked_to_obey_again(http, session):
    asked = []
    session.robot.resume_base = lambda: asked.append(True)
    assert http.post("/resume").json() == {"asked": True}
    assert asked == [True]


@pytest.mark.parametrize(
    "content", [b"", b"now", b'{"who": ""}', b'{"who": "\x1b[2J"}', b'{"name": 3}', b"[" * 5000]
)
def test_whatever_is_sent_along_stop_works(http, session, content):
    session.ask(["sofa"])
    assert http.post("/stop", content=content).status_code == 200
    assert session.stopped.is_set()
    [goal] = http.get("/state").json()["goals"]
    assert goal["reason"].startswith("stopped by ") and goal["reason"].isprintable()


def test_the_wheels_are_stopped_before_anybody_is_named(server, session, opened):
    line = client_of(server, opened)
    request = b"POST /stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n"
    line.sendall(request)  # and its body never comes
    wait_for(session.stopped.is_set)
    wait_for(lambda: line.recv(4096).startswith(b"HTTP/1.1 200"))


def test_stop_works_while_many_questions_wait(server, session):
    def ask(number):
        with httpx.Client(base_url=server.url, timeout=30.0) as http:
            return http.get("/map/places", params={"text": f"thing {number}"}).status_code

    with ThreadPoolExecutor(45) as people:
        asked = [people.submit(ask, number) for number in range(45)]
        wait_for(lambda: len(session.jobs) == MOST)
        with httpx.Client(base_url=server.url, timeout=2.0) as http:
            assert http.post("/stop").status_code == 200
        wait_for(lambda: session.jobs.cancel() or all(each.done() for each in asked))
    assert {each.result() for each in asked} <= {409, 503}


def test_pictures_come_once_there_are_some(http, session):
    assert http.get("/pictures/colour.jpg").status_code == 503
    session.on_step(step(0))
    for name in ("colour", "depth", "map", "likeness"):
        answer = http.get(f"/pictures/{name}.jpg")
        assert answer.headers["content-type"] == "image/jpeg"
        assert answer.content[:2] == b"\xff\xd8"
    assert http.get("/pictures/secret.jpg").status_code == 404


def test_who_watches_is_sent_the_state_and_each_picture_once(server, session):
    session.on_step(step(0))
    with connect(websocket_url(server, "/live?images=map,colour&rate=10")) as socket:
        said = [socket.recv(timeout=5) for _ in range(3)]
        pictures = [each for each in said if isinstance(each, bytes)]
        assert {picture[0] for picture in pictures} == {0, 2}
        states = [json.loads(each) for each in said if isinstance(each, str)]
        assert states[0]["step"] == 0
        session.on_step(step(1))
        wait_for(lambda: isinstance(socket.recv(timeout=5), bytes))


def test_other_sites_pages_cannot_talk_to_the_robot(http, server):
    for headers in (
        {"Origin": "http://evil.example"},
        {"Host": "evil.example"},
        {"Sec-Fetch-Site": "cross-site"},
    ):
        assert http.get("/state", headers=headers).status_code == 403
        assert http.post("/goals", json={"texts": ["sofa"]}, headers=headers).status_code == 403
    assert http.get("/state", headers={"Origin": server.url}).status_code == 200
    with pytest.raises(Exception, match="403"):
        connect(websocket_url(server, "/drive"), origin="http://evil.example")


def test_what_is_too_large_is_refused(http):
    assert http.post("/goals", content=b" " * (MAX_BODY + 1)).status_code == 413

    def endless():
        for _ in range(3):
            yield b" " * MAX_BODY

    assert http.post("/goals", content=endless()).status_code == 400


def test_a_port_that_is_taken_is_one_line(server):
    port = int(server.url.rsplit(":", 1)[1])
    with pytest.raises(ConfigError, match=f":{port}: .*give another --port"):
        Server(OperatorSession(), Service(port=port))


@pytest.mark.slow
def test_a_rate_that_is_no_number_is_refused(server):
    with pytest.raises(InvalidStatus), connect(websocket_url(server, "/live?rate=nan")):
        pass


def test_a_certificate_without_its_key_is_one_line(tmp_path):
    with pytest.raises(ConfigError, match="both --tls-certificate and --tls-key"):
        Server(OperatorSession(), Service(port=0, certificate=tmp_path / "a.pem"))
    for name in ("a.pem", "a.key"):
        (tmp_path / name).write_text("no certificate")
    with pytest.raises(ConfigError, match=r"a\.pem cannot be used"):
        Server(OperatorSession(), Service("127.0.0.1", 0, tmp_path / "a.pem", tmp_path / "a.key"))


def test_one_drives_at_a_time_and_the_wheel_is_handed_over(server, session):
    with connect(websocket_url(server, "/drive?who=ann")) as ann:
        assert "time" in json.loads(ann.recv(timeout=5))
        with connect(websocket_url(server, "/drive?who=bob")) as bob:
            assert json.loads(bob.recv(timeout=5)) == {"refused": "ann"}
        with connect(websocket_url(server, "/drive?who=bob&over=true")) as bob:
            assert "time" in json.loads(bob.recv(timeout=5))
            assert session.lease.holder == "bob"
            with pytest.raises(ConnectionClosed):
                while True:
                    ann.recv(timeout=5)
    wait_for(lambda: session.lease.holder is None)


def test_a_wheel_that_is_given_back_lets_the_robot_go_on_and_a_lost_one_does_not(server, session):
    for said, rests in ((['{"done": true}'], False), ([], True)):
        with connect(websocket_url(server, "/drive?who=ann")) as ann:
            ann.recv(timeout=5)
            for message in said:
                ann.send(message)
                wait_for(lambda: session.lease.holder is None)
        wait_for(lambda: session.lease.holder is None)
        assert session.stopped.is_set() == rests


def test_a_link_that_ends_releases_the_wheel(server, session):
    sequence = itertools.count()
    with connect(websocket_url(server, "/drive?who=ann")) as ann:
        for nonsense in ("", "{}", "[1]", "[" * 4000, '{"sequence": 1}', "\x00"):
            ann.send(nonsense)

        def drives():  # a motion lasts 0.3 s, which a busy machine may take to look
            heard = json.loads(ann.recv(timeout=5))["time"]
            motion = {"sequence": next(sequence), "heard": heard, "linear": 0.2, "angular": 0.0}
            ann.send(json.dumps(motion))
            return session.lease.twist() == Twist(0.2, 0.0)

        wait_for(drives)
    wait_for(lambda: session.lease.twist() is None)


NOT_JSON = ["NaN", "Infinity", "-Infinity", "1e999", r'"\ud800"', r'["a\udfff"]', "[NaN]"]
BODIES = {
    "/goals": '{"texts": ["sofa"], "at_once": VALUE}',
    "/place": '{"x": 1.0, "y": VALUE}',
    "/explore": '{"at_once": VALUE}',
    "/said": '{"text": VALUE}',
    "/doubt": '{"question": VALUE}',
    "/map/keep-out": '{"corners": VALUE}',
}


@pytest.mark.parametrize("value", NOT_JSON)
def test_values_that_no_answer_can_hold_are_refused_in_words(http, value):
    for path, template in itertools.product(BODIES, ("BODY", "VALUE", r'{"\ud800": VALUE}')):
        content = template.replace("BODY", BODIES[path]).replace("VALUE", value)
        answer = http.post(path, content=content, headers={"content-type": "application/json"})
        assert answer.status_code == 422
        assert all(part["loc"] and part["msg"] for part in answer.json()["detail"])
        assert len(answer.text.splitlines()) == 1
    assert http.get("/state").status_code == 200


@pytest.mark.parametrize("value", NOT_JSON)
def test_a_stop_by_whoever_has_no_name_is_a_stop(http, session, value):
    assert http.post("/stop", content=f'{{"who": {value}}}').status_code == 200
    assert http.get("/state").json()["stopped"]


@pytest.fixture
def looping(session):
    """What a robot's loop refutes."""
    with jobs_done(session) as refuted:
        yield refuted


def test_an_arrival_is_told_in_the_state_with_its_picture_until_another_search(http, session):
    assert http.get("/pictures/arrival.jpg").status_code == 404
    number = arrived(session)
    told = {"number": number, "text": "sofa", "headline": "Found the sofa after 50 s, 12 m"}
    told |= {"seconds": 50.0, "way": 12.34, "has_picture": True, "confirmed": None}
    assert http.get("/state").json()["arrival"] == told
    [ended] = http.get("/state").json()["goals"]
    assert ended["headline"] == told["headline"]
    picture = http.get("/pictures/arrival.jpg")
    assert picture.content == b"\xff\xd8 a sofa" and picture.headers["cache-control"] == "no-store"
    session.on_step(replace(step(1), goal="", scores=None))
    assert http.get("/state").json()["arrival"] is not None
    session.on_step(step(2))
    assert http.get("/state").json()["arrival"] is None
    arrived(session, picture=None)
    assert http.get("/state").json()["arrival"]["has_picture"] is False
    assert refusal(http.get("/pictures/arrival.jpg"), 404) == "no picture of this place was kept"


def test_a_place_of_the_saved_map_has_no_picture_and_it_is_said_why(http, session, looping):
    session.on_step(replace(step(7), frame_number=40, candidate_xy=np.array([2.0, 1.0])))
    told = "no picture: the robot knows this place from the saved map"
    assert http.get("/candidates/7/picture.jpg").json()["detail"] == told
    session.ask(["sofa"])
    session.queue.current()
    place = Candidate(np.zeros(3), 0.9, 39, np.array([0, 0, 9, 9], np.int32))
    session.on_goal(GoalReport("sofa", Outcome.ARRIVED, "sure", (place,)))
    assert http.get("/pictures/arrival.jpg").json()["detail"] == told
    session.leave_map()
    assert http.get("/state").json()["arrival"] is None


def test_a_verdict_is_taken_and_what_is_not_it_is_searched_for_again(http, session, looping):
    refused = refusal(http.post("/verdict", json={"confirmed": True, "who": "ann"}))
    assert "the robot has not arrived" in refused
    number = arrived(session)
    assert http.post("/verdict", json={"confirmed": True, "who": "ann"}).json()["numbers"] == []
    assert http.get("/state").json()["arrival"]["confirmed"] is True and looping == []
    again = http.post("/verdict", json={"confirmed": False}).json()["numbers"]
    assert again == [number + 1] and looping == [True]
    assert session.queue.current().text == "sofa"
    told = [line["text"] for line in http.get("/state").json()["log"] if line["code"] == "verdict"]
    assert told == [
        "sofa: ann says that is it",
        "sofa: somebody says that is not it; the search goes on",
    ]
    assert "goes on already: sofa" in refusal(http.post("/verdict", json={"confirmed": False}))
    assert http.post("/verdict", json={"confirmed": "perhaps"}).status_code == 422


def test_what_the_robot_goes_up_to_is_told_and_somebody_says_whether_to_go_there(
    http, session, looping
):
    assert http.get("/state").json()["candidate"] is None
    session.ask(["sofa"])
    session.queue.current()
    session.on_step(replace(step(7), candidate_xy=np.array([2.0, 1.0])))
    told = {"number": 7, "text": "sofa", "headline": "I see something like a sofa"}
    told |= {"position": [2.0, 1.0], "confirmed": False}
    assert http.get("/state").json()["candidate"] == told
    yes, no = {"confirmed": True, "who": "ann"}, {"confirmed": False}
    assert http.post("/candidates/7/verdict", json=yes).status_code == 200
    assert http.get("/state").json()["candidate"] == told | {"confirmed": True}
    assert "turned to something else" in refusal(http.post("/candidates/6/verdict", json=no))
    assert looping == []
    assert http.post("/candidates/7/verdict", json=no).status_code == 200
    assert looping == [(2.0, 1.0)]
    state = http.get("/state").json()
    assert state["candidate"] is None and state["goals"][0]["outcome"] is None, "it searches on"
    assert [line["text"] for line in state["log"] if line["code"] == "verdict"] == [
        "sofa: ann says go there",
        "sofa: somebody says that is not it; the search goes on",
    ]
    assert http.post("/candidates/7/verdict", json=yes).status_code == 409
    assert http.post("/candidates/it/verdict", json=yes).status_code == 422


def test_the_picture_of_what_the_robot_goes_up_to_is_made_when_somebody_looks(
    http, session, looping
):
    session.robot.picture_of_place = lambda place: b"\xff\xd8 " + str(place.score).encode()
    session.on_step(step(0))
    session.on_step(replace(step(7), candidate_xy=np.array([2.0, 1.0])))
    picture = http.get("/candidates/7/picture.jpg")
    assert picture.content == b"\xff\xd8 0.34" and picture.headers["cache-control"] == "no-store"
    assert http.get("/candidates/6/picture.jpg").status_code == 404
    assert http.get("/candidates/it/picture.jpg").status_code == 422
    session.robot.picture_of_place = lambda place: None
    refused = refusal(http.get("/candidates/7/picture.jpg"), 404)
    assert refused == "no picture of this place was kept"
    session.leave_map()
    assert http.get("/state").json()["candidate"] is None


def test_the_client_judges_an_arrival(server, session, looping):
    number = arrived(session)
    with RobotClient(server.url, None) as client:
        assert client.judge(confirmed=False, who="ann") == [number + 1]


def test_the_likeness_stays_that_of_the_last_search_until_the_next(http, session):
    session.on_step(step(0))
    searching = http.get("/pictures/likeness.jpg").content
    resting = replace(step(1), goal="", scores=None, threshold=0.0)
    session.on_step(resting)
    wait_for(lambda: Pictures(session).newest(["likeness"])[0] == 1)
    assert Pictures(session).newest(["likeness"])[1] == [searching]
    assert http.get("/state").json()["likeness"] == "sofa"
    session.leave_map()
    session.on_step(resting)
    assert Pictures(session).newest(["likeness"])[1] != [searching]
    assert http.get("/state").json()["likeness"] == ""
