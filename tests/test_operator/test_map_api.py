"""The running robot's map over the network: asked, limited, kept, changed."""

import threading
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest

from mapping import map_bundle
from mapping.clip.reading import Reading
from mapping.clip.scores import Query
from mapping.map_snapshot import MapSnapshot
from tests.fuzz.spoilt_maps import replacing
from tests.helpers.bundles import NO_MAP, bundle_of
from tests.helpers.documented_api import DocumentedClient
from tests.helpers.failing import raising
from tests.helpers.roomba_rig import DEADLINE, wait_for
from tests.helpers.scripted_robot import ScriptedBase
from tests.helpers.served import refusal, served
from vizbot.config import Config, ObjectNavConfig
from vizbot.core.geometry import yaw_of
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP, Twist
from vizbot.objectnav.belief_search import BeliefSearch
from vizbot.objectnav.tasks import Decision, Goal
from vizbot.operator.session import live_map
from vizbot.operator.session.household import HouseholdBeliefs
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.task_loop import run_tasks
from vizbot.operator.session.twist_mux import TwistMux

SQUARE = [[3.0, 0.0], [4.0, 0.0], [4.0, 1.0]]


class Robot:
    """A served robot whose loop runs in a thread of its own until it is closed."""

    def __init__(self, pipeline_on):
        self.session, self.body = OperatorSession(), ScriptedBase()
        base = TwistMux(self.body, self.session.lease, self.session.stopped)
        self.pipeline = pipeline_on(base, colour=(240, 220, 12), observers=[self.session])
        clock = self.pipeline._devices.clock
        self._loop = threading.Thread(
            target=run_tasks, args=(self.pipeline, clock, base, self.session, ObjectNavConfig())
        )

    def start(self):
        self._loop.start()
        newest = self.session.newest_step
        wait_for(lambda: newest() is not None and len(newest().points))

    def end(self):
        self.session.closed.set()
        if self._loop.ident is not None:
            self._loop.join()


@pytest.fixture
def robot(pipeline_on, monkeypatch, tmp_path):
    monkeypatch.setattr("vizbot.operator.session.task_loop._pace", lambda clock: lambda: None)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    robot = Robot(pipeline_on)
    yield robot
    robot.end()


@pytest.fixture
def http(robot):
    with served(robot.session) as server, DocumentedClient(server.url, timeout=15.0) as http:
        yield http
        robot.end()


@pytest.fixture
def running(robot, http):
    """The robot, whose loop runs."""
    robot.start()
    return robot


def drive_ahead(robot):
    """As somebody by hand would, until it is a metre away."""
    motion = Twist(1.0 / 0.21, 0.0)
    robot.session.jobs.submit(lambda pipeline: robot.body.drive(motion)).result(9)
    wait_for(lambda: robot.session.newest_step().T_map_base[0, 3] > 0.9)


def test_the_map_is_asked_in_words(running, http):
    said = http.get("/map/places", params={"text": "yellow chair"}).json()
    assert (said["text"], said["outcome"]) == ("yellow chair", "located")
    assert said["places"][0]["score"] > said["threshold"]
    assert http.get("/map/places", params={"text": "blue chair"}).json()["outcome"] == "not_found"
    assert http.get("/map/places", params={"text": " "}).status_code == 422


def test_how_the_encoder_reads_the_words_is_part_of_the_answers(robot, http, monkeypatch):
    note = "lemon: a kind of yellow"
    encoder = type(robot.pipeline._encoder)
    monkeypatch.setattr(encoder, "reading", lambda _, text: Reading("yellow chair", note))
    robot.start()
    said = http.get("/map/places", params={"text": "lemon chair"}).json()
    assert (said["text"], said["outcome"], said["note"]) == ("lemon chair", "located", note)
    line = said["summary"]
    assert line.startswith("lemon chair: ") and line.endswith(f" ({note})")


@pytest.mark.parametrize(("method", "threshold"), [("paper", 0.3), ("belief", 0.5)])
def test_before_there_is_a_map_nothing_is_on_it(robot, http, method, threshold):
    blank = SimpleNamespace(
        keep_out=(),
        map=SimpleNamespace(number=0),
        config=Config(objectnav=ObjectNavConfig(method=method)),
        snapshot=lambda: None,
        goal=lambda text: Goal(text, np.ones(2, np.float32), 0.3),
        question=lambda goal: Query(goal.embedding, None),
    )
    jobs = robot.session.jobs
    loop = threading.Thread(target=lambda: [jobs.do_next(blank, DEADLINE) for _ in range(3)])
    loop.start()
    said = http.get("/map/places", params={"text": "sofa"}).json()
    assert (said["places"], said["threshold"]) == ([], threshold)
    assert http.get("/map/vocabulary").json() == {"phrases": []}
    refused = http.put("/maps/home", json={})
    loop.join()
    assert "has no map yet" in refusal(refused)


def test_what_was_refused_because_the_robot_is_busy_does_not_happen_later(robot, http, monkeypatch):
    monkeypatch.setattr("vizbot.operator.session.loop_jobs.WITHIN", 0.05)
    assert "ask again" in refusal(http.put("/map/keep-out", json={"zones": [SQUARE]}), 503)
    robot.start()
    assert robot.pipeline.keep_out == ()


def test_the_vocabulary_holds_what_the_map_finds(robot, http, monkeypatch):
    monkeypatch.setattr(
        "vizbot.operator.session.household.HOUSEHOLD", ("yellow chair", "blue chair")
    )
    robot.start()
    assert http.get("/map/vocabulary").json() == {"phrases": ["yellow chair"]}


def test_the_loop_neither_joins_nor_saves_nor_answers(robot, monkeypatch, tmp_path):
    workers = []

    def watched(owner, name):
        work = getattr(owner, name)

        def noted(*args, **kwargs):
            workers.append((name, threading.current_thread()))
            return work(*args, **kwargs)

        monkeypatch.setattr(owner, name, noted)

    watched(MapSnapshot, "bundle")
    watched(map_bundle, "save")
    watched(live_map, "find_places")
    watched(live_map, "count_places")
    watched(HouseholdBeliefs, "_follow")
    watched(type(robot.pipeline), "goal")
    robot.start()
    asked = LiveMap(robot.session, tmp_path)
    assert asked.places("yellow chair").places
    asked.count("yellow chair")
    asked.vocabulary()
    asked.rooms()
    asked.save("home")
    asked.begin(None)
    done = {name for name, _ in workers}
    assert done >= {"bundle", "save", "find_places", "count_places", "_follow", "goal"}
    assert robot._loop not in {thread for _, thread in workers}


def test_keep_out_zones_are_set_told_drawn_and_kept_with_the_map(running, http):
    assert http.put("/map/keep-out", json={"zones": [SQUARE]}).json() == {"zones": 1}
    assert http.get("/map/keep-out").json() == {"zones": [SQUARE]}
    assert http.put("/maps/home", json={}).json() == {"saved": "home"}
    http.post("/map/new")
    assert http.get("/map/keep-out").json() == {"zones": []}
    assert http.post("/maps/home/begin").status_code == 200
    assert http.get("/map/keep-out").json() == {"zones": [SQUARE]}


def test_zones_of_people_who_draw_and_remove_at_once_are_all_there(running, http):
    zones = [[[x + n, y] for x, y in SQUARE] for n in range(6)]
    http.put("/map/keep-out", json={"zones": zones[:3]})

    def change(number):
        method, corners = "DELETE" if number < 3 else "POST", zones[number]
        return http.request(method, "/map/keep-out", json={"corners": corners}).status_code

    with ThreadPoolExecutor(6) as people:
        assert [*people.map(change, range(6))] == [200] * 6
    assert sorted(http.get("/map/keep-out").json()["zones"]) == zones[3:]
    assert running.session.log.lines()[-1].text == "keep-out zones: 3"


def test_a_zone_that_is_gone_and_one_too_many_are_refused(running, http):
    refused = refusal(http.request("DELETE", "/map/keep-out", json={"corners": SQUARE}))
    assert "no such zone" in refused
    http.put("/map/keep-out", json={"zones": [SQUARE] * 100})
    assert "remove one first" in refusal(http.post("/map/keep-out", json={"corners": SQUARE}))
    assert http.post("/map/keep-out", json={"corners": SQUARE[:2]}).status_code == 422


def test_what_is_no_zone_is_refused(http):
    for zones in (
        None,
        [[[0, 0], [1, 1]]],
        [[[0, 0], [1, 1], [1e9, 0]]],
        [[[0, 0], [1], [2, 2]]],
        [SQUARE] * 101,
    ):
        assert http.put("/map/keep-out", json={"zones": zones}).status_code == 422, zones


def test_a_map_is_kept_under_a_name_and_not_written_over_unasked(running, http, tmp_path):
    assert http.get("/maps").json()["names"] == []
    assert http.put("/maps/ground floor", json={}).status_code == 200
    assert http.get("/maps").json()["names"] == ["ground floor"]
    assert "replace it or name another" in refusal(http.put("/maps/ground floor", json={}))
    assert http.put("/maps/ground floor", json={"replace": True}).status_code == 200
    kept = map_bundle.load(tmp_path / "vizbot" / "maps" / "ground floor")
    assert len(kept.keyframes.ids) > 0


def test_a_name_leads_nowhere_else(running, http, tmp_path):
    for name in ("..", ".hidden", "a%2Fb", "%00", "a" * 61, "-x"):
        assert http.put(f"/maps/{name}", json={}).status_code in (404, 405, 409), name
        assert not (tmp_path / "vizbot").exists(), name


def test_a_robot_goes_on_in_a_kept_map_and_the_one_it_leaves_is_not_lost(running, http, tmp_path):
    http.put("/maps/home", json={})
    drive_ahead(running)
    left = http.post("/maps/home/begin").json()["left"]
    assert left.startswith("left ")
    assert set(http.get("/maps").json()["names"]) == {"home", left}
    kept = map_bundle.load(tmp_path / "vizbot" / "maps" / left)
    assert np.ptp(kept.final_poses()[:, 0, 3]) > 0.9
    assert running.pipeline.map.saved is not None


def test_a_map_that_holds_nothing_yet_is_left_without_a_trace(running, http):
    assert http.post("/map/new").json() == {"left": None}
    assert http.get("/maps").json()["names"] == []


@pytest.mark.parametrize("cause", NO_MAP)
def test_a_map_that_cannot_be_saved_is_asked_for_once_more_and_left_then(
    running, http, monkeypatch, tmp_path, cause
):
    http.put("/map/keep-out", json={"zones": [SQUARE]})
    cause(monkeypatch)
    number = running.pipeline.map.number
    said = refusal(http.post("/map/new"))
    assert running.pipeline.map.number == number
    assert NO_MAP[cause] in said and "; or ask once more to leave this map" in said
    assert http.post("/map/new").json() == {"left": None}
    assert running.pipeline.map.number == number + 1
    said = [line.text for line in running.session.log.lines()]
    assert "the map that could not be saved is given up" in said
    http.put("/map/keep-out", json={"zones": [SQUARE]})
    assert http.post("/map/new").status_code == 409  # another map, which nobody was asked about
    monkeypatch.undo()
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert http.post("/map/new").json()["left"] is not None  # it can be saved again


def test_a_map_that_has_nearly_the_largest_size_is_not_gone_on_in(running, http, monkeypatch):
    http.put("/maps/home", json={}).raise_for_status()
    monkeypatch.setattr(map_bundle, "MOST_BYTES", map_bundle.GROWTH)
    assert "begin a new one" in refusal(http.post("/maps/home/begin"))
    assert running.pipeline.map.saved is None


def test_maps_are_not_changed_under_a_robot_that_has_something_to_do(robot, http, monkeypatch):
    monkeypatch.setattr(BeliefSearch, "go", lambda *_: Decision(STOP, "thinking"))
    robot.start()
    drive_ahead(robot)
    robot.session.ask(["blue chair"])
    wait_for(lambda: robot.session.newest_step().goal == "blue chair")
    assert "stop it before it changes maps" in refusal(http.post("/map/new"))
    robot.session.stop("ann")
    wait_for(lambda: robot.session.queue.current() is None)
    assert robot.session.take_lease("bert") is not None
    assert "bert drives by hand" in refusal(http.post("/map/new"))
    assert http.get("/maps").json()["names"] == []


def test_people_who_keep_a_map_at_once_leave_one_that_is_whole(running, http, tmp_path):
    http.put("/maps/home", json={})
    with ThreadPoolExecutor(6) as people:
        list(people.map(lambda _: http.put("/maps/home", json={"replace": True}), range(6)))
    assert len(map_bundle.load(tmp_path / "vizbot" / "maps" / "home").keyframes.ids) > 0
    assert http.get("/maps").json()["names"] == ["home"]


def test_zones_alone_make_a_map_worth_keeping(running, http):
    http.put("/map/keep-out", json={"zones": [SQUARE]})
    left = http.post("/map/new").json()["left"]
    assert left is not None
    http.post(f"/maps/{left}/begin")
    assert http.get("/map/keep-out").json() == {"zones": [SQUARE]}
    assert running.session.log.lines()[-1].text.endswith("keep-out zones: 1")


def test_a_map_that_is_missing_or_of_another_encoder_is_refused(running, http, tmp_path):
    assert http.post("/maps/nowhere/begin").status_code == 409
    map_bundle.save(bundle_of(model_id="ViT-B/32"), tmp_path / "vizbot" / "maps" / "other")
    assert "ViT-B/32" in refusal(http.post("/maps/other/begin"))
    assert running.pipeline.map.saved is None


def test_a_map_with_wrong_arrays_leaves_the_robot_in_the_map_it_had(running, http, tmp_path):
    http.put("/maps/home", json={})
    spoil = replacing("elements.keyframes", lambda keyframes: np.full_like(keyframes, 7))
    spoil(tmp_path / "vizbot" / "maps" / "home")
    refused = refusal(http.post("/maps/home/begin"))
    assert "elements.keyframes refers to a keyframe that is not there" in refused
    step = running.session.newest_step()
    wait_for(lambda: running.session.newest_step().index > step.index)
    assert running.session.newest_step().map_number == step.map_number
    assert http.get("/maps").json()["names"] == ["home"]


def test_a_disk_that_is_full_is_told(running, http, monkeypatch):
    full = OSError(28, "No space left on device")
    monkeypatch.setattr("mapping.map_bundle.save", raising(full))
    assert "No space left on device" in refusal(http.put("/maps/home", json={}))


def said(http, text):
    answer = http.post("/said", json={"text": text}).json()
    assert answer["question"] is None and answer["numbers"] == []
    return answer["said"][0]


def test_what_the_robot_knows_is_told_in_words(running, http):
    assert said(http, 'how many "yellow" are there?').startswith("yellow: one place on my map")
    assert said(http, 'how many "blue" are there?').startswith("blue: no place on my map")
    assert "yellow chair" in said(http, "what do you see?")
    assert said(http, "where are you?").startswith("I am 0.0 m from the origin of my map")


def test_a_room_is_closed_in_words_where_the_map_knows_it(running, http):
    assert said(http, 'keep out of "blue"').startswith("blue: nothing on my map looks like it")
    assert http.get("/map/keep-out").json() == {"zones": []}
    assert said(http, 'keep out of "yellow"').startswith("I keep out of the yellow from now on")
    (zone,) = http.get("/map/keep-out").json()["zones"]
    (place, *_) = http.get("/map/places", params={"text": "yellow"}).json()["places"]
    x, y = np.array(zone).T
    assert x.min() < place["position"][0] < x.max()
    assert y.min() < place["position"][1] < y.max()


def test_the_robot_turns_in_words(running, http):
    asked = http.post("/said", json={"text": "turn left, then go forward 10 cm"}).json()
    assert asked["said"] == ["asked for: turn left 90 degrees, then go forward 0.1 m"]
    wait_for(lambda: all(task.outcome for task in running.session.queue.tasks()))
    turn, way = running.session.queue.tasks()
    assert (turn.outcome, turn.reason) == (Outcome.ARRIVED, "turned as asked")
    assert yaw_of(running.body.T_odom_base) == pytest.approx(np.pi / 2, abs=0.1)
    assert (way.outcome, way.reason) == (Outcome.ARRIVED, "0.1 m driven as asked")
