"""The table of what was tried, on the page about safety, says what these tests try."""

import pytest

from tests.fuzz import (
    test_clip_folders,
    test_realsense_recordings,
    test_recordings,
    test_sounds,
    test_spoilt_maps,
)
from tests.fuzz.spoilt_maps import spoilt_maps
from tests.fuzz.spoilt_recordings import harmful_databases
from tests.helpers.checkout import ROOT
from tests.test_attacks import test_ended_while_driving as ended
from tests.test_attacks import test_killed_while_saving as saving
from tests.test_attacks import test_no_vizbot as port
from tests.test_attacks import test_odd_settings as odd


def counts(short, long):
    return f"{short:,}", f"{long:,}"


def maps():
    def tried(seed, flips):
        return sum(1 for _ in spoilt_maps(seed, flips))

    tests = test_spoilt_maps
    many = sum(tried(seed, tests.LONG_FLIPS) for seed in tests.LONG_SEEDS)
    return counts(tried(0, tests.FLIPS), many)


def realsense():
    tests = test_realsense_recordings
    many, harmful = len(tests.LONG_SEEDS) * tests.LONG, sum(1 for _ in harmful_databases())
    return f"{len(tests.KINDS)} x {tests.SHORT}", f"{len(tests.KINDS)} x {many} + {harmful}"


SPOILT = len(odd.COMMANDS) * (len(odd.SETTINGS) + len(odd.PATHS))
TRIED = {
    "something else at the robot's port": lambda: (
        f"{len(port.STRANGERS)}",
        f"{len(port.STRANGERS)} x {2 * len(port.COMMANDS)}",
    ),
    "settings: nested, endless": lambda: (f"{SPOILT} + {len(odd.ARGUMENTS)}", ""),
    "launch, calibrate, teleop killed": lambda: counts(
        len(ended.QUICK), len(ended.CASES) - len(ended.QUICK)
    ),
    "a program killed": lambda: (
        f"{len(saving.KINDS)} x {saving.KILLS}, and between any two steps",
        f"{len(saving.KINDS)} x {saving.MANY_KILLS}",
    ),
    "spoilt saved maps": maps,
    "spoilt recordings (TUM folders), read": lambda: counts(
        test_recordings.SHORT, test_recordings.LONG
    ),
    "spoilt recordings (TUM folders), made": lambda: counts(
        test_recordings.BUILT_SHORT, test_recordings.BUILT_LONG
    ),
    "spoilt recordings of a RealSense": realsense,
    "spoilt recordings of speech": lambda: counts(
        test_sounds.SHORT, len(test_sounds.LONG_SEEDS) * test_sounds.LONG
    ),
    "spoilt weights": lambda: counts(test_clip_folders.SHORT, test_clip_folders.LONG),
}


@pytest.mark.parametrize("attack", TRIED)
def test_the_page_says_how_often_was_tried(attack):
    lines = (ROOT / "docs/safety.md").read_text().splitlines()
    [row] = [line for line in lines if line.startswith(f"| {attack}")]
    _, _, quick, long, *_ = (cell.strip() for cell in row.split("|"))
    assert (quick, long) == TRIED[attack]()
