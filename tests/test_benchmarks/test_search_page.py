"""The page of the search: rows of two searches, on the same goals and on a part of them."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import pytest
import typer

from benchmarks.episodes.absent_things import ThingAnswer
from benchmarks.episodes.episode import (
    BelievedAnswer,
    Episode,
    EpisodeResult,
    GoalResult,
    HomeGoals,
    QueryResult,
)
from benchmarks.episodes.exploration import SCALE_SETS
from benchmarks.harness.bench_plan import results_file
from benchmarks.harness.store import Store
from benchmarks.objectnav import overshoot
from benchmarks.objectnav.home_tables import models_section
from benchmarks.objectnav.retrieval import retrieval_stores
from benchmarks.objectnav.search_page import (
    search_page,
    spl_difference,
    three_and_coarsest,
    wrong_arrivals,
)
from tests.test_benchmarks.printed_table import cells, rows_in
from vizbot.core.observer import Outcome

GOALS = ("bed", "chair", "sofa", "kitchen", "window")
HOMES = (1040, 1041)
EPISODES = [Episode(home, (goal,)) for home in HOMES for goal in GOALS]


def driven(episode, success=True, claimed=True, way=10.0):
    goal = GoalResult(
        episode.goals[0], success, claimed, "" if success else "3.00 m away", "sure", 0.5, 100, way,
        5.0, 20.0,
    )  # fmt: skip
    return EpisodeResult(episode, (goal,), 0, 0.01, 5.0, ((0.0, 0.0),), (0.0, 0.0, 0.0))


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "search"
    folder.mkdir()
    Store(folder / "homes.jsonl", HomeGoals).add(
        "homes", "c0ffee", "2 cores", *(HomeGoals(home, GOALS) for home in HOMES)
    )
    return folder


def keep(folder, row, commit, results, bench="objectnav", hardware="2 cores"):
    folder.mkdir(exist_ok=True)
    Store(results_file(folder, bench, row), EpisodeResult).add(row, commit, hardware, *results)


def test_without_the_default_row_there_is_no_page(folder):
    keep(folder, "former", "0ld", map(driven, EPISODES))
    assert search_page(folder, folder / "search.md") == ""


def test_two_searches_are_paired_and_wrong_arrivals_are_counted_apart_from_giving_up(folder):
    gave_up, wrong, *others = EPISODES
    old = [driven(each, way=50.0) for each in others]
    old += [driven(gave_up, False, claimed=False), driven(wrong, False)]
    keep(folder, "former", "0ld", old)
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    text = search_page(folder, folder / "search.md")
    assert text.startswith("# Search\n")
    assert "- former: commit 0ld, 2 cores\n- default: commit c0ffee, 2 cores" in text
    assert cells(text, "former")[:2] == ["10", "80.0"] and cells(text, "former")[4] == "1 of 10"
    assert cells(text, "former")[5] == "8.0"
    assert cells(text, "default")[:2] == ["10", "100.0"] and cells(text, "default")[5] == "50.0"
    # Home 1040 has both failures: 0.5 - 3 x 0.1 / 5 there, 0.5 - 0.1 in the other one.
    assert cells(text, "default and former") == ["2", "0", "0.5", "+42.0", "40 to 44"]


def test_arrivals_stand_beside_the_probability_that_the_robot_gave(folder):
    sure = [("92% sure, from near by", True), ("70% sure, from near by", False)]
    sure += [("78% sure, from near by", True), ("80% of it was seen", False)]
    results = []
    for episode, (answer, right) in zip(EPISODES, sure, strict=False):
        result = driven(episode, right, claimed="sure" in answer)
        results.append(replace(result, goals=(replace(result.goals[0], answer=answer),)))
    keep(folder, "default", "c0ffee", results)
    text = search_page(folder, folder / "search.md").split("## How sure the robot is")[1]
    assert cells(text, "0.7 to 0.8") == ["2", "1", "0.5"]
    assert cells(text, "0.9 to 1.0") == ["1", "0", "0.1"]
    assert "0.8 to 0.9" not in text


def test_what_the_robot_said_that_it_had_seen_stands_beside_the_truth(folder):
    shares = [(0.9, 0.95), (0.93, 0.79), (None, 0.8), (0.5, 0.2)]
    outcomes = [Outcome.NOT_FOUND] * 3 + [Outcome.ARRIVED]
    results = []
    for episode, (said, truly), outcome in zip(EPISODES, shares, outcomes, strict=False):
        result = driven(episode, claimed=outcome is Outcome.ARRIVED)
        goal = replace(result.goals[0], outcome=outcome, said_seen=said, truly_seen=truly)
        results.append(replace(result, goals=(goal,)))
    keep(folder, "default", "c0ffee", results)
    text = search_page(folder, folder / "search.md").split("## How much of the home")[1]
    assert cells(text, "not found") == ["2", "+4.5", "1", "+14.0"]
    assert cells(text, "arrived") == ["1", "+30.0", "0", "+30.0"]
    assert "gave up" not in text and "is not there" not in text
    keep(folder, "by searching", "c0ffee", (results[0], results[3]), bench="absent")
    text = search_page(folder, folder / "search.md").split("## How much of the home")[1]
    assert cells(text, "not found, and is not there") == ["1", "-5.0", "1", "-5.0"]
    assert cells(text, "not found") == ["2", "+4.5", "1", "+14.0"]


def test_where_the_truth_about_what_was_seen_was_not_kept_the_page_says_nothing_of_it(folder):
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    assert "How much of the home" not in search_page(folder, folder / "search.md")


def test_a_row_of_two_computers_says_how_much_each_drove(folder):
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    keep(folder, "former", "0ld", map(driven, EPISODES[:3]), hardware="16 cores")
    keep(folder, "former", "0ld", map(driven, EPISODES[3:]))
    text = search_page(folder, folder / "search.md")
    assert "- former: commit 0ld, 2 cores (7 episodes) and 16 cores (3 episodes)" in text


def test_a_row_of_a_part_stands_beside_the_default_on_that_part(folder):
    keep(folder, "default", "c0ffee", [driven(each, each.home == 1040) for each in EPISODES])
    keep(folder, "scaled", "c0ffee", map(driven, EPISODES[4:6]))
    text = search_page(folder, folder / "search.md")
    assert cells(text, "scaled")[:2] == ["2", "100.0"]
    assert "- `scaled`: cosines lie" in text and "`offset`" not in text
    assert cells(text, "default, the same goals")[:2] == ["2", "50.0"]


def test_failures_that_succeed_with_the_truth_about_one_part_are_counted(folder):
    driven_by_default = [driven(each, each.goals != ("sofa",)) for each in EPISODES]
    keep(folder, "default", "c0ffee", driven_by_default)
    assert "the truth about one part" not in search_page(folder, folder / "search.md").lower()
    failed, succeeded = [each for each in EPISODES if each.goals == ("sofa",)], EPISODES[:2]
    true, again = folder.with_name("search_true"), failed + succeeded
    keep(true, "true pose", "c0de", [driven(each, each not in failed[1:]) for each in again])
    keep(true, "true map", "c0de", [driven(each, each in succeeded[1:]) for each in again])
    text = search_page(folder, folder / "search.md").split("## With the truth about one part")[1]
    assert "drawn by lot, at commit c0de." in text
    assert cells(text, "true pose")[-2:] == ["1 of 2", "2 of 2"]
    assert cells(text, "true map")[-2:] == ["0 of 2", "1 of 2"]
    assert (
        "Of 2 failed episodes" in text
        and "repeated, 1 succeed with the truth about one part or another. 1 fail" in text
    )


def test_failures_and_goals_in_a_row_are_told(folder):
    keep(folder, "default", "c0ffee", [driven(each, each.goals != ("sofa",)) for each in EPISODES])
    four = EpisodeResult(
        Episode(1040, GOALS, 1, choose=4), tuple(driven(each).goals[0] for each in EPISODES[:4]),
        0, 0.01, 5.0, (), (0.0, 0.0, 0.0),
    )  # fmt: skip
    keep(folder, "default", "c0ffee", [four], bench="multi")
    text = search_page(folder, folder / "search.md")
    assert cells(text, "home 1041, sofa")[:2] == ["3.00 m away", "sure"]
    in_a_row = text.split("## Four goals in a row")[1]
    assert cells(in_a_row, "default")[:5] == ["1", "1", "1", "1", "1"]
    assert "Only default reached" not in in_a_row
    fewer = replace(four, goals=(*four.goals[:3], driven(EPISODES[3], success=False).goals[0]))
    keep(folder, "former", "c0ffee", [fewer], bench="multi")
    in_a_row = search_page(folder, folder / "search.md").split("## Four goals in a row")[1]
    assert cells(in_a_row, "former")[:5] == ["1", "1", "1", "1", "0"]
    assert "Only default reached all four in 1 episodes, only former in 0 (" in in_a_row


def test_what_is_not_there_is_told_by_maps_and_by_searches(folder):
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    assert "## What is not there" not in search_page(folder, folder / "search.md")
    answers = [ThingAnswer(1040, text, "nowhere", text == "zebra", 0.7, False) for text in GOALS]
    answers.append(ThingAnswer(1040, "zebra", "nowhere", True, 0.7, False))
    Store(results_file(folder, "absent", "offset"), ThingAnswer).add("a", "1", "2", *answers)
    ended = replace(driven(EPISODES[0], False).goals[0], outcome=Outcome.NOT_FOUND)
    searched = [replace(driven(EPISODES[0], False), goals=(ended,)), driven(EPISODES[1], False)]
    keep(folder, "by searching", "c0ffee", searched, bench="absent")
    absent = search_page(folder, folder / "search.md").split("## What is not there")[1]
    assert cells(absent, "by searching")[:3] == ["absent", "2", "50.0"]
    assert ["nowhere", "6", "83.3"] in [row[1:4] for row in rows_in(absent)]


class Floor:
    """A world that only knows where the robot was put."""

    def place(self, x, y, yaw):
        self.x = x


def judged_by_place(monkeypatch):
    """A stop is a success from x = 2 m on; the homes that are opened."""
    opened = []

    def opening(home, config):
        opened.append(home)
        return nullcontext(Floor())

    monkeypatch.setattr(overshoot, "open_benchmark_home", opening)
    monkeypatch.setattr(
        overshoot, "judge", lambda world, text, stopped: SimpleNamespace(success=world.x >= 2.0)
    )
    monkeypatch.setattr(
        overshoot, "in_parallel", lambda work, jobs, *_: ((j, work(j)) for j in jobs)
    )
    return opened


def test_homes_drawn_by_others_are_asked_where_they_lie_now(folder, monkeypatch, tmp_path):
    opened = judged_by_place(monkeypatch)
    lying = tmp_path / "homes.jar"
    lying.touch()
    keep(folder, "default", "c0ffee", [driven(Episode("gone/homes.jar/Studio", ("bed",)))])
    with pytest.raises(typer.BadParameter, match=r"is not there.+say by --worlds"):
        overshoot.ask(folder, ["default"])
    assert opened == [] and not results_file(folder, "overshoot", "default").exists()
    overshoot.ask(folder, ["default"], f"{lying}/Studio,{lying}/Loft")
    assert opened == [f"{lying}/Studio"]
    [kept] = Store(results_file(folder, "overshoot", "default"), overshoot.Overshoot).fullest()
    assert kept.result.episode.home == "gone/homes.jar/Studio"
    table = overshoot.overshoot_table(folder, ["default"])  # it never stood where a stop would do
    assert cells(table, "default") == ["1", "0", "-", "-", "-", "0"]


def test_what_is_driven_after_a_stop_would_do_is_asked_of_the_scorer(folder, monkeypatch):
    judged_by_place(monkeypatch)
    line = ((0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (1.0, 0.0))
    passed = replace(driven(EPISODES[0], success=False, way=5.5), track=line)
    never = replace(driven(EPISODES[1], way=3.0), track=line[:2])
    keep(folder, "default", "c0ffee", [passed, never])
    overshoot.ask(folder, ["default"])
    kept = Store(results_file(folder, "overshoot", "default"), overshoot.Overshoot).fullest()
    assert [(each.result.before, each.result.after) for each in kept] == [(2.0, 3.5), (None, None)]
    text = search_page(folder, folder / "search.md")
    driven_on = text.split("## Way before and after")[1]
    assert cells(driven_on, "default")[:6] == ["2", "1", "2.0", "3.5", "3.5", "1"]


def test_the_difference_of_spl_is_over_common_goals_alone():
    ours = [driven(each, way=5.0) for each in EPISODES]
    theirs = [driven(each, way=10.0) for each in EPISODES[:5]]
    assert spl_difference(ours, theirs)[0] == pytest.approx(0.5)
    assert spl_difference(ours, []) == (0.0, None)


def test_wrong_arrivals_are_counted_over_single_goals_and_goals_in_a_row(folder):
    keep(folder, "default", "c0ffee", [driven(each, each.home == 1040) for each in EPISODES])
    wrong, gave_up = (driven(EPISODES[1], False, claimed).goals[0] for claimed in (True, False))
    rows = [
        replace(driven(EPISODES[0]), episode=Episode(1040, GOALS, number, 4), goals=goals)
        for number, goals in enumerate([(wrong,), (driven(EPISODES[0]).goals[0], gave_up)])
    ]
    keep(folder, "default", "c0ffee", rows, bench="multi")
    rate, over_homes = wrong_arrivals(folder)
    assert (rate.count, rate.trials) == (6, 13)
    assert over_homes == pytest.approx((1 / 8, 1.0))
    text = search_page(folder, folder / "search.md")
    assert "Of all 13 goals" in text and "6 times (46.2 %, over homes 12 to 100)" in text


def test_the_paper_s_method_stands_beside_ours_on_the_board(folder):
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    keep(folder, "paper", "c0de", [driven(each, each == EPISODES[0]) for each in EPISODES[:4]])
    text = search_page(folder, folder / "search.md").split("\n## ")[0]
    assert cells(text, "paper")[:2] == ["4", "25.0"]
    assert cells(text, "default and paper")[:2] == ["3", "0"]


def test_todays_search_is_shown_on_the_quick_share_and_the_page_says_so(folder):
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    assert "## Today's search" not in search_page(folder, folder / "search.md")
    quick = folder.with_name("quick_share")
    keep(quick, "default", "c0de", [driven(each, each == EPISODES[0]) for each in EPISODES[:4]])
    text = search_page(folder, folder / "search.md").split("## Today's search")[1]
    assert "homes 1100 to 1107" in text and "no figure for other homes" in text
    assert cells(text, "default")[:2] == ["4", "25.0"]


def test_equal_paths_of_other_cosines_are_counted_on_the_same_computer(folder):
    tracks = [((0.0, 0.0), (number, 1.0)) for number in range(len(EPISODES))]
    moved = [
        replace(driven(each), track=track) for each, track in zip(EPISODES, tracks, strict=True)
    ]
    keep(folder, "default", "c0ffee", moved)
    parted = replace(moved[1], track=((9.0, 9.0),))
    keep(folder, "scaled", "c0ffee", [moved[0], parted, replace(moved[2], track=((8.0, 8.0),))])
    keep(folder.with_name("search_again"), "default", "c0ffee", [parted])
    text = search_page(folder, folder / "search.md")
    assert "`scaled` 2 of 3 paths" in text and "for 1 of them" in text


def test_questions_to_maps_compare_three_scales_with_the_coarsest_by_both_rules(folder):
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    assert "## Questions to maps" not in search_page(folder, folder / "search.md")
    _, queries = retrieval_stores(folder)
    for scales in SCALE_SETS:
        answers = [
            QueryResult(1040, scales, text, True, 0.5, 0.5, (1.0, 2.0), right, scales == (1,),
                        BelievedAnswer(0.8, right))
            for text, right in zip(("bed", "sofa"), (True, len(scales) == 3), strict=True)
        ]  # fmt: skip
        queries.add("a", "c0ffee", "2 cores", *answers)
    compared = three_and_coarsest([line.result for line in queries.fullest()])
    counts = [(three.count, alone.count, p) for three, alone, p in compared]
    assert counts == [(2, 1, 1.0), (0, 2, 0.5)]
    text = search_page(folder, folder / "search.md")
    assert "2 and 1 of 2 (p = 1.00) rightly by the robot's rule" in text
    assert "0 and 2 of 2 (p = 0.50) by the paper's own" in text
    assert "Expected calibration error 0.200, log loss" in text
    assert "is not shown: 0 of 2 comparisons show it" in text and "embedded_clip.md)" in text


def test_different_models_of_goals_are_counted_where_they_are_recorded(folder):
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    assert "different models" not in search_page(folder, folder / "search.md")
    models = (("bed", "one"), ("bed", "own shape: bed 1040-0-0 of boards"), ("sofa", "one"))
    Store(folder / "homes.jsonl", HomeGoals).add(
        "newer", "c0ffee", "2 cores", *(HomeGoals(home, GOALS, models) for home in HOMES)
    )
    text = search_page(folder, folder / "search.md")
    assert cells(text, "bed")[:4] == ["2", "2", "1", "1"]
    assert cells(text, "sofa")[:4] == ["2", "1", "0", "1"]


def test_a_model_counts_once_over_all_homes_and_goals_that_no_home_has_are_left_out():
    homes = [
        HomeGoals(1000, ("bed", "tv", "kitchen"), (("bed", "A"), ("bed", "B"), ("tv", "C"))),
        HomeGoals(1001, ("bed", "tv"), (("bed", "B"), ("bed", "D"), ("tv", "C"))),
    ]
    text = models_section(homes)
    assert cells(text, "bed") == ["2", "3", "0", "3"]
    assert cells(text, "tv") == ["2", "1", "0", "1"]
    assert "| kitchen" not in text


def test_shapes_of_boards_count_as_unseen_and_those_of_homes_for_development_as_seen():
    shapes = [f"own shape: bed {i}" for i in range(4)]
    homes = [
        HomeGoals(1019, ("bed",), (("bed", shapes[0]),)),
        HomeGoals(1150, ("bed",), (("bed", shapes[1]),)),
        HomeGoals(1200, ("bed",), (("bed", shapes[2]), ("bed", shapes[3]), ("bed", "A"))),
    ]
    assert cells(models_section(homes), "bed") == ["3", "5", "4", "3"]
