import pytest

from sim_stubs.homes.goal_chair import GOAL
from tests.helpers.checkout import ROOT
from tests.tools import demo_home


def test_the_demo_drives_to_the_goal_and_in_the_home_that_its_rule_gives():
    makefile = (ROOT / "Makefile").read_text()
    recipe = makefile.partition("\ndemo: install\n")[2].partition("\n\n")[0]
    command = f'$(BIN)/vizbot dry-run "{GOAL}" --world {demo_home.demo_home()}'
    assert recipe.splitlines()[-1] == f"\t{command}"


@pytest.mark.parametrize(("ways", "home"), [((5.1, 9.0), 1100), ((0.0, 5.0, 4.0, 5.01), 1103)])
def test_a_home_whose_goal_is_near_or_cannot_be_reached_is_passed_over(ways, home, monkeypatch):
    monkeypatch.setattr(demo_home, "_way", lambda seed: ways[seed - 1100])
    assert demo_home.demo_home() == home
