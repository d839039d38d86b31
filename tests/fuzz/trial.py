"""Trials of spoilt files, in a process apart, since one may end it or fill its memory.

It prints one JSON line a file, before and after, so that the last one names what ended the process.
"""

import contextlib
import io
import json
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from tests.helpers.memory import peak_kib

SECONDS = 10
"""What reading and use of a small file may take at most."""
_MOST_MIB = 2000


class Allowed(StrEnum):
    """What may become of a spoilt file."""

    REFUSED = "refused"
    SAME = "refused, or loaded as what was spoilt"
    ANY = "refused, or loaded as something valid"


@dataclass(frozen=True)
class Spoilt:
    name: str
    allowed: Allowed
    spoil: Callable[[Path], object]


def try_one(spoilt, become):
    """Report what becomes of a spoilt file: "refused: LINE", "loaded", or what is wrong."""

    def too_slow(*_):
        raise TimeoutError(f"longer than {SECONDS} s")

    _report({"begins": spoilt.name})
    signal.signal(signal.SIGALRM, too_slow)
    began = time.monotonic()
    signal.alarm(SECONDS)
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        became = become()
    signal.alarm(0)
    children = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    _report(
        {
            "name": spoilt.name,
            "allowed": spoilt.allowed.value,
            "became": became,
            "seconds": time.monotonic() - began,
            "peak_mib": max(peak_kib(), children) // 1024,
        }
    )


def _report(record):
    sys.stdout.write(json.dumps(record) + "\n")
    sys.stdout.flush()


def tried(module, *arguments, timeout):
    """What became of every file that a module of trials spoils."""
    command = [sys.executable, "-m", module, *map(str, arguments)]
    trial = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    lines = [json.loads(line) for line in trial.stdout.splitlines()]
    assert trial.returncode == 0, f"{lines[-1:]} ended the program: {trial.stderr[-2000:]}"
    assert trial.stderr == ""
    return [line for line in lines if "became" in line]


def require_harmless(rows):
    for row in rows:
        became = row["became"]
        assert became == "loaded" or became.startswith("refused: "), row
        assert became != "loaded" or row["allowed"] != "refused", row
        assert "\n" not in became and len(became) < 1000, row
        assert row["seconds"] < SECONDS and row["peak_mib"] < _MOST_MIB, row
