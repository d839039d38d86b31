"""Spoilt maps are refused in one line or are valid maps; none ends or stops the program."""

import json
import subprocess
import sys
from collections import Counter

import pytest

from tests.fuzz.map_trial import SECONDS

_MOST_MIB = 2000


def tried(folder, seed, flips, timeout):
    """What became of every spoilt map of a seed, in a process apart."""
    command = [sys.executable, "-m", "tests.fuzz.map_trial", folder, str(seed), str(flips)]
    trial = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    lines = [json.loads(line) for line in trial.stdout.splitlines()]
    assert trial.returncode == 0, f"{lines[-1:]} ended the program: {trial.stderr[-2000:]}"
    return [line for line in lines if "became" in line]


def require_harmless(rows):
    for row in rows:
        became = row["became"]
        assert became == "loaded" or became.startswith("refused: "), row
        assert became != "loaded" or row["allowed"] != "refused", row
        assert "\n" not in became and len(became) < 1000, row
        assert row["seconds"] < SECONDS and row["peak_mib"] < _MOST_MIB, row


def test_spoilt_maps_are_refused_in_one_line_or_are_valid(tmp_path):
    rows = tried(tmp_path, seed=0, flips=20, timeout=200)
    require_harmless(rows)
    became = Counter(row["became"].split(":")[0] for row in rows)
    assert became["refused"] > 450 and became["loaded"] > 10  # both happen, so both are tried


@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, 5))
def test_many_more_spoilt_maps_likewise(tmp_path, seed):
    require_harmless(tried(tmp_path, seed, flips=1000, timeout=1800))
