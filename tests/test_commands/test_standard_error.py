"""A standard error that cannot be written to costs lines, not the run."""

import json
import os
import subprocess
import sys

import pytest

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


def closed_pipe():
    reading, writing = os.pipe()
    os.close(reading)
    return writing


STANDARD_ERRORS = {
    "a closed pipe": closed_pipe,
    "a full disk": lambda: os.open("/dev/full", os.O_WRONLY),
    "nothing": lambda: None,
}


def run(kind, *command, **options):
    """Run a program with such a standard error; None closes it."""
    number = STANDARD_ERRORS[kind]()
    closing = ["sh", "-c", 'exec "$@" 2>&-', "sh"] if number is None else []
    try:
        return subprocess.run([*closing, *command], stderr=number, timeout=120, **options)
    finally:
        if number is not None:
            os.close(number)


@pytest.mark.parametrize("kind", STANDARD_ERRORS)
def test_progress_and_logs_that_cannot_be_written_are_lost(kind, tmp_path):
    kept = tmp_path / "kept"
    done = run(kind, sys.executable, "-c", PROGRAM, "talk", str(kept))
    assert done.returncode == 0
    assert int(kept.read_text()) > 2  # no file takes the place of standard error


@pytest.mark.parametrize("kind", STANDARD_ERRORS)
def test_a_run_whose_progress_cannot_be_written_saves_its_map(kind, tmp_path):
    (tmp_path / "short.toml").write_text("[objectnav]\nmax_steps = 3\n")
    command = [sys.executable, "-m", "vizbot", "dry-run", "sofa", "--world", "5", "--json"]
    done = run(
        kind,
        *command,
        *("--config", "short.toml", "--out", "run"),
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.returncode == 1
    result = json.loads(done.stdout)
    assert result["steps"] == 3 and result["goals"][0]["outcome"] == "gave_up"
    assert (tmp_path / "run" / "map").is_dir()
