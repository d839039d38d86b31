"""Which settings file a command uses that was given none."""

import json
import sys
from pathlib import Path

import pytest
from pydantic import ValidationError

from benchmarks.slam import homes
from drivers.roomba.serial_port import open_serial
from mapping import map_bundle
from tests.helpers.bundles import bundle_of
from tests.helpers.failing import assert_one_line
from vizbot import doctor as doctor_checks
from vizbot.commands import calibrate, doctor, teleop
from vizbot.commands import map as map_command
from vizbot.commands.config.discovery import load_settings, settings_file
from vizbot.commands.config.settings_table import all_tables
from vizbot.commands.options import DryRunOptions, RunOptions
from vizbot.commands.run_plan import plan_dry_run, plan_run
from vizbot.config import Config
from vizbot.core.errors import ConfigError, DeviceError


@pytest.fixture
def places(tmp_path, monkeypatch):
    """The places where settings are looked for, all empty, in the order in which they count."""
    (tmp_path / "here").mkdir()
    (tmp_path / "home" / "vizbot").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "home"))
    monkeypatch.setenv("VIZBOT_CONFIG", "")
    return [tmp_path / "named.toml", Path("robot.toml"), tmp_path / "home/vizbot/robot.toml"]


def ending(seen, read=lambda given: given, place=0):
    """What keeps what it reads of one of its arguments, and ends the command."""

    def end(*arguments, **_named):
        seen.append(read(arguments[place]))
        raise ConfigError("enough was seen; end here")

    return end


def test_the_first_place_with_a_file_counts_and_one_line_names_it(places, monkeypatch, capfd):
    assert load_settings(None) == Config() and settings_file(None) is None
    assert capfd.readouterr() == ("", "")
    for place in reversed(places):
        place.write_text("")
        if place == places[0]:
            monkeypatch.setenv("VIZBOT_CONFIG", str(place))
        assert load_settings(None) == Config() and settings_file(None) == place
        where = ", found in this folder" if place == places[1] else ""
        assert capfd.readouterr() == ("", f"settings: {place}{where}\n")


def test_without_xdg_the_persons_settings_are_in_their_home(places, monkeypatch, tmp_path):
    monkeypatch.delenv("XDG_CONFIG_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    mine = tmp_path / ".config/vizbot/robot.toml"
    mine.parent.mkdir(parents=True)
    mine.touch()
    assert settings_file(None) == mine


def test_a_file_that_is_given_counts_alone_and_is_not_named(places, capfd):
    places[1].write_text("half = true")
    Path("mine.toml").write_text("")
    assert load_settings(Path("mine.toml")) == Config()
    assert settings_file(Path("mine.toml")) == Path("mine.toml")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("named", ["none.toml", "none/robot.toml", 300 * "a"])
def test_a_variable_that_names_a_missing_file_is_one_line(places, monkeypatch, command_line, named):
    places[1].write_text("")
    monkeypatch.setenv("VIZBOT_CONFIG", named)
    for command in (("config", "show"), ("launch",), ("dry-run", "sofa"), ("doctor", "--json")):
        told = f"VIZBOT_CONFIG names {named}, which is not there"
        assert_one_line(command_line(*command), told, "unset it")


def test_a_found_file_that_cannot_be_used_is_one_line_that_names_it(places, command_line):
    places[1].symlink_to("nothing")
    told = "configuration robot.toml: No such file or directory"
    assert_one_line(command_line("config", "show"), told)
    places[1].unlink()
    places[1].write_text("[mount]\nhieght = 0.7\n")
    told = "configuration robot.toml: there is no setting mount.hieght; use height"
    assert_one_line(command_line("dry-run", "sofa"), told)


COMMANDS = {
    "launch": lambda run: plan_run(run).config,
    "dry-run": lambda run: plan_dry_run(DryRunOptions(goals=["sofa"], run=run)).run.config,
}
"""What makes the settings of a run from its options."""


@pytest.mark.parametrize("command", COMMANDS)
def test_a_run_takes_the_settings_that_are_found(places, command):
    places[1].write_text("[mount]\nheight = 0.65\n")
    assert COMMANDS[command](RunOptions()).mount.height == 0.65


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("method", ["belief", "paper"])
def test_a_run_searches_by_the_method_that_is_asked_for(places, command, method):
    places[1].write_text(f'[objectnav]\nmethod = "{"paper" if method == "belief" else "belief"}"\n')
    assert COMMANDS[command](RunOptions(method=method)).objectnav.method == method


@pytest.mark.parametrize(
    ("module", "arguments"),
    [
        (doctor, ("doctor",)),
        (calibrate, ("calibrate", "--yes")),
        (teleop, ("teleop",)),
        (map_command, ("map", "build", "walk", "--out", "map")),
        (map_command, ("map", "query", "map", "sofa")),
    ],
    ids=lambda each: " ".join(each[:2]) if isinstance(each, tuple) else "",
)
def test_every_other_command_with_settings_takes_them_too(
    places, command_line, monkeypatch, module, arguments
):
    places[2].write_text("")
    loaded = []
    monkeypatch.setattr(module, "load_settings", ending(loaded, settings_file))
    monkeypatch.setattr(teleop, "require_terminal", lambda _: None)
    assert command_line(*arguments)[0] == 1
    assert loaded == [places[2]]


def test_a_calibration_goes_into_the_file_that_was_found(places, command_line, monkeypatch):
    places[1].write_text("half = false\n")
    asked = []
    monkeypatch.setattr(calibrate, "require_writable", ending(asked))
    assert command_line("calibrate", "--yes")[0] == 1
    assert asked == [places[1]]


def test_json_on_standard_output_stays_alone_where_a_file_was_found(
    places, command_line, monkeypatch
):
    places[1].write_text("")
    monkeypatch.setattr(doctor, "examine", lambda *_: [])
    code, out, err = command_line("doctor", "--json")
    assert code == 0 and json.loads(out) == {"well": True, "findings": []}
    assert err == "settings: robot.toml, found in this folder\n"


def test_a_benchmark_depends_on_no_file_that_is_found(places, command_line, monkeypatch):
    used = []
    monkeypatch.setattr(homes, "run_slam_homes", ending(used, place=2))
    places[1].write_text("[mount]\nheight = 0.65\n")
    for named in ("robot.toml", "none.toml"):
        monkeypatch.setenv("VIZBOT_CONFIG", named)
        _, _, err = command_line("bench", "slam")
        assert err == "vizbot: enough was seen; end here\n"
    assert used == [Config(), Config()]


def test_the_help_says_where_settings_are_looked_for_and_that_benchmarks_look_nowhere(command_line):
    launch = " ".join(command_line("launch", "--help")[1].split())
    benches = " ".join(command_line("bench", "objectnav", "--help")[1].split())
    assert "VIZBOT_CONFIG" in launch
    assert "VIZBOT_CONFIG" not in benches and "no file" in benches


@pytest.fixture
def evil(places):
    """A class that leaves a trace, in the folder where commands are started."""
    Path("evil.py").write_text(
        "from pathlib import Path\nPath('trace').touch()\nclass Encoder: pass\n"
    )
    yield Path("trace")
    sys.modules.pop("evil", None)
    sys.path[:] = [each for each in sys.path if each != str(Path.cwd())]


@pytest.mark.parametrize(
    "command",
    [
        ("doctor", "--json"),
        ("launch", "--force"),
        ("dry-run", "sofa"),
        ("calibrate", "--yes"),
        ("teleop", "--base", "sim"),
        ("config", "show"),
        ("map", "build", "walk", "--out", "map"),
        ("map", "query", "map", "sofa"),
    ],
    ids=" ".join,
)
def test_a_settings_file_that_lies_in_the_working_folder_runs_no_code(
    places, command_line, evil, monkeypatch, command
):
    monkeypatch.setattr(teleop, "require_terminal", lambda _: None)
    map_bundle.save(bundle_of(model_id="evil:Encoder"), Path("map"))
    places[1].write_text('clip = "evil:Encoder"\n')
    told = "robot.toml was found in this folder and names a class, evil:Encoder"
    assert_one_line(command_line(*command), told, "--clip evil:Encoder, or --config robot.toml")
    assert not evil.exists() and "evil" not in sys.modules


@pytest.mark.parametrize("how", ["--clip", "--config", "VIZBOT_CONFIG", "home", "in the home"])
def test_a_class_is_opened_where_a_person_names_it(places, command_line, evil, monkeypatch, how):
    arguments = {"--clip": ("evil:Encoder",), "--config": ("robot.toml",)}.get(how, ())
    place = places[2] if how in ("home", "in the home") else places[1]
    place.write_text('clip = "evil:Encoder"\n')
    if how == "VIZBOT_CONFIG":
        monkeypatch.setenv("VIZBOT_CONFIG", "robot.toml")
    if how == "in the home":
        monkeypatch.chdir(place.parent)
        Path("evil.py").write_text("from pathlib import Path\nPath('trace').touch()\n")
    monkeypatch.setattr(doctor_checks, "_camera", lambda *_: iter(()))
    _, out, _ = command_line("doctor", "--json", *((how, *arguments) if arguments else ()))
    assert Path("trace").exists()
    [clip] = [each for each in json.loads(out)["findings"] if each["subject"] == "CLIP"]
    assert clip["verdict"] == "bad" and "evil:Encoder" in clip["found"]


def test_no_other_setting_is_text_that_could_name_what_runs():
    """A new setting that is text belongs here once it is known what a stranger does by it."""
    paths = {
        f"{table.heading.strip('[]')}.{each.name}".lstrip(".")
        for table in all_tables()
        for each in table.settings
        if each.values == "text"
    }
    # A calibration holds numbers, each within bounds; any other file is refused in one line.
    assert paths == {
        "clip", "clip_calibration", "device", "serial_port", "calibration.date", "realsense.serial"
    }  # fmt: skip
    for address in (
        "alt:///dev/null?class=PosixPollSerial",
        "spy:///dev/null?file=trace",
        "evil.py",
    ):
        with pytest.raises(DeviceError, match=r"no such port|not a serial port"):
            open_serial(address)
    with pytest.raises(ValidationError):
        Config(device="evil:Device")
