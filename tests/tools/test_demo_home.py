from pathlib import Path

import pytest

from sim_stubs.homes.goal_chair import GOAL
from tests.tools import demo_home

MAKEFILE = Path(__file__).parents[2] / "Makefile"


def test_the_demo_drives_to_the_goal_and_in_the_home_that_its_rule_gives():
    recipe = MAKEFILE.read_text().partition("\ndemo: install\n")[2].partition("\n\n")[0]
    assert (
        recipe.splitlines()[-1]
        == f'\t$(BIN)/vizbot dry-run "{GOAL}" --world {demo_home.demo_home()}'
    )


@pytest.mark.parametrize(("ways", "home"), [((5.1, 9.0), 1100), ((0.0, 5.0, 4.0, 5.01), 1103)])
def test_a_home_whose_goal_is_near_or_cannot_be_reached_is_passed_over(ways, home, monkeypatch):
    monkeypatch.setattr(demo_home, "_way", lambda seed: ways[seed - 1100])
    assert demo_home.demo_home() == home
