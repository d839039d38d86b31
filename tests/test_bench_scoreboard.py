import numpy as np
import pytest

from vizbot.bench import scoreboard
from vizbot.bench.board import results_file
from vizbot.bench.episodes import Episode, EpisodeResult, GoalResult
from vizbot.bench.store import Store
from vizbot.config import Config

GOALS = ("bed", "chair", "sofa", "kitchen", "living room", "window", "tv", "sink")


def finished(home, goal, success):
    answer = GoalResult(
        goal, success, True, "" if success else "far", "seen", 1.0, 9, 2.0, 1.0, 1.8
    )
    return EpisodeResult(Episode(home, (goal,)), (answer,), 0, 0.01, 3.0, (), (0.0, 0.0, 0.0))


RESULTS = [finished(home, goal, home == 1000) for home in (1000, 1001) for goal in GOALS]


@pytest.fixture
def page(tmp_path, monkeypatch):
    def inline(work, jobs, title, describe):
        return [(job, b"picture") for job in jobs]

    monkeypatch.setattr(scoreboard, "in_parallel", inline)
    folder = tmp_path / "docs" / "scoreboard"
    store = Store(results_file(folder, "objectnav", "default"), EpisodeResult)
    store.add("k", "c0ffee", "2 cores of X", *RESULTS)
    return scoreboard.write_page(folder, Config())


def test_the_first_line_says_that_the_figures_are_no_direct_comparison(page):
    first = page.read_text().splitlines()[0]
    for word in ("Homes", "encoder", "split", "ours", "no direct comparison"):
        assert word in first


def test_the_page_names_commit_machine_and_the_furniture_of_both_sides(page):
    text = page.read_text()
    assert page.name == "scoreboard.md"
    assert "Run on 2 cores of X" in text
    assert "- c0ffee: objectnav, default" in text
    assert "| success of navigation        |     87.0 | 50.0 |      no |" in text
    assert "held out for these homes" in text
    assert "| bathtub " in text
    assert "87.0" in text and "paper, not run here" in text


def test_failures_are_shown_as_well_as_successes_and_every_picture_is_there(page):
    shown = [line for line in page.read_text().splitlines() if line.startswith("![")]
    assert sum(line.startswith("![failure") for line in shown) == 6
    assert sum(line.startswith("![success") for line in shown) == 6
    for line in shown:
        name = line.split("(")[1].rstrip(")")
        assert " " not in name
        assert (page.parent / name).read_bytes() == b"picture"


def test_the_same_episodes_are_pictured_every_time():
    chosen = scoreboard.pictured(RESULTS)
    assert chosen == scoreboard.pictured(RESULTS)
    assert np.mean([result.success for result in chosen]) == 0.5
    assert scoreboard.pictured([]) == []
