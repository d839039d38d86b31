"""The table of what was tried, on the page about safety, says what these tests try."""

import pytest

from tests.helpers.checkout import ROOT
from tests.test_attacks import test_ended_while_driving as ended
from tests.test_attacks import test_killed_while_saving as saving
from tests.test_attacks import test_no_vizbot as port
from tests.test_attacks import test_odd_settings as odd

SPOILT = len(odd.COMMANDS) * (len(odd.SETTINGS) + len(odd.PATHS))
TRIED = {
    "something else at the robot's port": (f"{len(port.STRANGERS)} x {2 * len(port.COMMANDS)}", ""),
    "settings: nested, endless": (f"{SPOILT} + {len(odd.ARGUMENTS)}", ""),
    "launch, calibrate, teleop killed": (
        f"{len(ended.QUICK)}",
        f"{len(ended.CASES) - len(ended.QUICK)}",
    ),
    "a program killed": (
        f"{len(saving.KINDS)} x {saving.KILLS}, and between any two steps",
        f"{len(saving.KINDS)} x {saving.MANY_KILLS}",
    ),
}


@pytest.mark.parametrize("attack", TRIED)
def test_the_page_says_how_often_was_tried(attack):
    lines = (ROOT / "docs/safety.md").read_text().splitlines()
    [row] = [line for line in lines if line.startswith(f"| {attack}")]
    _, _, quick, long, *_ = (cell.strip() for cell in row.split("|"))
    assert (quick, long) == TRIED[attack]
