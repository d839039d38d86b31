"""Ctrl-C ends what says so, and interrupts all else once what there is was saved."""

import ctypes
import json
import signal
import subprocess
import sys

import pytest

from benchmarks.objectnav import single_goal
from mapping import map_bundle
from sim_stubs.roomba.serial_line import SerialLine
from vizbot.commands import progress, voice
from vizbot.operator.voice.microphone import Microphone

pytestmark = pytest.mark.usefixtures("signals")


def ctrl_c(*_, **__):
    signal.raise_signal(signal.SIGINT)


def ctrl_c_in_ctypes():
    """What ctypes makes of an interrupt while it converts an argument."""
    raise ctypes.ArgumentError("argument 1: KeyboardInterrupt: ")


def after_three_steps(interrupt):
    """What shows the progress of a run and interrupts it then."""
    shown = progress.Progress.on_step

    def on_step(each, step):
        shown(each, step)
        if step.index == 3:
            interrupt()

    return on_step


def test_ctrl_c_is_how_one_stops_to_speak(run, monkeypatch):
    monkeypatch.setattr(Microphone, "__init__", lambda _: None)
    monkeypatch.setattr(Microphone, "read", ctrl_c)
    monkeypatch.setattr(Microphone, "close", lambda _: None)
    monkeypatch.setattr(voice, "Recogniser", lambda *_, **__: None)
    code, out, err = run("voice", "--wake", "hey robot")
    assert (code, out) == (0, "")
    assert "Ctrl-C ends." in err and "interrupted" not in err


def amid_a_message(monkeypatch):
    """Interrupts where the simulated base has read bytes and nobody has them yet."""
    read = SerialLine._read

    def interrupt_amid_the_next():
        def read_and_interrupt(line, size):
            arrived = read(line, size)
            if arrived:
                monkeypatch.setattr(SerialLine, "_read", read)
                ctrl_c()
            return arrived

        monkeypatch.setattr(SerialLine, "_read", read_and_interrupt)

    return interrupt_amid_the_next


@pytest.mark.slow
@pytest.mark.sampled("between", "amid")  # the run that serves is interrupted in ctypes
@pytest.mark.parametrize("where", ["between", "in ctypes", "amid a message"])
def test_a_dry_run_that_is_interrupted_saves_its_map_and_says_so(run, tmp_path, monkeypatch, where):
    interrupt = {
        "between": ctrl_c,
        "in ctypes": ctrl_c_in_ctypes,
        "amid a message": amid_a_message(monkeypatch),
    }[where]
    monkeypatch.setattr(progress.Progress, "on_step", after_three_steps(interrupt))
    code, out, err = run("dry-run", "sofa", "--world", "5", "--out", "run", "--json")
    assert code == 130
    assert err.splitlines()[-2:] == [
        "what was mapped until then is in run",
        "vizbot: interrupted",
    ]
    assert json.loads(out)["error"] == "interrupted"
    assert json.loads(out) == json.loads((tmp_path / "run/metrics.json").read_text())
    assert (tmp_path / "run/report.html").exists()
    assert len(map_bundle.load(tmp_path / "run" / "map").trajectory.stamps) > 0


@pytest.mark.slow
def test_an_interrupt_is_how_a_run_that_serves_ends_whatever_it_arrives_as(run, monkeypatch):
    monkeypatch.setattr(progress.Progress, "on_step", after_three_steps(ctrl_c_in_ctypes))
    code, out, err = run("dry-run", "--serve", "--port", "0", "--world", "5", "--json")
    assert (code, json.loads(out)["error"]) == (0, None)
    assert "stopping\n" in err


def test_a_benchmark_that_is_interrupted_says_so(run, monkeypatch):
    monkeypatch.setattr(single_goal, "run_single_goal", ctrl_c)
    code, out, err = run("bench", "objectnav", "--quick")
    assert (code, out, err.splitlines()[-1]) == (130, "", "vizbot: interrupted")


def test_ctrl_c_ends_what_is_waited_for_at_the_exit_without_a_traceback():
    program = (
        "import atexit, sys, time; from vizbot.cli import app, process; app.main = lambda: None;"
        " atexit.register(lambda: (print('waiting', flush=True), time.sleep(60))); process.run()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as ended:
        assert ended.stdout.readline() == b"waiting\n"
        ended.send_signal(signal.SIGINT)
        assert ended.wait(30) == -signal.SIGINT and ended.stderr.read() == b""


@pytest.mark.long
def test_a_run_that_is_interrupted_at_any_moment_loses_nothing():
    command = [sys.executable, "-m", "tests.tools.interrupted_runs", "--moments", "5"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
