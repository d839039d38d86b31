"""A standard error that cannot be written to costs lines, not the run."""

import json
import os
import subprocess
import sys
import threading

import pytest

from tests.helpers.broken_streams import ASLEEP, BROKEN, broken_stream
from vizbot.cli.standard_error import LossyFile

pytestmark = pytest.mark.slow

PROGRAM = """
import logging, sys, typer
from vizbot.cli.app import main
from vizbot.cli import app as cli
from vizbot.commands.progress import Progress
from vizbot.core.observer import GoalReport, Outcome

@cli.app.command()
def talk(path: str) -> None:
    with Progress() as progress:
        for _ in range(1000):
            progress.on_goal(GoalReport("sofa", Outcome.ARRIVED, "so it is", ()))
            logging.warning("a warning")
            typer.echo("a line", err=True)
            print("a line", file=sys.stderr, flush=True)
    with open(path, "w") as kept:
        kept.write(str(kept.fileno()))

main()
"""


def run(kind, *command, **options):
    """Run a program with such a standard error."""
    with broken_stream(kind, 2, command) as (file, whole):
        return subprocess.run(whole, stderr=file, timeout=120, **options)


@pytest.mark.parametrize("kind", BROKEN | ASLEEP)
def test_progress_and_logs_that_cannot_be_written_are_lost(kind, tmp_path):
    kept = tmp_path / "kept"
    assert run(kind, sys.executable, "-c", PROGRAM, "talk", str(kept)).returncode == 0
    assert int(kept.read_text()) > 2  # no file takes the place of standard error


def test_a_closed_standard_input_is_an_empty_one(tmp_path):
    (settings := tmp_path / "robot.toml").write_text('serial_port = "/dev/null"\n')
    question = [sys.executable, "-m", "vizbot", "calibrate", "--camera", "sim"]
    question += ["--config", str(settings)]
    with broken_stream("nothing", 0, question) as (_, whole):
        done = subprocess.run(whole, capture_output=True, text=True, timeout=120)
    assert done.returncode == 1
    assert done.stderr == "vizbot: nobody confirmed that the robot may drive; use --yes\n"


@pytest.mark.sampled("a full disk", "a stalled journal")
@pytest.mark.parametrize("kind", BROKEN | ASLEEP)
def test_a_run_whose_progress_cannot_be_written_saves_its_map(kind, tmp_path):
    (tmp_path / "short.toml").write_text("[objectnav]\nmax_steps = 3\n")
    done = run(
        kind,
        *(sys.executable, "-m", "vizbot", "dry-run", "sofa", "--world", "5", "--json"),
        *("--config", "short.toml", "--out", "run"),
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.returncode == 1
    result = json.loads(done.stdout)
    assert result["steps"] == 3 and result["goals"][0]["outcome"] == "gave_up"
    assert (tmp_path / "run" / "map").is_dir()


def test_a_reader_that_wakes_up_gets_what_is_written_then():
    reading, writing = os.pipe()
    try:
        with LossyFile(writing) as file:
            for _ in range(40):
                file.write(b"x" * 4096)
            os.read(reading, 1 << 20)
            file.write(b"awake")
        assert os.read(reading, 1 << 20).endswith(b"awake")
        assert os.get_blocking(writing)  # as other programs have it
    finally:
        os.close(reading)
        os.close(writing)


def test_a_reader_that_is_slow_gets_everything():
    reading, writing = os.pipe()
    lines = [b"%06d\n" % number for number in range(40_000)]
    got = bytearray()

    def read():
        while piece := os.read(reading, 1024):
            got.extend(piece)

    taking = threading.Thread(target=read)
    taking.start()
    try:
        with LossyFile(writing) as file:
            file.write(b"".join(lines))
    finally:
        os.close(writing)
    taking.join(10.0)
    os.close(reading)
    assert bytes(got) == b"".join(lines)
