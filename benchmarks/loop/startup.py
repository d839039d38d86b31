"""How long a user waits: for an answer of a saved map, a refusal, the first tick, and for a stop.

Each is a fresh process of `python -m vizbot`, with the embedded encoder. Its files are in the
system's cache after a first process that does not count.
"""

from __future__ import annotations

import os
import re
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from vizbot.core.errors import VizbotError

_FIRST_TICK = re.compile(r"^step +[01]\b")
"""Older commits count from 0."""
_WORLD = "1101"
_THING = "sofa"


@dataclass(frozen=True, slots=True)
class Wait:
    """What one process took.

    Attributes:
        wall: Time from its start to its end, or to its first tick [s].
        processor: Time on processors, of all its threads, until then [s].
    """

    wall: float
    processor: float


def measure_startup(saved_map: Path, runs: int = 5) -> dict[str, Wait]:
    """Medians of the waits, by the keys of the benchmark's summary.

    Args:
        saved_map: The map that is asked.
        runs: Processes of each kind that count.

    Raises:
        VizbotError: a process did not end as it should; the line says how it did.
    """
    query = ("map", "query", str(saved_map), _THING)
    refused = ("dry-run", _THING, "--world", "nosuchworld")
    waits = dict[str, list[Wait]](query_s=[], refused_s=[], first_tick_s=[])
    waits["stop_s"] = _stops(1 + runs)
    for _ in range(1 + runs):
        waits["query_s"].append(_until_end(query, 0))
        waits["refused_s"].append(_until_end(refused, 1))
        with tempfile.TemporaryDirectory() as folder:
            drive = ("dry-run", _THING, "--world", _WORLD, "--out", f"{folder}/run")
            waits["first_tick_s"].append(_until_first_tick(drive))
    return {name: median_wait(each[1:]) for name, each in waits.items()}


def _stops(runs: int) -> list[Wait]:
    """Stops of something that answers as a robot does."""
    with ThreadingHTTPServer(("127.0.0.1", 0), _StoppedRobot) as robot:
        threading.Thread(target=robot.serve_forever, daemon=True).start()
        url = f"http://127.0.0.1:{robot.server_address[1]}"
        waits = [_until_end(("stop", "--url", url), 0) for _ in range(runs)]
        robot.shutdown()
    return waits


class _StoppedRobot(BaseHTTPRequestHandler):
    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(200)
        self.end_headers()
        self.wfile.write(b'{"stopped": true}')

    def log_message(self, *_: object) -> None:
        """Nothing is logged."""


def median_wait(waits: Sequence[Wait]) -> Wait:
    """Median of the wall times, and that of the processor times."""
    return Wait(
        statistics.median(wait.wall for wait in waits),
        statistics.median(wait.processor for wait in waits),
    )


def is_first_tick_in(lines: Iterable[str]) -> bool:
    """Read a run's standard error up to its first tick; false if it ends without one."""
    return any(_FIRST_TICK.match(line) for line in lines)


def _until_end(arguments: Sequence[str], code: int) -> Wait:
    with tempfile.TemporaryFile("w+") as said:
        began = time.monotonic()
        process = _started(arguments, stderr=said.fileno())
        wait, ended = _waited(process, began)
        if ended != code:
            said.seek(0)
            raise _unexpected(arguments, said.read())
    return wait


def _until_first_tick(arguments: Sequence[str]) -> Wait:
    began = time.monotonic()
    process = _started(arguments, stderr=subprocess.PIPE)
    assert process.stderr is not None
    with process.stderr as said:
        lines = list[str]()
        ticks = is_first_tick_in(_kept(said, lines))
        wall = time.monotonic() - began
        process.kill()
        wait, _ = _waited(process, began)
    if not ticks:
        raise _unexpected(arguments, "".join(lines))
    return Wait(wall, wait.processor)


def _kept(lines: Iterable[str], kept: list[str]) -> Iterable[str]:
    for line in lines:
        kept.append(line)
        yield line


def _started(arguments: Sequence[str], stderr: int) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "vizbot", *arguments],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=stderr,
        text=True,
        # Python keeps compiled sources unless somebody has it not to, as build machines do.
        env={k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"},
    )


def _waited(process: subprocess.Popen[str], began: float) -> tuple[Wait, int]:
    """Wait for the end of a process: what it took, and its exit code."""
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.monotonic() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    return Wait(wall, usage.ru_utime + usage.ru_stime), process.returncode


def _unexpected(arguments: Sequence[str], said: str) -> VizbotError:
    last = (said.strip() or "nothing").splitlines()[-1]
    return VizbotError(f"`vizbot {' '.join(arguments)}` did not do as it should; it said: {last}")
