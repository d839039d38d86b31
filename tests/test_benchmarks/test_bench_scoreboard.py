from dataclasses import replace

import numpy as np
import pytest

from benchmarks.episodes.episode import (
    Episode,
    EpisodeResult,
    GoalResult,
    HomeGoals,
    QueryResult,
)
from benchmarks.harness.bench_plan import results_file
from benchmarks.harness.fingerprint import Fingerprint
from benchmarks.harness.store import Store
from benchmarks.objectnav import picture_section, scoreboard, single_goal
from benchmarks.objectnav.episode_pictures import Picture
from benchmarks.objectnav.home_tables import models_section
from vizbot.config import Config

GOALS = ("bed", "chair", "sofa", "kitchen", "living room", "window", "tv", "sink")


def finished(home, goal, success):
    answer = GoalResult(
        goal, success, True, "" if success else "far", "seen", 1.0, 9, 2.0, 1.0, 1.8
    )
    track = ((0.0, 0.0),)
    return EpisodeResult(Episode(home, (goal,)), (answer,), 0, 0.01, 3.0, track, (0.0, 0.0, 0.0))


HOMES = (HomeGoals(1000, GOALS), HomeGoals(1001, GOALS[:-1]))
RESULTS = [finished(each.home, goal, each.home == 1000) for each in HOMES for goal in each.goals]
MADE = Fingerprint("embedded", "homes", "episodes", "oracles", "c0ffee", "2 cores of X")
DEFAULT, ONE, ZERO, MINUS_ONE, *_ = single_goal.variants(Config())
[TRUE_POSE] = [each for each in single_goal.variants(Config()) if each.oracle == "pose"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """With the default row; the homes have been surveyed and pictures need no simulator."""

    def inline(work, jobs, title, describe):
        return [(job, Picture(b"picture", ("Sofa by A. N. Author, CC-BY",))) for job in jobs]

    monkeypatch.setattr(picture_section, "in_parallel", inline)
    monkeypatch.setattr(scoreboard, "BOARD", (1000, 1001))
    kept = {each.home: each for each in HOMES}
    monkeypatch.setattr(scoreboard, "survey", lambda home: kept.get(home, HomeGoals(home, GOALS)))
    folder = tmp_path / "rows" / "scoreboard"
    survey(folder, *HOMES)
    keep(folder, DEFAULT, RESULTS[::-1])
    return folder


def survey(folder, *homes):
    Store(folder / "homes.jsonl", HomeGoals).add("homes", "c0ffee", "2 cores of X", *homes)


def keep(folder, variant, results, made=MADE):
    store = Store(results_file(folder, "objectnav", variant.name), EpisodeResult)
    store.add(made.key_of(variant), made.commit, made.hardware, *results)


def written(folder):
    page = folder.parents[1] / "scoreboard.md"
    scoreboard.write_scoreboard_page(folder, page, Config())
    return page


@pytest.fixture
def page(folder):
    return written(folder)


def test_the_first_line_says_that_the_figures_are_no_direct_comparison(page):
    first = page.read_text().splitlines()[0]
    for word in ("Homes", "encoder", "split", "ours", "no direct comparison"):
        assert word in first


def test_the_page_names_commit_machine_and_the_furniture_of_both_sides(page):
    text = page.read_text()
    assert "Run on 2 cores of X" in text
    assert "- c0ffee: objectnav, default" in text
    assert "All rows share one commit." in text and "no claim" not in text
    assert "held out for these homes" in text
    assert "| bathtub " in text
    assert "87.0" in text and "paper, not run here" in text


def test_failures_are_shown_as_well_as_successes_and_every_picture_is_there(page):
    shown = [line for line in page.read_text().splitlines() if line.startswith("![")]
    assert sum(line.startswith("![failure") for line in shown) == 6
    assert sum(line.startswith("![success") for line in shown) == 6
    for line in shown:
        name = line.split("(")[1].rstrip(")")
        assert " " not in name and name.startswith("pictures/scoreboard/")
        assert (page.parent / name).read_bytes() == b"picture"


def test_the_same_episodes_are_pictured_every_time():
    chosen = picture_section.pictured(RESULTS)
    assert chosen == picture_section.pictured(RESULTS)
    assert np.mean([result.success for result in chosen]) == 0.5
    assert picture_section.pictured([]) == []
    assert picture_section.pictured([replace(RESULTS[0], track=())]) == []


def cells(text, first):
    """Of the row of a table that begins with this cell."""
    rows = [[cell.strip() for cell in line.split("|")] for line in text.splitlines()]
    return next(row[2:-1] for row in rows if row[1:2] == [first])


def test_targets_and_further_aims_stand_beside_what_was_reached(folder):
    for variant, fails in ((ONE, ("bed",)), (ZERO, ("tv", "sink")), (MINUS_ONE, GOALS)):
        keep(folder, variant, [finished(1000, goal, goal not in fails) for goal in GOALS])
    text = written(folder).read_text()
    assert cells(text, "success of navigation") == ["87.0", "95.0", "53.3", "15", "-", "no"]
    assert cells(text, "four goals in a row") == ["44.0", "70.0", "-", "-", "-", "not run"]
    asked = cells(
        text, "three scales better than every single one, precision@1, the robot's answer"
    )
    assert asked[-2:] == ["-", "not run"]


@pytest.mark.parametrize(
    ("fails", "pairs", "reached"),
    [
        (GOALS[:5], "5 to 0, p = 0.062", "not shown"),
        (GOALS[:6], "6 to 0, p = 0.031", "yes"),
        ((), "0 to 0, p = 1", "not shown"),
    ],
)
def test_three_scales_are_better_only_where_a_paired_test_says_so(folder, fails, pairs, reached):
    for variant, failed in ((ONE, fails), (ZERO, GOALS[:6]), (MINUS_ONE, GOALS)):
        keep(folder, variant, [finished(1000, goal, goal not in failed) for goal in GOALS])
    row = cells(written(folder).read_text(), "three scales better than every single one, success")
    assert row == [f"over {100 - 12.5 * len(fails):.1f}", "-", "100.0", "8", pairs, reached]


def keep_answers(folder, most_similar_of_one):
    """All scale sets are right by the robot's rule; by the most similar element all three together.

    Args:
        folder: The folder of the rows.
        most_similar_of_one: Whether scale 1 alone is right by the most similar element too.
    """
    store = Store(results_file(folder, "retrieval", "queries"), QueryResult)
    for scales in ((1, 0, -1), (1,), (0,), (-1,)):
        right = most_similar_of_one if scales == (1,) else scales == (1, 0, -1)
        answers = [
            QueryResult(1000, scales, goal, True, 0.5, 0.4, (1.0, 2.0), True, right)
            for goal in GOALS
        ]
        store.add("key", "c0ffee", "2 cores of X", *answers)


def test_the_page_says_that_the_central_result_is_not_shown_and_why(folder):
    for variant in (ONE, ZERO, MINUS_ONE):
        keep(folder, variant, [finished(1000, goal, False) for goal in GOALS])
    keep_answers(folder, most_similar_of_one=False)
    text = written(folder).read_text()
    better = "three scales better than every single one, "
    assert cells(text, f"{better}success")[-1] == "yes"
    assert cells(text, f"{better}precision@1, the robot's answer")[-1] == "not shown"
    assert cells(text, f"{better}precision@1, the paper's own rule")[-1] == "yes"
    assert "is not shown here yet: 2 of 3 comparisons show it." in text
    assert "names patches the worse the finer their scale" in text and "embedded_clip.md)" in text


def test_intervals_over_homes_are_printed_and_called_rough(page):
    text = page.read_text()
    # 8 of 8 in one home and 0 of 7 in the other.
    assert cells(text, "vizbot, default")[:4] == ["15", "53.3", "30 to 75", "0 to 100"]
    assert "with 2 homes they are rough" in text


def test_the_page_says_where_it_was_driven_and_what_the_board_before_it_was(folder, monkeypatch):
    board = range(1020, 1028)
    monkeypatch.setattr(scoreboard, "BOARD", tuple(board))
    survey(folder, *(HomeGoals(home, GOALS[:2]) for home in board))
    keep(folder, DEFAULT, [finished(home, goal, True) for home in board for goal in GOALS[:2]])
    text = written(folder).read_text()
    assert "driven whole in homes 1020 to 1027: every goal that exists there" in text
    assert "up to 999 and from 1100 to 1199" in text and "homes 1100 to 1107" in text
    assert (
        "homes 1000 to 1003, which were driven whole at least 10 times while their failures were"
        " read in between: of 61 goals 37, 46, 52, 55, 56, 54, 56, 54, 57, 59 were reached"
    ) in text
    assert "with 8 homes they are rough" in text


def test_no_page_is_written_before_the_default_row_is_whole(folder, monkeypatch):
    survey(folder, HomeGoals(1002, ("bed", "sofa")))
    monkeypatch.setattr(scoreboard, "BOARD", (1000, 1001, 1002))
    keep(folder, DEFAULT, [finished(1002, "bed", True)])
    assert not written(folder).exists()
    keep(folder, DEFAULT, [finished(1002, "sofa", True)])
    assert written(folder).exists()


def test_the_page_says_what_calibration_and_latency_cost_on_the_quick_share(folder):
    assert "latency cost" not in written(folder).read_text()
    quick = folder.with_name("quick_share")
    exact = single_goal.variants(Config())[-1]
    keep(quick, exact, [finished(1100, goal, True) for goal in GOALS])
    assert "latency cost" not in written(folder).read_text()
    keep(quick, DEFAULT, [finished(1100, goal, goal != "tv") for goal in GOALS[1:]])
    text = written(folder).read_text()
    section = text.partition("## What calibration and latency cost")[2].partition("\n## ")[0]
    assert "1 are reached only without the errors, 0 only with them" in section
    assert cells(section, "exact calibration")[:2] == ["7", "100.0"]
    assert "quick share, default; quick share, exact calibration" in text
    # On the board itself the row is not.
    assert "exact calibration" not in text.partition("## Object-goal")[2].partition("\n## ")[0]
    assert cells(text, "vizbot, default")[0] == "15"


def test_distinct_models_of_each_goal_are_counted_over_all_homes(page):
    assert "distinct models" not in page.read_text()
    homes = [
        HomeGoals(1000, ("bed", "tv", "kitchen"), (("bed", "A"), ("bed", "B"), ("tv", "C"))),
        HomeGoals(1001, ("bed", "tv"), (("bed", "B"), ("bed", "D"), ("tv", "C"))),
    ]
    text = models_section(homes)
    assert cells(text, "bed") == ["2", "3", "0", "3"]
    assert cells(text, "tv") == ["2", "1", "0", "1"]
    assert "| kitchen" not in text
    assert "Of these goals a single model was seen: tv." in text


def test_shapes_of_boards_count_as_unseen_and_those_of_homes_for_development_as_seen():
    shapes = [f"own shape: bed {i}" for i in range(4)]
    homes = [
        HomeGoals(1019, ("bed",), (("bed", shapes[0]),)),
        HomeGoals(1150, ("bed",), (("bed", shapes[1]),)),
        HomeGoals(1200, ("bed",), (("bed", shapes[2]), ("bed", shapes[3]), ("bed", "A"))),
    ]
    text = models_section(homes)
    assert cells(text, "bed") == ["3", "5", "4", "3"]


def test_only_the_scoreboard_s_own_episodes_are_on_the_page(folder, page):
    before = page.read_text()
    keep(folder, DEFAULT, [finished(3, "sofa", False), finished(1700, "sofa", False)])
    # More than the scoreboard's own, under a key of their own.
    keep(
        folder, DEFAULT, [finished(7, goal, True) for goal in GOALS * 3], replace(MADE, episodes="")
    )
    assert written(folder).read_text() == before
    lines = before.splitlines()
    failed = [line.split("|")[1].strip() for line in lines if line.startswith("| home 1001, ")]
    assert failed == [f"home 1001, {goal}" for goal in GOALS[:-1]]


def test_an_oracle_of_another_robot_is_left_out_in_one_line(folder):
    keep(folder, TRUE_POSE, [finished(1001, "sofa", True)])
    text = written(folder).read_text()
    assert cells(text, "true pose")[:2] == ["1", "100.0"]
    assert "Left out" not in text
    changed = replace(MADE, episodes="others")
    keep(folder, DEFAULT, [*RESULTS, finished(1001, "sink", True)], changed)
    # The default row of other sources is as full and newer: it is the one that is shown.
    text = written(folder).read_text()
    assert "| true pose" not in text
    assert "Left out, as the default row was run with other sources: true pose." in text


def test_uncommitted_sources_and_rows_of_several_commits_are_marked(folder):
    keep(folder, ONE, RESULTS, replace(MADE, commit="abc+"))
    text = written(folder).read_text()
    assert "- abc+: objectnav, scale 1" in text
    assert "Not all rows share one commit. Where a + stands the sources differed" in text


def changed_homes(monkeypatch):
    monkeypatch.setattr(scoreboard, "survey", lambda home: HomeGoals(home, GOALS[1:]))


def test_a_row_is_not_drawn_in_homes_that_have_changed(folder, monkeypatch):
    changed_homes(monkeypatch)
    text = written(folder).read_text()
    assert "## Object-goal navigation" in text
    assert "![" not in text and not (folder.parents[1] / "pictures").exists()


def test_pictures_of_the_same_episodes_stay_when_the_homes_have_changed(folder, page, monkeypatch):
    before = page.read_text()
    assert before.count("![") == 12
    changed_homes(monkeypatch)
    assert written(folder).read_text() == before
    # Of another row the page shows no picture.
    others = [finished(1000, goal, False) for goal in GOALS] + RESULTS[8:]
    keep(folder, DEFAULT, others, replace(MADE, episodes="others"))
    assert "![" not in written(folder).read_text()


def test_what_a_home_lacks_and_whose_furniture_is_shown_are_told(page):
    text = page.read_text()
    assert cells(text, "home 1001")[0] == "7"
    assert cells(text, "home 1001")[1].startswith("toilet, dining table, sink, refrigerator")
    assert "The furniture in these pictures: Sofa by A. N. Author, CC-BY." in text
    assert "Stairs that lead down have no model in the catalogue" in text
