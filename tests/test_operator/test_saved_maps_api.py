"""Saved maps over the network: listed, shown, renamed, deleted."""

import time
import unicodedata
from dataclasses import replace

import cv2
import httpx
import numpy as np
import pytest

from mapping import map_bundle
from tests.fuzz.spoilt_maps import replacing
from tests.helpers.bundles import assert_same, bundle_of, names_in
from tests.helpers.documented_api import DocumentedClient
from tests.helpers.served import refusal, served
from vizbot.core.types import OccupancyGrid
from vizbot.operator.session.saved_maps import SavedMaps, find_map
from vizbot.operator.session.session import OperatorSession

TRICKS = ["..", "%2e%2e", "../home", ".hidden", "a/b", "a\\b", "\x00", "a" * 61, "-x", "", " "]
"""What is no name of a map."""


@pytest.fixture
def http(robot, maps):
    with served(robot.session) as server, DocumentedClient(server.url, timeout=15.0) as http:
        yield http


def listed(http):
    return {each.pop("name"): each for each in http.get("/maps").json()["maps"]}


@pytest.mark.slow
def test_saved_maps_are_listed_with_the_time_and_whether_a_robot_is_in_them(http):
    http.put("/maps/office", json={}).raise_for_status()
    assert http.get("/maps").json()["names"] == ["office", "home"]
    found = listed(http)
    assert abs(found["office"]["saved_at"] - time.time()) < 60
    assert {name: each["in_use"] for name, each in found.items()} == {"office": True, "home": False}
    http.post("/maps/home/begin").raise_for_status()
    assert listed(http)["home"]["in_use"] and not listed(http)["office"]["in_use"]
    http.post("/map/new").raise_for_status()
    assert not any(each["in_use"] for each in listed(http).values())


def test_a_run_that_begins_in_a_saved_map_is_in_it_until_it_ends(maps):
    session = OperatorSession()
    session.robot.begun_in = maps / "home"
    with served(session) as server, DocumentedClient(server.url) as http:
        assert listed(http)["home"]["in_use"]
        assert "in use" in refusal(http.delete("/maps/home"))
    with served() as server, DocumentedClient(server.url) as http:
        assert http.delete("/maps/home").json() == {"deleted": "home"}


def test_the_picture_of_a_saved_map_shows_its_walls_and_zones(http, maps):
    occupancy = np.zeros((60, 80), np.float32)
    occupancy[:, :4] = occupancy[:, -4:] = occupancy[:4] = occupancy[-4:] = 1.0
    zone = np.array([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]], np.float32)
    grid = OccupancyGrid(occupancy, 0.05, np.zeros(2))
    map_bundle.save(replace(bundle_of(), grid=grid, keep_out=(zone,)), maps / "walled")
    answer = http.get("/maps/walled/picture.jpg")
    assert answer.headers["content-type"] == "image/jpeg"
    picture = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR).astype(int)
    assert picture.shape == (120, 160, 3)
    grey = picture.sum(axis=2) / 3
    assert grey[60, 120] > 240 and grey[60].min() < 80
    blue, _, red = picture[66, 68]
    assert red > blue + 60


def test_a_map_without_a_picture_is_refused_in_one_line(http, maps):
    assert http.get("/maps/nowhere/picture.jpg").status_code == 409
    replacing("grid.occupancy", lambda occupancy: np.full_like(occupancy, 7.0))(maps / "home")
    assert "damaged" in refusal(http.get("/maps/home/picture.jpg"))


def test_a_map_is_renamed_and_its_robot_stays_in_it(robot, http, maps):
    before = map_bundle.load(maps / "home")
    http.post("/maps/home/begin").raise_for_status()
    answer = http.post("/maps/home/rename", json={"name": "ground floor"})
    assert answer.json() == {"renamed": "ground floor"}
    assert listed(http)["ground floor"]["in_use"]
    assert robot.session.log.lines()[-1].text == "the map 'home' is called 'ground floor' now"
    refused = refusal(http.delete("/maps/ground floor"))
    assert "'ground floor' is in use; change to another map first" in refused
    assert_same(map_bundle.load(maps / "ground floor"), before)


def test_no_map_takes_the_name_of_another_one(http, maps):
    map_bundle.save(bundle_of(2), maps / "office")
    before = map_bundle.load(maps / "office")
    refused = refusal(http.post("/maps/home/rename", json={"name": "office"}))
    assert "there is a map 'office' already" in refused
    assert_same(map_bundle.load(maps / "office"), before)
    assert set(listed(http)) == {"home", "office"}


def test_a_map_is_deleted_and_the_log_has_it(robot, http, maps):
    assert http.delete("/maps/home").json() == {"deleted": "home"}
    assert names_in(maps) == []
    assert robot.session.log.lines()[-1].text == "the map 'home' is deleted"
    refused = refusal(http.delete("/maps/home"))
    assert refused == "there is no saved map 'home'; those that there are: none"


@pytest.mark.slow
@pytest.mark.parametrize("name", TRICKS)
def test_a_name_leads_nowhere_else(http, maps, name):
    map_bundle.save(bundle_of(2), maps.parent / "precious")
    map_bundle.save(bundle_of(2), maps / ".hidden")
    before = sorted(maps.parent.rglob("*"))
    refused = refusal(http.post("/maps/home/rename", json={"name": name}))
    assert "is no name for a map; use" in refused and "\n" not in refused
    for path in (f"/maps/{name}", "/maps/..%2Fprecious", "/maps/%2e%2e%2fprecious"):
        if not path.endswith("/") and "\x00" not in path:
            assert http.delete(path).status_code in (404, 405, 409)
    assert sorted(maps.parent.rglob("*")) == before


def test_beyond_this_machine_only_who_knows_the_token_deletes(maps, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    with served(host="0.0.0.0") as server:
        url = server.url.replace("0.0.0.0", "127.0.0.1")
        for headers, status in (({}, 401), ({"Authorization": "Bearer wrong"}, 401)):
            with DocumentedClient(url, headers=headers) as http:
                assert http.delete("/maps/home").status_code == status
                renamed = http.post("/maps/home/rename", json={"name": "office"})
                assert renamed.status_code == status
                assert http.get("/maps/home/picture.jpg").status_code == status
        assert names_in(maps) == ["home"]
        known = {"Authorization": f"Bearer {server.token}"}
        foreign = httpx.delete(
            f"{url}/maps/home", headers=known | {"Origin": "http://evil.example"}
        )
        assert foreign.status_code == 403 and names_in(maps) == ["home"]
        assert httpx.delete(f"{url}/maps/home", headers=known).status_code == 200


def test_a_map_whose_folder_is_written_with_decomposed_letters_is_found_and_not_renamed(maps):
    name, written = "B\u00fcro", unicodedata.normalize("NFD", "B\u00fcro")
    map_bundle.save(bundle_of(1), maps / written)
    saved = SavedMaps(maps)
    assert [each.name for each in saved.maps() if each.name != "home"] == [name]
    for asked in (name, written, "\uff22\u00fcro"):
        assert saved.require(asked) == maps / written
        assert saved.path(asked) == maps / written
    assert find_map(type(maps)(name)) == maps / written
    assert saved.name_of(maps / written) == name
    assert sorted(each.name for each in maps.iterdir()) == sorted(["home", written])


@pytest.mark.parametrize("written", ["floor 1\u00bd", "floor 1.5"])
def test_a_fraction_in_a_name_is_a_decimal(maps, written):
    map_bundle.save(bundle_of(1), maps / written)
    saved = SavedMaps(maps)
    assert "floor 1.5" in [each.name for each in saved.maps()]
    assert saved.require("floor 1\u00bd") == saved.require("floor 1.5") == maps / written
