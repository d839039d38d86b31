"""Episodes in homes drawn by others, which are files instead of seeds."""

import numpy as np
import pytest

from benchmarks.episodes import homes
from benchmarks.episodes.episode import Episode, EpisodeResult, GoalResult, seed_of_home
from benchmarks.harness.bench_plan import results_file
from benchmarks.harness.store import Store
from benchmarks.objectnav.others_page import others_page
from sim_stubs.homes.home import home
from tests.test_benchmarks.printed_table import cells, rows_in
from vizbot.config import Config
from vizbot.core.observer import Outcome


@pytest.fixture
def drawn_by_another(monkeypatch):
    monkeypatch.setattr(homes, "read_world", lambda path: home(1100))
    homes.house_of.cache_clear()
    yield "somewhere/homes.jar/Studio"
    homes.house_of.cache_clear()


def test_the_seed_of_a_file_is_that_of_its_name_wherever_it_lies():
    assert seed_of_home(1100) == 1100
    assert seed_of_home("a/b.jar/Studio") == seed_of_home("c.jar/Studio")
    assert seed_of_home("a/Studio") != seed_of_home("a/Loft")


def test_an_episode_begins_far_from_its_goal_and_goals_without_a_start_are_none(
    drawn_by_another, monkeypatch
):
    found = homes.survey(drawn_by_another)
    assert found.home == drawn_by_another and {"bed", "sofa"} <= set(found.goals)
    episode = Episode(drawn_by_another, ("sofa",))
    with homes.open_episode(episode, Config()) as world:
        here = world.T_world_base[:2, 3]
        sofas = [it.centre[:2] for it in world.instances if it.label == "sofa"]
        assert min(np.linalg.norm(np.array(sofas) - here, axis=1)) > 3.0
    monkeypatch.setattr(homes, "start_for", lambda house, goal, rng: None)
    assert homes.survey(drawn_by_another).goals == ()


def driven(home, goal="bed", success=True, claimed=True, outcome=None):
    """An episode of which half of the way was needed."""
    told = GoalResult(goal, success, claimed, "", "", 1.0, 90, 9.0, 4.5, 60.0, outcome, stuck=False)
    return EpisodeResult(Episode(home, (goal,)), (told,), 0, 0.01, 9.0, (), (0.0, 0.0, 0.0))


def keep(folder, row, *results, commit="c0ffee"):
    Store(results_file(folder, "objectnav", row), EpisodeResult).add("k", commit, "m", *results)


def test_the_page_has_a_row_for_each_home_and_each_end(tmp_path):
    assert others_page(tmp_path, tmp_path / "others.md") == ""
    vain = driven("x.jar/Loft", "tv", success=False, claimed=False, outcome=Outcome.NOT_FOUND)
    broken = driven("x.jar/Loft", success=False, claimed=False)
    wrong = driven("x.jar/Loft", "sofa", success=False)
    keep(tmp_path, "default", driven("x.jar/Studio"), wrong, broken, vain)
    page = others_page(tmp_path, tmp_path / "others.md")
    rows = rows_in(page)
    assert ["reached", "1"] in rows and ["the search ended by an error", "1"] in rows
    assert ["not found", "1"] in rows and "- default: commit c0ffee, m" in page
    together = cells(page, "default")
    assert together[0].startswith("1 of 4 (5 to 70 %), over homes 0 to ")
    assert together[1] == "1 of 4 (5 to 70 %)" and together[2].startswith("1 of 2 (")
    assert together[3].startswith("12.5, over homes 0 to ") and together[4] == "0"
    assert cells(page, "Studio")[0] == "1 of 1 (21 to 100 %)"
    assert cells(page, "Loft")[0].startswith("0 of 3 (") and cells(page, "Loft")[3] == "0.0"
    assert "paper |" not in page and "paired" not in page and "Patches of homes" not in page


def test_rows_that_were_driven_stand_beside_the_default_wherever_the_files_lay(tmp_path):
    keep(tmp_path, "default", driven("x.jar/Studio", success=False), driven("x.jar/Loft"))
    keep(tmp_path, "true encoder", driven("y.jar/Studio"), driven("y.jar/Loft"), commit="0ld")
    keep(tmp_path, "paper", driven("z.jar/Loft", success=False, claimed=False))
    page = others_page(tmp_path, tmp_path / "others.md")
    assert cells(page, "true encoder")[0].startswith("2 of 2")
    assert cells(page, "default and true encoder")[:2] == ["0", "1"]
    assert cells(page, "default and paper")[:2] == ["1", "0"]
    assert cells(page, "default, the same goals")[0].startswith("1 of 1")
    assert cells(page, "paper")[2] == "-"  # it claimed nothing
    assert "- true encoder: commit 0ld" in page
    assert not [row for row in rows_in(page) if row[0].startswith("perfect")]
