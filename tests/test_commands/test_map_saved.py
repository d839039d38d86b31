"""`vizbot map list`, `rename`, `delete`: the maps that were saved by name."""

import json
from io import StringIO
from pathlib import Path

import pytest

from mapping import map_bundle
from mapping.map_folder import MapUse
from tests.helpers.bundles import bundle_of, names_in
from tests.helpers.failing import assert_one_line
from vizbot.commands.options import RunOptions
from vizbot.commands.run_plan import plan_run


class Terminal(StringIO):
    def isatty(self):
        return True


def test_saved_maps_are_listed(run, maps):
    map_bundle.save(bundle_of(), maps / "ground floor")
    with MapUse(maps / "home"):
        code, out, _ = run("map", "list")
        assert code == 0
        assert [line[18:] for line in out.splitlines()] == [
            f"ground floor   {maps}/ground floor",
            f"home (in use)  {maps}/home",
        ]
        code, out, err = run("map", "list", "--json")
    said = json.loads(out)
    assert (code, err, said["folder"]) == (0, "", str(maps))
    assert {each["name"]: each["in_use"] for each in said["maps"]} == {
        "home": True, "ground floor": False
    }  # fmt: skip


def test_where_no_map_was_saved_it_says_where_it_looked(run, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    code, out, err = run("map", "list")
    assert (code, out) == (0, "") and str(tmp_path / "vizbot" / "maps") in err
    assert json.loads(run("map", "list", "--json")[1])["maps"] == []


def test_a_saved_map_is_meant_by_its_name_wherever_a_folder_is_taken(run, maps, tmp_path):
    map_bundle.save(bundle_of(seed=3, model_id="another"), maps / "home five")
    code, out, err = run("map", "info", "home five")
    assert (code, err) == (0, "") and out == run("map", "info", str(maps / "home five"))[1]
    assert "'another'" in run("map", "query", "home five", "chair")[2]
    for form in ("tum", "ply"):
        given = ("map", "export", "home five", "--format", form, "--out", f"home.{form}")
        assert run(*given) == (0, f"home.{form}\n", "")
        written = (tmp_path / f"home.{form}").read_bytes()
        (tmp_path / f"home.{form}").write_text("notes")
        refused = f"home.{form} is there already; give another file by --out, or add --force"
        assert run(*given) == (1, "", f"vizbot: {refused}\n")
        assert (tmp_path / f"home.{form}").read_text() == "notes"
        assert run(*given, "--force") == (0, f"home.{form}\n", "")
        assert (tmp_path / f"home.{form}").read_bytes() == written
    (maps / "home five").rename(maps / ".home five.previous")  # killed while it was replaced
    assert run("map", "info", "home five")[:2] == (0, out)
    plan = plan_run(RunOptions(map_folder=Path("home"), out=tmp_path / "run"))
    assert plan.map_folder == maps / "home" and plan.saved_map is not None


def test_a_folder_that_exists_comes_before_a_saved_map_of_its_name(run, maps, tmp_path):
    map_bundle.save(bundle_of(model_id="another"), tmp_path / "home")
    assert "another" in run("map", "info", "home")[1]
    (tmp_path / "home").rename(tmp_path / ".home.previous")  # killed while it was replaced
    assert "another" in run("map", "info", "home")[1]
    (tmp_path / ".home.previous").rename(tmp_path / "elsewhere")
    assert "another" not in run("map", "info", "home")[1]
    (tmp_path / "home").mkdir()
    assert "home is not a map" in run("map", "info", "home")[2]


@pytest.mark.parametrize("given", ["attic", "../home", "/nowhere/home", "a" * 61, "home/map"])
def test_where_no_map_is_the_line_names_the_list(run, maps, given):
    told = f"no map at {given}: `vizbot map list` shows those saved by name"
    assert_one_line(run("map", "info", given), told)


def test_a_map_is_renamed(run, maps):
    code, out, _ = run("map", "rename", "home", "ground floor")
    assert (code, out) == (0, "'home' is called 'ground floor' now\n")
    assert names_in(maps) == ["ground floor"]


def test_a_map_is_deleted_by_who_says_yes_once(run, maps, monkeypatch):
    for answer, left in (("n\n", ["home"]), ("y\n", [])):
        monkeypatch.setattr("sys.stdin", Terminal(answer))
        code, _, err = run("map", "delete", "home")
        assert err.count("Delete 'home' for good?") == 1
        assert code == len(left) and names_in(maps) == left
        assert ("the map 'home' stays" in err) == bool(left)


def test_a_program_deletes_a_map_with_yes(run, maps, monkeypatch):
    monkeypatch.setattr("sys.stdin", StringIO())
    assert_one_line(run("map", "delete", "home"), "add --yes")
    code, out, _ = run("map", "delete", "home", "--yes")
    assert (code, out) == (0, "'home' is deleted\n")
    assert names_in(maps) == []


def test_a_map_that_a_robot_is_in_is_not_deleted(run, maps):
    with MapUse(maps / "home"):
        refused = run("map", "delete", "home", "--yes")
    assert_one_line(refused, "'home' is in use; change to another map first")
    assert map_bundle.load(maps / "home")


@pytest.mark.parametrize("name", ["..", "../home", "/", ".home", "a" * 61, ""])
def test_what_is_no_name_is_refused_in_one_line(run, maps, name):
    for command in (
        ["delete", name, "--yes"],
        ["rename", name, "office"],
        ["rename", "home", name],
    ):
        assert_one_line(run("map", *command), repr(name), "letters, digits, spaces")
    assert names_in(maps) == ["home"]


def test_a_map_that_is_not_there_is_named_with_those_that_are(run, maps):
    for command in (["delete", "attic"], ["rename", "attic", "office"]):
        told = "there is no saved map 'attic'; those that there are: 'home'"
        assert_one_line(run("map", *command), told)


@pytest.mark.parametrize("command", [("dry-run", "sofa"), ("launch", "--force")])
def test_a_map_of_nearly_the_largest_size_is_refused_before_anything_is_opened(
    run, maps, tmp_path, monkeypatch, command
):
    monkeypatch.setattr(map_bundle, "MOST_BYTES", map_bundle.GROWTH)
    told = f"vizbot: the map {maps / 'home'} has 0 MB, and with more than 100 MB"
    assert_one_line(run(*command, "--map", "home", "--out", "run"), told)
    assert not (tmp_path / "run").exists()
    assert run("map", "info", "home")[0] == 0
