"""The description of the API is whole: a client can be generated from it."""

import numpy as np
import pytest

from tests.helpers.documented_api import DocumentedClient, description
from tests.helpers.served import served, step
from vizbot.core.observer import Outcome
from vizbot.core.types import BaseMode, BaseState
from vizbot.operator.language.dispatcher import Reply
from vizbot.operator.session.place_answers import Answer, FoundPlace

BASE = BaseState(
    0.0, np.eye(4), True, False, (False,) * 4, (False,) * 2, battery=0.8, mode=BaseMode.SAFE
)
OPERATIONS = [
    (method, path, operation)
    for path, operations in description()["paths"].items()
    for method, operation in operations.items()
]


@pytest.mark.parametrize(
    ("method", "path", "operation"), OPERATIONS, ids=[f"{m} {p}" for m, p, _ in OPERATIONS]
)
def test_a_route_has_a_tag_a_summary_and_a_model_for_every_answer(method, path, operation):
    [tag] = operation["tags"]
    assert tag in [described["name"] for described in description()["tags"]]
    assert operation["summary"] and operation["description"]
    schemas = description()["components"]["schemas"]
    for status, answer in operation["responses"].items():
        assert answer["description"]
        for content_type, content in answer["content"].items():
            if content_type == "application/json":
                assert content["schema"]["$ref"].rsplit("/", 1)[1] in schemas
            else:
                assert (status, content_type) == ("200", "image/jpeg")
    is_stop, is_free = path == "/stop", path in ("/stop", "/proof")
    assert {"403"} < set(operation["responses"])
    assert "401" in operation["responses"] or is_free
    assert "429" in operation["responses"] or is_stop
    assert ("422" in operation["responses"]) == (
        not is_stop
        and ("requestBody" in operation or path in ("/map/places", "/proof") or "{number}" in path)
    )
    assert [[*way] for way in operation.get("security", [])] == (
        [] if is_free else [["bearer"], ["cookie"], ["query"]]
    )


def test_routes_have_names_of_their_own_for_clients_that_are_generated():
    names = [operation["operationId"] for _, _, operation in OPERATIONS]
    assert len(set(names)) == len(names)
    assert all(name.isidentifier() for name in names)


def test_a_token_is_given_in_one_of_three_ways():
    schemes = description()["components"]["securitySchemes"]
    assert {(scheme["type"], scheme.get("in")) for scheme in schemes.values()} == {
        ("http", None), ("apiKey", "cookie"), ("apiKey", "query"),
    }  # fmt: skip


def test_no_page_that_would_load_scripts_from_elsewhere_is_served(http):
    for path in ("/docs", "/redoc"):
        assert http.get(path).status_code == 404


def test_a_state_with_all_that_it_may_hold_fits_its_model(http, session):
    http.get("/state")
    session.robot.base_state = lambda: BASE
    session.ask(["sofa", "bed"])
    session.queue.current()
    session.queue.finish(Outcome.ARRIVED, "there it is", (1.0, 2.0, 0.4))
    session.log.write_end("sofa", Outcome.ARRIVED, "there it is")
    session.take_lease("ann")
    session.on_step(step(0))
    state = http.get("/state").json()
    assert state["base"]["mode"] == "safe" and state["map_view"]["width"] == 960


@pytest.mark.slow
def test_errors_of_whoever_asks_fit_their_models(session, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setattr("vizbot.operator.api.auth._RATE", 0.1)  # a busy machine asks slowly, too
    with served(session, host="0.0.0.0") as server:
        here = server.url.replace("0.0.0.0", "127.0.0.1")
        with DocumentedClient(here) as http:
            assert http.get("/state").status_code == 401
            assert http.post("/stop").status_code == 200
            assert http.post("/stop", headers={"Origin": "http://evil"}).status_code == 403
            statuses = {http.get("/maps").status_code for _ in range(300)}
            assert statuses == {401, 429}


def test_too_many_tasks_are_refused_as_documented(http):
    for _ in range(5):
        assert http.post("/goals", json={"texts": ["sofa"] * 20}).status_code == 200
    assert http.post("/dock").status_code == 429


def test_sentences_are_answered_as_documented(http, monkeypatch):
    monkeypatch.setattr(
        "vizbot.operator.session.live_map.LiveMap.places",
        lambda live_map, text: Answer(
            text,
            Outcome.LOCATED,
            0.3,
            (FoundPlace((1.0, 2.0, 0.5), 0.4, 7, (0, 0, 64, 64), "2026-11-29T12:00:00+00:00"),),
        ),
    )
    assert http.post("/said", json={"text": "where is the sofa?"}).json()["place"] == [1.0, 2.0]
    assert http.get("/map/places", params={"text": "sofa"}).json()["places"][0]["frame"] == 7
    assert http.post("/said", json={"text": "so\x07fa"}).status_code == 422
    assert http.post("/heard", content=b"no sound").status_code == 422
    doubt = Reply((), "did you mean the sofa?", "go to sofa", heard="go to the so far")
    monkeypatch.setattr(
        "vizbot.operator.voice.recordings.Recordings.spoken", lambda recordings, sound, who: doubt
    )
    assert http.post("/heard", content=b"sound").json()["meant"] == "go to sofa"
