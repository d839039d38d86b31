"""`vizbot config`: a settings file to begin with, the settings in use, and all that there are."""

import json
import re
import sys
import tomllib
from functools import partial
from types import SimpleNamespace
from typing import get_args

import pytest
from pydantic import BaseModel
from serial.tools import list_ports

from drivers.realsense.sdk import rs
from sim_stubs.realsense.software_device import SoftwareD435i
from tests.helpers.checkout import ROOT
from tests.helpers.failing import assert_one_line, raising
from tests.helpers.random_clip import save_tiny_clip
from vizbot.commands.config.discovery import with_rehearsal
from vizbot.commands.config.robot_file import CHOICES
from vizbot.commands.config.settings_table import all_tables
from vizbot.config import Config, load_config

SETTING = re.compile(r"^#(?=\S)", re.MULTILINE)


@pytest.fixture(autouse=True)
def no_photos(tmp_path, monkeypatch):
    """No weights of photos are on this machine, whoever has fetched them."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "home"))
    monkeypatch.setattr("mapping.clip.photos.weights.published_file", lambda: None)


@pytest.fixture
def run(run):
    """Run `vizbot config` in an empty folder; return exit code, standard output, error output."""
    return partial(run, "config")


@pytest.fixture
def plug_in(monkeypatch):
    """Have this machine see these serial ports, and a camera if there is one; none at first."""

    def plug_in(*ports, camera=None):
        monkeypatch.setattr(list_ports, "comports", lambda: list(ports))
        context = rs.context() if camera is None else camera.plug_in()
        monkeypatch.setattr(rs, "context", lambda: context)

    plug_in()
    return plug_in


def port(path, vid=0x0403):
    return SimpleNamespace(device=path, vid=vid, pid=0x6001, serial_number="A1", location="1-1")


def test_a_first_file_names_the_port_and_the_camera_that_are_plugged_in(run, plug_in, tmp_path):
    ports = (port("/dev/ttyS0", vid=None), port("/dev/ttyUSB1"), port("/dev/ttyUSB0"))
    plug_in(*ports, camera=SoftwareD435i())
    code, out, err = run("init")
    assert (code, err) == (0, "")
    assert "written: robot.toml" in out and "/dev/ttyUSB0, /dev/ttyUSB1" in out
    config = load_config(tmp_path / "robot.toml")
    assert config.serial_port == "/dev/ttyUSB0"
    assert config.realsense.serial == "900000000001"
    assert Config.model_fields["serial_port"].description in (tmp_path / "robot.toml").read_text()


def test_a_first_file_lets_a_person_choose_the_encoder_by_what_its_time_means(
    run, plug_in, monkeypatch, tmp_path
):
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_CACHE", str(tmp_path / "hub"))
    code, out, _ = run("init")
    text = (tmp_path / "robot.toml").read_text()
    assert code == 0 and "clip: Fetch one, as by `hf download openai/clip-vit-base-patch32`" in out
    assert '\n#clip = "embedded"\n' in text
    for each in CHOICES:
        assert each.encoder in text and f"{each.frame:g} s; {each.meaning}" in text
    rows = [f"| {e.computer} | `{e.encoder}` | {e.frame:g} | {e.meaning} |" for e in CHOICES]
    head = "| computer | settings | a frame, in s | what that means for a search |"
    assert "\n".join([head, "|---|---|---|---|", *rows]) in (ROOT / "docs/robot.md").read_text()


def test_a_first_file_names_an_encoder_that_was_fetched(run, plug_in, monkeypatch, tmp_path):
    save_tiny_clip(tmp_path / "hub/models--openai--clip-vit-large-patch14/snapshots/abc")
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_CACHE", str(tmp_path / "hub"))
    assert "clip: Fetched here: ViT-L/14." in run("init")[1]
    assert load_config(tmp_path / "robot.toml").clip == "ViT-L/14"


def test_a_first_file_names_the_classes_of_photographs_where_they_are_all_there_is(
    run, plug_in, monkeypatch, tmp_path
):
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_CACHE", str(tmp_path / "hub"))
    monkeypatch.setattr("mapping.clip.photos.weights.published_file", lambda: tmp_path / "some.pth")
    assert "clip: Fetched here: photos." in run("init")[1]
    assert load_config(tmp_path / "robot.toml").clip == "photos"


def test_a_port_with_an_odd_name_spoils_no_first_file(run, plug_in, tmp_path):
    path = '/dev/tty"\n\x00\x1b[2J\x7f\\USB'
    plug_in(port(path))
    assert run("init")[0] == 0
    assert load_config(tmp_path / "robot.toml").serial_port == path


def test_a_first_file_without_devices_says_so_and_sets_nothing(run, plug_in, tmp_path):
    plug_in(port("/dev/ttyS0", vid=None))
    assert run("init")[0] == 0
    text = (tmp_path / "robot.toml").read_text()
    assert load_config(tmp_path / "robot.toml") == Config()
    assert text.replace("\n# ", " ").count("None was seen here") == 2
    assert "\n#serial_port = " in text and "\n#serial = ...\n" in text


def test_a_first_file_is_written_without_the_realsense_sdk_and_says_so(
    run, plug_in, monkeypatch, tmp_path
):
    monkeypatch.setitem(sys.modules, "drivers.realsense.examination", None)
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    for module in ("drivers.realsense.examination", "drivers.realsense.sdk"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    assert run("init")[0] == 0
    assert "RealSense SDK is not installed" in (tmp_path / "robot.toml").read_text()


def test_ports_that_cannot_be_listed_are_no_error_of_a_first_file(run, plug_in, monkeypatch):
    monkeypatch.setattr(list_ports, "comports", raising(KeyError("gone")))
    code, out, _ = run("init")
    assert code == 0 and "None was seen here: the serial ports: 'gone'" in out


def test_a_file_with_every_setting_changes_none_and_each_can_be_taken_as_it_stands(
    run, plug_in, tmp_path
):
    assert run("init", "--all", "--out", "all.toml")[0] == 0
    text = (tmp_path / "all.toml").read_text()
    assert with_rehearsal(load_config(tmp_path / "all.toml")) == with_rehearsal(Config())
    (tmp_path / "taken.toml").write_text(re.sub(r".* = \.\.\.\n", "", SETTING.sub("", text)))
    taken = load_config(tmp_path / "taken.toml")
    filters = taken.realsense.filters.model_copy(update={"spatial": None, "temporal": None})
    realsense = taken.realsense.model_copy(update={"filters": filters})
    assert taken.model_copy(update={"realsense": realsense}) == with_rehearsal(Config())
    assert taken.realsense.filters.spatial and taken.realsense.filters.temporal


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), ("robot.toml is there already", "--out", "--force")),
        (("--out", "lost"), ("lost is there already", "--force")),
        (("--out", "folder", "--force"), ("folder is there and is not a file",)),
        (("--out", "nowhere/robot.toml"), ("nowhere/robot.toml", "give another file")),
        (("--out", 300 * "a"), ("File name too long", "give another file")),
    ],
)
def test_a_first_file_that_cannot_be_written_is_one_line(run, plug_in, tmp_path, arguments, words):
    (tmp_path / "robot.toml").write_text("half = true\n")
    (tmp_path / "lost").symlink_to("nothing")
    (tmp_path / "folder").mkdir()
    assert_one_line(run("init", *arguments), *words)
    assert (tmp_path / "robot.toml").read_text() == "half = true\n"


def test_a_file_is_replaced_on_request(run, plug_in, tmp_path):
    (tmp_path / "robot.toml").write_text("half = true\n")
    assert run("init", "--force")[0] == 0
    assert load_config(tmp_path / "robot.toml") == Config()


def test_the_settings_in_use_are_shown_as_a_file_that_is_read_back_the_same(run, tmp_path):
    (tmp_path / "mine.toml").write_text("[mount]\nheight = 0.7\n")
    code, out, err = run("show", "--config", "mine.toml")
    assert (code, err) == (0, "")
    (tmp_path / "shown.toml").write_text(out)
    shown, mine = load_config(tmp_path / "shown.toml"), load_config(tmp_path / "mine.toml")
    assert shown == with_rehearsal(mine)


def test_where_no_file_is_found_the_defaults_are_shown_and_named(run):
    code, out, err = run("show")
    assert code == 0 and Config.model_validate(tomllib.loads(out)) == with_rehearsal(Config())
    assert err == "settings: the defaults, since no file was given or found\n"


def test_the_schema_describes_every_setting(run):
    code, out, err = run("schema")
    assert (code, err) == (0, "")
    models = json.loads(out)
    tables = [models, *models["$defs"].values()]
    fields = {key: each for table in tables for key, each in table.get("properties", {}).items()}
    assert fields["height"]["description"] and {"tilt", "serial_port"} <= set(fields)
    described = [key for key, each in fields.items() if "description" in each or "$ref" in each]
    assert described == list(fields)


def fields_below(model):
    """Every setting and table of a model of settings, at any depth."""
    for name, field in model.model_fields.items():
        yield f"{model.__name__}.{name}", field
        for kind in (field.annotation, *get_args(field.annotation)):
            if isinstance(kind, type) and issubclass(kind, BaseModel):
                yield from fields_below(kind)


FIELDS = dict(fields_below(Config))


@pytest.mark.parametrize("key", [key for key, field in FIELDS.items() if field.description])
def test_each_description_is_a_sentence_that_can_be_read_alone(key):
    text = " ".join(FIELDS[key].description.split())
    assert text[0].isupper() and text.endswith(".")
    assert not re.search(r"(?i)^(as|the same)\b|\blikewise\b|\bsuch\b", text)


def test_at_most_60_settings_are_for_people_and_a_first_file_shows_them_alone(
    run, plug_in, tmp_path
):
    plain = {
        f"{table.heading.strip('[]')}.{each.name}".lstrip(".")
        for table in all_tables()
        for each in table.settings
        if not each.advanced
    }
    assert 50 < len(plain) <= 60
    for key in ("clip", "serial_port", "mount.tilt", "roomba.max_wheel_speed", "realsense.fps"):
        assert key in plain
    assert run("init")[0] == 0
    text, table, shown = (tmp_path / "robot.toml").read_text(), "", set()
    for line in text.splitlines():
        if heading := re.fullmatch(r"\[([\w.]+)\]", line):
            table = f"{heading[1]}."
        elif setting := re.match(r"#(\w+) = ", line):
            shown.add(table + setting[1])
    assert shown == plain
    _, page, _ = run("schema", "--markdown")
    first = page.partition("## Settings for people")[2].partition("## Advanced settings")[0]
    assert len(re.findall(r"^\| `", first, re.MULTILINE)) == len(plain)


def test_the_schema_marks_each_setting_as_advanced_or_not():
    schema = Config.model_json_schema()
    marks = {
        name: field.get("advanced")
        for model in (schema, *schema["$defs"].values())
        for name, field in model.get("properties", {}).items()
    }
    assert (marks["serial_port"], marks["embedding_latency"], marks["mount"]) == (False, True, None)


def test_the_search_has_at_most_half_of_the_47_settings_that_it_once_had():
    objectnav = Config().objectnav.model_dump()
    tables = [each for each in (objectnav, *objectnav.values()) if isinstance(each, dict)]
    values = [key for each in tables for key in each if not isinstance(each[key], dict)]
    assert {"method", "finding_density", "seconds"} <= set(values)
    assert len(values) <= 47 // 2


def test_the_page_of_all_settings_is_what_the_settings_say(run):
    code, out, _ = run("schema", "--markdown")
    assert code == 0
    assert (ROOT / "docs" / "settings.md").read_text() == out, (
        "write it anew: vizbot config schema --markdown > docs/settings.md"
    )
