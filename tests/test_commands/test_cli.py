import os
import runpy
import subprocess
import sys

import pytest

from mapping.map_bundle import load, save
from sim_stubs.world import renderer
from tests.fuzz.spoilt_sequences import write_sequence
from tests.helpers.bundles import bundle_of
from tests.helpers.checkout import ROOT
from tests.helpers.failing import assert_one_line, raising
from vizbot import __version__
from vizbot.cli import app as cli
from vizbot.core.errors import DeviceError
from vizbot.core.program.interrupts import is_interrupt
from vizbot.doctor import Finding, Grade


def test_the_version_is_one_line_and_imports_nothing_heavy(run):
    assert run("--version") == (0, f"vizbot {__version__}\n", "")
    script = (
        "import sys; from vizbot.cli.app import main; sys.argv = ['vizbot', '--version']\n"
        "heavy = ('numpy', 'torch', 'mujoco', 'gtsam', 'cv2', 'pydantic', 'rerun')\n"
        "try: main()\n"
        "except SystemExit: print([m for m in heavy if m in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert shown.stdout.splitlines()[-1] == b"[]"


def test_the_shell_completes_commands_and_options(run, monkeypatch):
    monkeypatch.setattr("shellingham.detect_shell", lambda: ("bash", "/bin/bash"))
    _, script, _ = run("--show-completion")
    assert "_VIZBOT_COMPLETE=complete_bash" in script
    monkeypatch.setenv("_VIZBOT_COMPLETE", "complete_bash")
    for words, completed in (("vizbot lau", "launch"), ("vizbot dry-run --fau", "--faults")):
        monkeypatch.setenv("COMP_WORDS", words)
        monkeypatch.setenv("COMP_CWORD", str(words.count(" ")))
        assert run()[1].split() == [completed]


@pytest.mark.parametrize(
    "arguments", [("--verbose", "dry-run"), ("dry-run", "--verbose")], ids=["before", "behind"]
)
def test_verbose_stands_before_or_behind_the_command(run, monkeypatch, arguments):
    shown = []
    monkeypatch.setattr(cli, "show_events", lambda: shown.append("events"))
    assert not run(*arguments, "--faults", "list")[0]
    assert shown == ["events"]


def test_rerun_that_is_not_installed_is_one_line_and_leaves_nothing(run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)
    for command in (("dry-run", "sofa"), ("launch", "--clip", "embedded")):
        assert_one_line(run(*command, "--rerun"), "--rerun", "pip install rerun-sdk")
    assert list(tmp_path.iterdir()) == []


def test_driving_by_hand_without_a_terminal_or_a_base_is_one_line(run, monkeypatch):
    nothing = os.open(os.devnull, os.O_RDONLY)
    monkeypatch.setattr("vizbot.commands.teleop._STANDARD_INPUT", nothing)
    assert_one_line(run("teleop"), "no terminal", "ssh -t")
    assert_one_line(run("teleop", "--base", "none"), "none", "roomba or sim")
    os.close(nothing)


def test_the_faults_can_be_listed(run):
    code, out, err = run("dry-run", "--faults", "list")
    assert not code
    assert err == ""
    for name in ("port-vanishes", "cannot stop", "kidnapped"):
        assert name in out


def test_a_map_is_built_over_another_one_with_force(run, tmp_path, monkeypatch, mean_colours):
    monkeypatch.setattr("vizbot.commands.map.open_encoder", lambda *_: mean_colours)
    write_sequence(tmp_path / "walk")
    save(bundle_of(frames=0), tmp_path / "home")
    command = ("map", "build", "walk", "--out", "home")
    assert_one_line(run(*command), "home is a map already", "--force")
    assert len(load(tmp_path / "home").trajectory.stamps) == 0
    assert run(*command, "--force")[0] == 0
    assert len(load(tmp_path / "home").trajectory.stamps) == 4


def test_what_the_doctor_finds_bad_keeps_launch_from_opening_devices_unless_forced(
    run, monkeypatch, tmp_path
):
    opened = []

    def open_rig(*_arguments):
        opened.append("rig")
        raise DeviceError("the wheels are gone; find them")

    camera = Finding("camera", Grade.BAD, "none found", "plug it in")
    monkeypatch.setattr("vizbot.commands.launch.examine", lambda *_: [camera])
    monkeypatch.setattr("vizbot.commands.open_run.opened_devices", open_rig)
    monkeypatch.setattr("vizbot.commands.launch.require_devices", lambda *_: None)
    launch = ("launch", "--clip", "embedded", "--port", "0")
    assert_one_line(run(*launch), "camera: none found; plug it in", "--force")
    assert opened == []
    assert_one_line(run(*launch, "--force"), "the wheels are gone")
    assert opened == ["rig"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_port_that_is_no_roomba_is_one_line(run, tmp_path):
    master, slave = os.openpty()
    config = tmp_path / "robot.toml"
    config.write_text(f'serial_port = "{os.ttyname(slave)}"\n[roomba]\nstart_timeout = 0.5\n')
    try:
        result = run("dry-run", "chair", "--base", "roomba", "--config", "robot.toml")
    finally:
        os.close(master)
        os.close(slave)
    assert_one_line(result, "Roomba", "/dev/pts/")
    assert not (tmp_path / "runs").exists()


def test_without_arguments_the_help_is_shown(run):
    _, out, _ = run()
    assert "dry-run" in out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--start", "1,2"), ("--start '1,2'", "X,Y,YAW_DEGREES")),
        (("--start", "1,2,nan"), ("--start '1,2,nan'",)),
        (("--start", "-100,0,0"), ("--start -100,0", "nearest free place")),
        (("--labels", "labels.toml"), ("labels.toml", "MJCF", "'1100'")),
        (("--start", "1,2,0", "--camera", "realsense"), ("--start", "'realsense'")),
        (("--world", "nowhere.xml"), ("nowhere.xml", "not there")),
    ],
)
def test_a_world_that_cannot_be_used_is_refused_before_the_encoder_opens(
    run, monkeypatch, arguments, words
):
    opened = raising(AssertionError("the encoder was opened"))
    monkeypatch.setattr("vizbot.commands.open_run.open_encoder", opened)
    assert_one_line(run("dry-run", "chair", "--world", "1100", *arguments), *words)


def test_an_interrupted_command_says_so(run, monkeypatch):
    monkeypatch.setattr("vizbot.commands.calibrate.load_settings", raising(KeyboardInterrupt()))
    assert run("calibrate") == (130, "", "vizbot: interrupted\n")


def test_an_import_that_is_interrupted_is_no_missing_library(monkeypatch):
    class Interrupted:
        @staticmethod
        def find_spec(name, *_):
            if name == "mujoco":
                raise ImportError("initialization failed") from KeyboardInterrupt()

    monkeypatch.delitem(sys.modules, "mujoco", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Interrupted, *sys.meta_path])
    with pytest.raises(KeyboardInterrupt):
        runpy.run_path(renderer.__file__)


def test_an_interrupt_in_compiled_code_is_an_interrupt():
    error = SystemError("returned a result with an exception set")
    assert not is_interrupt(error)
    error.__cause__ = KeyboardInterrupt()
    assert is_interrupt(error)
    assert is_interrupt(KeyboardInterrupt())


@pytest.mark.parametrize(
    "arguments",
    [
        ("dry-run", "\udcff"),
        ("dry-run", "chair \udcff"),
        ("dry-run", "sofa", "--out", "\udcff"),
        ("goal", "a\udcff"),
    ],
)
def test_an_argument_that_is_not_utf8_is_refused(run, arguments):
    assert_one_line(run(*arguments), r"\udcff", "is not UTF-8")


def test_an_error_is_one_line_whatever_it_names(run, tmp_path):
    (tmp_path / "odd.toml").write_text('"a\\nb" = 1')
    assert_one_line(run("dry-run", "sofa", "--config", "odd.toml"), "there is no setting a b;")


@pytest.mark.slow
def test_a_file_of_the_working_folder_stands_for_no_folder_of_ours(tmp_path):
    for name in ("nav", "mapping", "drivers"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('not ours')")
    done = subprocess.run(
        [sys.executable, "-m", "vizbot", "dry-run", "sofa", "--world", "nowhere"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1 and "unknown world 'nowhere'" in done.stderr
