"""Trials of spoilt files, in a process apart, since one may end it or fill its memory.

It prints one JSON line a file, before and after, so that the last one names what ended the process.
"""

import contextlib
import io
import json
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from tests.helpers.memory import peak_kib
from vizbot.core.errors import VizbotError

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


def became(use, refusal):
    """What becomes of a file by its use: "refused: LINE", "loaded", or what is wrong."""
    try:
        use()
    except refusal as error:
        return f"refused: {error}"
    except Exception as error:
        return f"wrong: {type(error).__name__}: {error}"
    return "loaded"


def try_one(spoilt, use, refusal=VizbotError):
    """Report what becomes of a spoilt file by its use, which may be refused by such an error."""

    def too_slow(*_):
        raise TimeoutError(f"longer than {SECONDS} s")

    _report({"begins": spoilt.name})
    signal.signal(signal.SIGALRM, too_slow)
    began = time.monotonic()
    signal.alarm(SECONDS)
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        outcome = became(use, refusal)
    signal.alarm(0)
    children = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    _report(
        {
            "name": spoilt.name,
            "allowed": spoilt.allowed.value,
            "became": outcome,
            "seconds": time.monotonic() - began,
            "peak_mib": max(peak_kib(), children) // 1024,
        }
    )


def _report(record):
    sys.stdout.write(json.dumps(record) + "\n")
    sys.stdout.flush()


def outcomes_in_turn(good, work, spoil, outcome, rngs):
    """What becomes of copies of a folder, each spoilt by a draw: a line of text is a refusal."""
    became = []
    for number, rng in enumerate(rngs):
        folder = work / str(number)
        shutil.copytree(good, folder)
        spoil(folder, rng)
        began = time.monotonic()
        became.append(outcome(folder))
        assert time.monotonic() - began < SECONDS, number
        assert "\n" not in str(became[-1]), (number, became[-1])
        shutil.rmtree(folder)
    lines = [each for each in became if isinstance(each, str)]
    assert 0 < len(lines) < len(became)  # both happen, so both are tried
    return became


def count_harmless(module, *arguments, timeout):
    """How many of the files that a module of trials spoils were loaded and refused, in one line."""
    command = [sys.executable, "-m", module, *map(str, arguments)]
    trial = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    lines = [json.loads(line) for line in trial.stdout.splitlines()]
    assert trial.returncode == 0, f"{lines[-1:]} ended the program: {trial.stderr[-2000:]}"
    assert trial.stderr == ""
    rows = [line for line in lines if "became" in line]
    for row in rows:
        outcome = row["became"]
        assert outcome == "loaded" or outcome.startswith("refused: "), row
        assert outcome != "loaded" or row["allowed"] != "refused", row
        assert "\n" not in outcome and len(outcome) < 1000, row
        assert row["seconds"] < SECONDS and row["peak_mib"] < _MOST_MIB, row
    counts = Counter(row["became"].split(":")[0] for row in rows)
    assert counts["refused"] and counts["loaded"]  # both happen, so both are tried
    return counts
