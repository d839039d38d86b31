"""A program that is killed takes along what it has started, and leaves what it has written."""

import os
import signal
import subprocess
import sys
import time
import uuid
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from mapping.tum import read_trajectory
from tests.helpers import filmed_room
from tests.helpers.roomba_rig import DEADLINE, wait_for
from tests.tools.interrupted_runs import ROOM
from vizbot.core.program.interpreter import interpreter_command

pytestmark = pytest.mark.slow

_MARK = "VIZBOT_TEST_MARK"
SOON = 3.0
"""From the kill until nothing is left [s], on a machine with other work; idle it takes 0.1 s."""
DRY_RUN = ["-m", "vizbot", "dry-run", "sofa", "--out", "run"]
POOL = (
    "import time; from benchmarks.harness.workers import in_parallel\n"
    "for _ in in_parallel(time.sleep, [60.0], 'sleeping', lambda *_: ''): pass"
)


@contextmanager
def marked():
    """An environment for a program, and what lists the processes that have it.

    What is left of them in the end is killed.
    """
    mark = uuid.uuid4().hex

    def alive():
        return dict(_with(f"{_MARK}={mark}".encode()))

    try:
        yield os.environ | {_MARK: mark, "PYTHONPATH": str(Path.cwd())}, alive
    finally:
        for pid in alive():
            os.kill(pid, 9)


def _with(mark):
    for process in Path("/proc").iterdir():
        if not process.name.isdigit():
            continue
        try:
            if mark not in (process / "environ").read_bytes().split(b"\0"):
                continue
            if (process / "stat").read_text().rpartition(")")[2].split()[0] != "Z":
                command = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode()
                yield int(process.name), command
        except OSError:  # it has just ended
            continue


@contextmanager
def begun(arguments, folder):
    """A program in a folder, and what lists its processes."""
    with (
        marked() as (environment, alive),
        subprocess.Popen(
            [sys.executable, *arguments], cwd=folder, env=environment,
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        ) as program,
    ):  # fmt: skip
        try:
            yield program, alive
        finally:
            program.kill()


@pytest.mark.parametrize(
    ("arguments", "parts", "later"),
    [
        pytest.param([*DRY_RUN, "--world", "1100"], ["plan_process"], 0.0, marks=pytest.mark.long),
        ([*DRY_RUN, "--world", "1100"], ["plan_process"], 1.0),
        ([*DRY_RUN, "--serve", "--port", "0", "--world", "room.xml"], ["acceptor"], 0.0),
        ([*filmed_room.LAUNCH, "--config", "robot.toml"], ["acceptor", "spawn_main"], 0.0),
        (["-c", POOL], ["spawn_main"], 3.0),  # when the job has begun
    ],
    ids=["drawer of a home at once", "drawer of a home", "acceptor", "parts of a launch", "job"],
)
def test_what_a_killed_program_has_started_ends_with_it(stub, tmp_path, arguments, parts, later):
    """It is killed some time [s] after all have started, which are told by their command lines."""
    (tmp_path / "room.xml").write_text(ROOM)
    (tmp_path / "robot.toml").write_text(filmed_room.settings(stub.path))

    def started():
        assert program.poll() is None
        commands = [command for pid, command in alive().items() if pid != program.pid]
        return all(any(part in command for command in commands) for part in parts)

    with begun(arguments, tmp_path) as (program, alive):
        wait_for(started, pause=0.02)
        time.sleep(later)
        program.kill()
        program.wait()
        end = time.monotonic() + SOON
        while alive() and time.monotonic() < end:
            time.sleep(0.05)
        assert list(alive().values()) == []


def test_a_run_that_is_killed_keeps_its_trajectory_and_commands_until_then(tmp_path):
    (tmp_path / "room.xml").write_text(ROOM)
    with begun([*DRY_RUN, "--world", "room.xml"], tmp_path) as (program, _):
        poses, commands = tmp_path / "run/trajectory.tum", tmp_path / "run/commands.csv"

        def steps():
            assert program.poll() is None
            kept = [each.read_text().count("\n") - 1 for each in (poses, commands) if each.exists()]
            return min(kept, default=0)

        wait_for(lambda: steps() >= 3, pause=0.02)
        program.kill()
        assert program.wait() == -signal.SIGKILL
    stamps, _ = read_trajectory(poses)
    rows = commands.read_text().splitlines()
    assert len(stamps) >= 3 and stamps[0] < stamps[1] < stamps[2]
    assert rows[0] == "stamp,linear,angular,by" and len(rows) - 1 >= 3
    assert float(rows[1].split(",")[0]) == pytest.approx(stamps[0], abs=1e-3)
    assert not (tmp_path / "run/metrics.json").exists()


def test_the_decoder_of_speech_ends_when_nobody_reads_what_it_decodes():
    command = interpreter_command("vizbot.operator.voice.sound_decoder", "wav", "1")
    decoding = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    with decoding, closing(decoding.stdin):
        decoding.stdout.close()  # as the kernel does where its reader is killed
        assert decoding.wait(DEADLINE) == 1


def test_what_computes_without_a_pause_ends_with_the_other_end_of_its_pipe():
    busy = (
        "from vizbot.core.program.interpreter import end_when_left; end_when_left(1)\n"
        "print('on', flush=True)\nwhile True: pass"
    )
    with subprocess.Popen([sys.executable, "-c", busy], stdout=subprocess.PIPE) as computing:
        assert computing.stdout.readline() == b"on\n"
        computing.stdout.close()
        assert computing.wait(DEADLINE) == 1
