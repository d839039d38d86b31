"""Worlds in files: homes drawn in Sweet Home 3D, Gazebo's worlds, and MuJoCo's own format.

A process of its own reads them: a file may be damaged, or made to take all time and memory.
"""

from __future__ import annotations

import logging
import os
import pickle
import resource
import signal
import subprocess
import sys
from pathlib import Path

from sim_stubs.homes.geometry.house import House
from sim_stubs.world.world_spec import MJCF, SDF, require_world
from vizbot.core.errors import ConfigError, VizbotError
from vizbot.core.program.interpreter import end_when_left, interpreter_command
from vizbot.core.program.log_records import LogRecords

_PROCESSOR, _MEMORY = 20, 2_000_000_000
"""Most processor time [s] and memory [bytes] to read a world; homes by others take a tenth."""
_WAITING = 40.0
"""Longest time to read a world [s], which may wait for a pipe and take no processor."""
_REMEDY = "save it again in the program that made it, or give another one"


def read_world(
    path: Path, labels: Path | None = None, start: tuple[float, float, float] | None = None
) -> House:
    """The world in a file: MJCF, SDF, `.sh3d`, or an example home in a `.jar`.

    Args:
        path: The file.
        labels: File with labels of what is in an MJCF or SDF file.
        start: x, y [m], yaw [rad] of the robot in an MJCF file that may not say it.

    Raises:
        ConfigError: it is none of these, cannot be read, or takes too long or too much to read.
    """
    require_world(str(path), labels)
    limits = _PROCESSOR, _MEMORY
    level = logging.getLogger().getEffectiveLevel()
    asked = pickle.dumps((path, labels, start, level, limits))
    try:
        done = subprocess.run(
            interpreter_command(__name__),
            input=asked,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,  # what libraries write while they end the process
            timeout=_WAITING,
            check=False,
            start_new_session=True,  # signals of the terminal are for the process that asks
        )
    except subprocess.TimeoutExpired:
        raise ConfigError(
            f"world {path} is not read within {_WAITING:g} s: what it names may be no file;"
            f" {_REMEDY}"
        ) from None
    if done.returncode == -signal.SIGXCPU:
        raise ConfigError(
            f"world {path} takes more than {_PROCESSOR} s of processor to read; {_REMEDY}"
        )
    try:
        records, answer = pickle.loads(done.stdout)
    except (EOFError, pickle.UnpicklingError):
        raise ConfigError(
            f"world {path} ends the program that reads it, or takes more than"
            f" {_MEMORY / 1e9:g} GB; {_REMEDY}"
        ) from None
    for record in records:
        logging.getLogger(record.name).handle(record)
    if isinstance(answer, VizbotError):
        raise answer
    assert isinstance(answer, House)
    return answer


def main() -> None:
    """Read the world that standard input asks for; log records and it go to standard output."""
    path, labels, start, level, (processor, memory) = pickle.load(sys.stdin.buffer)
    end_when_left(sys.stdout.fileno())
    resource.setrlimit(resource.RLIMIT_CPU, (processor, processor + 1))
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    records = LogRecords()
    logging.basicConfig(level=level, handlers=[records], force=True)
    answer: House | VizbotError
    try:
        answer = _read(path, labels, start)
    except VizbotError as error:
        answer = error
    except MemoryError:
        answer = ConfigError(f"world {path} takes more than {memory / 1e9:g} GB; {_REMEDY}")
    except Exception as error:  # whatever a library runs into in a file by anybody
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        answer = ConfigError(f"world {path} cannot be read ({reason}); {_REMEDY}")
    pickle.dump((records.take(), answer), sys.stdout.buffer, pickle.HIGHEST_PROTOCOL)
    sys.stdout.buffer.flush()
    os._exit(0)  # to free all that was loaded would take a third of a second


def _read(path: Path, labels: Path | None, start: tuple[float, float, float] | None) -> House:
    if path.suffix in MJCF:
        from sim_stubs.world.mjcf import read_mjcf  # loads MuJoCo

        return read_mjcf(path, labels, start)
    if path.suffix in SDF:
        from sim_stubs.world.sdf import read_sdf

        return read_sdf(path, labels, start)
    from sim_stubs.homes.sweet_home.home import read_home

    return read_home(path)
