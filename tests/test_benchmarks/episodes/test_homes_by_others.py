"""Episodes in homes drawn by others, which are files instead of seeds."""

import numpy as np
import pytest

from benchmarks.episodes import homes
from benchmarks.episodes.episode import Episode, EpisodeResult, GoalResult, seed_of_home
from benchmarks.harness.store import Store
from benchmarks.objectnav.others_page import others_page
from sim_stubs.homes.home import home
from tests.test_benchmarks.printed_table import rows_in
from vizbot.config import Config


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


def test_the_page_has_a_row_for_each_home_and_each_end(tmp_path):
    assert others_page(tmp_path, tmp_path / "others.md") == ""
    for name, success in (("x.jar/Studio", True), ("x.jar/Loft", False)):
        goal = GoalResult("bed", success, success, "" if success else "too far", "", 1.0, 90, 9.0,
                          4.5, 60.0)  # fmt: skip
        result = EpisodeResult(Episode(name, ("bed",)), (goal,), 0, 0.01, 9.0, (), (0.0, 0.0, 0.0))
        Store(tmp_path / "objectnav-default.jsonl", EpisodeResult).add("k", "c0ffee", "m", result)
    page = others_page(tmp_path, tmp_path / "others.md")
    rows = rows_in(page)
    assert {"Studio", "Loft"} <= {row[0] for row in rows} and ["reached", "1"] in rows
    together = next(row for row in rows if row[:1] == ["all"])
    assert together[1].startswith("1 of 2") and together[2:4] == ["0 of 2", "25.0"]
    assert ["the search ended by an error", "1"] in rows and "c0ffee" in page
