"""Spoilt settings and odd arguments end a command in one line, before a device is opened."""

import os

import pytest

from vizbot.commands import calibrate, open_run, teleop
from vizbot.core.errors import DeviceError

COMMANDS = {
    "launch": ["launch", "--force", "--clip", "embedded"],
    "calibrate": ["calibrate", "--yes"],
    "teleop": ["teleop"],
}
SETTINGS = {
    "lists 900 deep": b"clip = " + 900 * b"[" + 900 * b"]",
    "lists 50,000 deep": b"clip = " + 50_000 * b"[" + 50_000 * b"]",
    "tables 900 deep": b"[" + b".".join(900 * [b"a"]) + b"]\nx = 1",
    "a number of 5,000 digits": b"clip = 1" + 5000 * b"0",
    "a setting of 4,000 digits": b"[objectnav]\nmax_steps = 1" + 4000 * b"0",
    "NaN": b"[mount]\nheight = nan",
    "infinity": b"[roomba]\ncommand_timeout = inf",
    "not UTF-8": b'clip = "caf\xe9"',
    "UTF-16": "clip = 'embedded'".encode("utf-16"),
    "half a character": b'clip = "\\ud800"',
    "patches of 2^1100": b"[perception.clip_mapper]\nscales = [1100]",
    "an escape as a name": b'"\\u001b[2J" = 1',
    "a name of 100,000 letters": 100_000 * b"a" + b" = 1",
    "2 MB of spaces": 2_000_000 * b" ",
}
PATHS = ["/dev/full", "loop", "folder", "pipe", "", 300 * "a"]


@pytest.fixture
def refused(command_line, monkeypatch, tmp_path):
    """Run a command line at a terminal whose devices cannot be opened; the line that it ends in."""
    opened, terminal = [], os.openpty()

    def open_device(*_arguments, **_options):
        opened.append("a device")
        raise DeviceError("it was opened")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("vizbot.rehearsal.rig.Rig", open_device)
    monkeypatch.setattr(open_run, "opened_devices", open_device)
    monkeypatch.setattr(open_run, "open_encoder", open_device)
    monkeypatch.setattr(calibrate, "opened_devices", open_device)
    monkeypatch.setattr(teleop, "open_base", open_device)
    monkeypatch.setattr(teleop, "_STANDARD_INPUT", terminal[1])

    def run_command(*arguments):
        code, out, err = command_line(*arguments)
        assert (code, out) == (1, "")
        [line] = err.splitlines()
        assert line.isprintable() and len(line) < 700
        assert opened == []
        return line

    yield run_command
    for each in terminal:
        os.close(each)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("settings", SETTINGS)
def test_spoilt_settings_are_refused_by(command, settings, refused, tmp_path):
    (tmp_path / "robot.toml").write_bytes(SETTINGS[settings])
    line = refused(*COMMANDS[command], "--config", "robot.toml")
    assert line.startswith("vizbot: configuration robot.toml")
    assert [path.name for path in tmp_path.iterdir()] == ["robot.toml"]


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("path", PATHS)
def test_settings_that_are_no_file_are_refused_by(command, path, refused, tmp_path):
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    assert "configuration" in refused(*COMMANDS[command], "--config", path)


ARGUMENTS = [
    ["launch", "--out", "loop"],
    ["launch", "--out", "file/run"],
    ["launch", "--out", 300 * "a"],
    ["launch", "--map", "loop"],
    ["launch", "--map", "/dev/full"],
    ["launch", "--port", "65536"],
    ["launch", "--port", "x"],
    ["launch", "kitchen"],
    ["calibrate", "--out", "loop"],
    ["calibrate", "--out", "/dev/full"],
    ["calibrate", "--out", "file/robot.toml"],
    ["calibrate", "--out", 300 * "a"],
    ["calibrate", "--camera", "a\nb"],
    ["calibrate", "--base", "none"],
    ["teleop", "--base", "a\x1b[2J"],
    ["teleop", "--url", ""],
    ["teleop", "--url", "http://"],
    ["teleop", "--url", "http://[::1"],
    ["teleop", "--url", "http://127.0.0.1:99999"],
    ["teleop", "--url", "ftp://robot"],
    ["teleop", "--url", "http://127.0.0.1:9", "--token", "a\nb"],
    ["teleop", "--url", "http://127.0.0.1:9", "--token", "é"],
]


@pytest.mark.parametrize("arguments", ARGUMENTS, ids=lambda each: " ".join(each)[:40])
def test_odd_arguments_are_refused(arguments, refused, tmp_path):
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "file").write_text("")
    assert refused(*arguments).startswith("vizbot: ")
