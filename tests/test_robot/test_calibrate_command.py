"""What `vizbot calibrate` does to files of settings; the drive itself is left out."""

import errno
import os
import tomllib
from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from mapping.calibration.config import CalibrationConfig
from tests.helpers.failing import raising
from vizbot.calibration.solve import Calibration
from vizbot.commands.calibrate import run, updated
from vizbot.commands.options import CalibrateOptions
from vizbot.config import MountConfig, load_config
from vizbot.core.errors import ConfigError

FOUND = Calibration(
    MountConfig(height=0.6, tilt=0.1), 0.24, 1.01, CalibrationConfig(date="2026-01-02")
)
MINE = '# mine\nserial_port = "/dev/ttyUSB7"  # blue\n\n[realsense]\nemitter = false  # sun\n'


@pytest.fixture
def calibrate(monkeypatch, tmp_path):
    """Run the command in an empty folder; what happens during the drive can be given."""
    monkeypatch.chdir(tmp_path)

    def command(config_path=None, out=None, meanwhile=lambda: None):
        monkeypatch.setattr("vizbot.commands.calibrate.record", lambda *_: meanwhile())
        monkeypatch.setattr("vizbot.commands.calibrate.solve", lambda *_: FOUND)
        no_rig = nullcontext(SimpleNamespace(devices=None))
        monkeypatch.setattr("vizbot.rehearsal.rig.Rig", lambda *_: no_rig)
        run(CalibrateOptions(config_path, out, "sim", "sim", "0", yes=True))

    return command


def test_figures_that_cannot_be_printed_are_written(calibrate, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "vizbot.commands.calibrate.Console",
        raising(OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))),
    )
    with pytest.raises(OSError, match="No space left"):
        calibrate(None, tmp_path / "robot.toml")
    assert load_config(tmp_path / "robot.toml").mount == FOUND.mount


def never():
    pytest.fail("the wheels turned")


@pytest.mark.parametrize("other", [False, True])
def test_a_file_that_is_there_keeps_its_settings(calibrate, tmp_path, other):
    path = tmp_path / "robot.toml"
    path.write_text(MINE)
    (tmp_path / "other.toml").write_text('serial_port = "/dev/ttyUSB1"\n')
    calibrate(tmp_path / "other.toml" if other else None, path)
    assert path.read_text().startswith(MINE)
    assert load_config(path).mount == FOUND.mount


def test_a_new_file_has_the_settings_of_the_other(calibrate, tmp_path):
    (tmp_path / "robot.toml").write_text(MINE)
    calibrate(tmp_path / "robot.toml", tmp_path / "new.toml")
    assert (tmp_path / "new.toml").read_text().startswith(MINE)
    assert (tmp_path / "robot.toml").read_text() == MINE


@pytest.mark.parametrize("text", ["[mount", "mount = 3", "[tool.ruff]\n"])
def test_a_file_of_something_else_is_refused_before_the_wheels_turn(calibrate, tmp_path, text):
    path = tmp_path / "notes.toml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=r"notes\.toml"):
        calibrate(None, path, never)
    assert path.read_text() == text


@pytest.mark.parametrize("out", ["nowhere/robot.toml", ".", "/proc/robot.toml"])
def test_what_cannot_be_written_is_refused_before_the_wheels_turn(calibrate, tmp_path, out):
    with pytest.raises(ConfigError, match="give another file"):
        calibrate(None, tmp_path / out, never)


@pytest.mark.parametrize("becomes", [None, "[mount", "mount = 3"])
def test_a_file_that_is_gone_or_torn_after_the_drive_costs_no_figures(
    calibrate, tmp_path, capsys, becomes
):
    path = tmp_path / "robot.toml"
    path.write_text(MINE)
    with pytest.raises(ConfigError, match=r"robot\.toml"):
        calibrate(path, None, lambda: path.write_text(becomes) if becomes else path.unlink())
    told = capsys.readouterr().out.split("add this to the robot's settings:")[1]
    assert tomllib.loads(told)["mount"] == FOUND.mount.model_dump()
    assert (path.read_text() if path.exists() else None) == becomes


@pytest.mark.parametrize("between", ["", 'clip = "embedded"  # c\n'])
def test_dotted_keys_keep_their_comments(tmp_path, between):
    path = tmp_path / "robot.toml"
    path.write_text(f"mount.tilt = 0.14  # t\n{between}mount.height = 0.5  # h\n{MINE}")
    text = updated(path, FOUND)
    assert all(comment in text for comment in ("# t", "# h", "# mine", "# blue", "# sun"))
    path.write_text(text)
    assert load_config(path).mount == FOUND.mount


def test_what_cannot_be_calibrated_is_refused():
    for camera, base, remedy in (("walk.db3", "sim", "realsense"), ("sim", "none", "roomba")):
        with pytest.raises(ConfigError, match=f"use {remedy} or sim"):
            run(CalibrateOptions(camera=camera, base=base, yes=True))
