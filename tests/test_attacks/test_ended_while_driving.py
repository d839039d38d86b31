"""Wheels rest after a command is ended while they turn, also where its output cannot be written."""

import itertools
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import pytest

from tests.helpers import filmed_room
from tests.helpers.beside import beside
from tests.helpers.broken_streams import BROKEN, broken_stream
from tests.helpers.roomba_rig import rested, wait_for
from vizbot.core.types import BaseMode

pytestmark = pytest.mark.slow

UP = b"\x1b[A"
ENDS = [signal.SIGKILL, signal.SIGTERM, signal.SIGHUP]
COMMANDS = {
    "launch": filmed_room.LAUNCH,
    "calibrate": [
        *("-m", "vizbot", "calibrate", "--camera", "sim", "--world", "office", "--yes"),
        *("--out", "calibrated.toml"),
    ],
    "teleop": ["-m", "vizbot", "teleop"],
}
CASES = list(itertools.product(COMMANDS, ENDS, BROKEN))
QUICK = [
    ("launch", signal.SIGTERM, "nothing"),
    ("calibrate", signal.SIGHUP, "a full disk"),
    ("teleop", signal.SIGKILL, "a closed pipe"),
]
SOON = 0.5
"""From the signal until the wheels are told to rest for good [s]; their process has 0.3 s."""
QUIET = 1.0
"""Wheels that have rested for so long stay at rest [s]."""
DEADLINE = 90.0


@contextmanager
def keyboard(typed):
    """A terminal at which somebody types the same all the time."""
    screen, terminal = os.openpty()

    def type_on(over):
        os.set_blocking(screen, False)
        while not over.wait(0.03):
            os.write(screen, typed)
            try:
                os.read(screen, 65536)
            except BlockingIOError:
                continue

    try:
        with beside(type_on):
            yield terminal
    finally:
        os.close(screen)
        os.close(terminal)


@pytest.mark.parametrize(
    ("command", "end", "stream"),
    [
        pytest.param(
            *case,
            id=f"{case[0]}, {case[1].name}, output to {case[2]}",
            marks=() if case in QUICK else pytest.mark.long,
        )
        for case in CASES
    ],
)
def test_wheels_rest_after(command, end, stream, stub, floor, tmp_path):
    (tmp_path / "robot.toml").write_text(filmed_room.settings(stub.path))
    program = [sys.executable, *COMMANDS[command], "--config", "robot.toml"]
    typed = {"teleop": UP, "launch": b"red lamp\n"}.get(command, b"")
    with (
        keyboard(typed) as terminal,
        broken_stream(stream, 1, program) as (out, program),
        broken_stream(stream, 2, program) as (err, program),
        subprocess.Popen(
            program,
            stdin=terminal, stdout=out, stderr=err, cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        ) as running,
    ):  # fmt: skip
        try:
            latest = time.monotonic() + DEADLINE
            while not any(floor.speeds):
                assert running.poll() is None and time.monotonic() < latest, "no wheel turns"
                time.sleep(0.01)
            ended_at = time.monotonic()
            running.send_signal(end)
            wait_for(lambda: rested(floor, QUIET), pause=0.01)
            rested_at = floor.rest_since
            code = running.wait(DEADLINE)
            wait_for(lambda: stub.mode is BaseMode.PASSIVE, pause=0.01)
        finally:
            running.kill()
    assert rested_at == floor.rest_since  # nothing has turned them since
    assert rested_at - ended_at < SOON
    if end == signal.SIGKILL:
        assert code == -end
    elif command == "launch":
        assert code == (0 if stream == "nothing" else 1)  # where its report is has to be printed
        assert (tmp_path / "run/map").is_dir()
    else:
        assert code == (0 if command == "teleop" else 130)  # of which an interrupt is the end
