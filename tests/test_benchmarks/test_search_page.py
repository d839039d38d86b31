"""The page of the search: rows of two searches, on the same goals and on a part of them."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from benchmarks.episodes.absent_things import ThingAnswer
from benchmarks.episodes.episode import (
    BelievedAnswer,
    Episode,
    EpisodeResult,
    ExplorationResult,
    GoalResult,
    HomeGoals,
    QueryResult,
)
from benchmarks.episodes.exploration import SCALE_SETS
from benchmarks.fast_world.ranking import ranking_page
from benchmarks.harness.bench_plan import results_file
from benchmarks.harness.store import Store
from benchmarks.objectnav import overshoot
from benchmarks.objectnav.retrieval import retrieval_stores
from benchmarks.objectnav.search_page import search_page, spl_difference
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


def cells(text, first):
    rows = [[cell.strip() for cell in line.split("|")] for line in text.splitlines()]
    return next(row[2:-1] for row in rows if row[1:2] == [first])


def test_without_the_default_row_there_is_no_page(folder):
    keep(folder, "old", "0ld", map(driven, EPISODES))
    assert search_page(folder, folder / "search.md") == ""


def test_two_searches_are_paired_and_wrong_arrivals_are_counted_apart_from_giving_up(folder):
    gave_up, wrong, *others = EPISODES
    old = [driven(each, way=50.0) for each in others]
    old += [driven(gave_up, False, claimed=False), driven(wrong, False)]
    keep(folder, "old", "0ld", old)
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    text = search_page(folder, folder / "search.md")
    assert text.startswith("# Search\n")
    assert "- old: commit 0ld, 2 cores\n- default: commit c0ffee, 2 cores" in text
    assert "nothing here is compared" not in text
    assert cells(text, "old")[:2] == ["10", "80.0"] and cells(text, "old")[4] == "1 of 10"
    assert cells(text, "old")[5] == "8.0"
    assert cells(text, "default")[:2] == ["10", "100.0"] and cells(text, "default")[5] == "50.0"
    # Home 1040 has both failures: 0.5 - 3 x 0.1 / 5 there, 0.5 - 0.1 in the other one.
    assert cells(text, "default against old") == ["2", "0", "0.5", "+42.0", "40 to 44"]


def test_arrivals_are_held_against_the_probability_that_the_robot_gave(folder):
    sure = [("92% sure, from near by", True), ("70% sure, from near by", False)]
    sure += [("78% sure, from near by", True), ("80% of it was seen", False)]
    results = []
    for episode, (answer, right) in zip(EPISODES, sure, strict=False):
        result = driven(episode, right, claimed="sure" in answer)
        results.append(replace(result, goals=(replace(result.goals[0], answer=answer),)))
    keep(folder, "default", "c0ffee", results)
    text = search_page(folder, folder / "search.md").split("## How sure the robot was")[1]
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
    keep(folder, "old", "0ld", map(driven, EPISODES[:3]), hardware="16 cores")
    keep(folder, "old", "0ld", map(driven, EPISODES[3:]))
    text = search_page(folder, folder.with_name("search_repaired.md"))
    assert text.startswith("# Search repaired\n")
    assert "- old: commit 0ld, 2 cores (7 episodes) and 16 cores (3 episodes)" in text


def test_where_the_search_before_is_not_driven_the_page_says_that_nothing_is_compared(folder):
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    text = search_page(folder, folder / "search.md")
    assert "nothing here is compared" in text and "against" not in text


def test_a_row_of_a_part_stands_beside_the_default_on_that_part(folder):
    keep(folder, "default", "c0ffee", [driven(each, each.home == 1040) for each in EPISODES])
    keep(folder, "scaled", "c0ffee", map(driven, EPISODES[4:6]))
    text = search_page(folder, folder / "search.md")
    assert cells(text, "scaled")[:2] == ["2", "100.0"]
    assert "`scaled`: the embedded" in text and "`offset`" not in text
    assert cells(text, "default, the same goals")[:2] == ["2", "50.0"]
    assert "Without its parts" not in text


def test_searches_without_a_part_are_paired_with_the_whole_one_of_their_own_computer(folder):
    keep(folder, "default", "c0ffee", [driven(each, each.home == 1040) for each in EPISODES])
    parts = folder.with_name("search_parts")
    elsewhere = [driven(each, number < 2) for number, each in enumerate(EPISODES[3:6])]
    keep(parts, "default", "c0ffee", elsewhere, hardware="16 cores")
    keep(parts, "without commitment", "c0ffee", map(driven, EPISODES[3:6]), hardware="16 cores")
    without, both = search_page(folder, folder / "search.md").split("## The same goals on another")
    assert "Driven on 16 cores" in without and "are of 2 cores" in without
    assert cells(without, "default against without commitment")[:2] == ["0", "1"]
    assert cells(both, "default on 16 cores")[:2] == ["3", "66.7"]
    assert cells(both, "default, the same goals")[:2] == ["3", "66.7"]
    assert cells(both, "default against default on 16 cores")[:3] == ["0", "0", "1"]


def test_searches_without_a_part_say_how_much_of_the_whole_one_came_out_the_same(folder):
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    parts = folder.with_name("search_parts")
    again = [driven(each, way=10.0 + number // 2) for number, each in enumerate(EPISODES[3:6])]
    keep(parts, "default", "c0de", [replace(each, wall_seconds=7.0) for each in again])
    keep(parts, "without commitment", "c0de", [driven(each, False) for each in EPISODES[3:6]])
    text = search_page(folder, folder / "search.md").split("## Without its parts")[1]
    assert "Driven at commit c0de" in text and "2 of its 3 episodes are those of" in text
    assert cells(text, "default against without commitment")[:2] == ["3", "0"]
    assert "another computer" not in text


def test_what_the_truth_about_one_part_mends_is_told_of_the_failures(folder):
    driven_by_default = [driven(each, each.goals != ("sofa",)) for each in EPISODES]
    keep(folder, "default", "c0ffee", driven_by_default)
    assert "the truth about one part" not in search_page(folder, folder / "search.md").lower()
    failed, succeeded = [each for each in EPISODES if each.goals == ("sofa",)], EPISODES[:2]
    true, again = folder.with_name("search_true"), failed + succeeded
    keep(true, "true pose", "c0de", [driven(each, each not in failed[1:]) for each in again])
    keep(true, "true map", "c0de", [driven(each, each in succeeded[1:]) for each in again])
    text = search_page(folder, folder / "search.md").split("## With the truth about one part")[1]
    assert "at commit c0de." in text
    assert cells(text, "true pose")[-2:] == ["1 of 2", "2 of 2"]
    assert cells(text, "true map")[-2:] == ["0 of 2", "1 of 2"]
    assert "Of 2 failed episodes" in text and "mends 1. 1 fail whichever" in text


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
    assert "Only default reached all four" not in in_a_row
    fewer = replace(four, goals=(*four.goals[:3], driven(EPISODES[3], success=False).goals[0]))
    keep(folder, "old", "c0ffee", [fewer], bench="multi")
    in_a_row = search_page(folder, folder / "search.md").split("## Four goals in a row")[1]
    assert cells(in_a_row, "old")[:5] == ["1", "1", "1", "1", "0"]
    assert "Only default reached all four 1 times, only old 0 times" in in_a_row


def test_questions_to_maps_are_told_by_each_encoder(folder):
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    assert "## Questions to maps" not in search_page(folder, folder / "search.md")
    for scale, right in ((None, (True, True)), ("offset", (True, False))):
        explorations, queries = retrieval_stores(folder, scale)
        explorations.add("a", "c0ffee", "2 cores", ExplorationResult(1040, True, "all seen", 90))
        for scales in SCALE_SETS:
            answers = [
                QueryResult(1040, scales, text, True, 0.5, 0.5, (1.0, 2.0), each, False,
                            BelievedAnswer(0.8, each))
                for text, each in zip(("bed", "sofa"), right, strict=True)
            ]  # fmt: skip
            queries.add("a", "c0ffee", "2 cores", *answers)
    text = search_page(folder, folder / "search.md")
    by_encoder = text.split("| encoder")[1]
    assert cells(by_encoder, "default")[:4] == ["2", "100.0", "0.0", "0.200"]
    assert cells(by_encoder, "offset")[:4] == ["2", "50.0", "0.0", "0.300"]


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
    assert ["nowhere", "6", "83.3"] in [
        [cell.strip() for cell in line.split("|")][2:5] for line in absent.splitlines()
    ]


class Floor:
    """A world that only knows where the robot was put."""

    def __init__(self, *_):
        self.x = 0.0

    def __enter__(self):
        return self

    def __exit__(self, *exc):
        pass

    def place(self, x, y, yaw):
        self.x = x


def test_what_is_driven_after_a_stop_would_do_is_asked_of_the_scorer(folder, monkeypatch):
    monkeypatch.setattr(overshoot, "open_benchmark_home", Floor)
    verdict = SimpleNamespace
    monkeypatch.setattr(
        overshoot, "judge", lambda world, text, stopped: verdict(success=stopped and world.x >= 2.0)
    )
    monkeypatch.setattr(
        overshoot, "in_parallel", lambda work, jobs, *_: ((j, work(j)) for j in jobs)
    )
    line = ((0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (1.0, 0.0))
    passed = replace(driven(EPISODES[0], success=False, way=5.5), track=line)
    never = replace(driven(EPISODES[1], way=3.0), track=line[:2])
    keep(folder, "default", "c0ffee", [passed, never])
    overshoot.ask(folder, ["default"])
    kept = Store(results_file(folder, "overshoot", "default"), overshoot.Overshoot).fullest()
    assert [(each.result.before, each.result.after) for each in kept] == [(2.0, 3.5), (None, None)]
    text = search_page(folder, folder / "search.md")
    driven_on = text.split("## Driven after the robot first stood")[1]
    assert cells(driven_on, "default")[:6] == ["2", "1", "2.0", "3.5", "3.5", "1"]


def test_searches_in_the_fast_world_stand_beside_those_in_the_whole_loop(tmp_path):
    folder = tmp_path / "ranking"
    for name, whole, fast in (("paper", 50.0, 40.0), ("old choosy 1.0", 25.0, 20.0)):
        keep(folder, name, "0ld", [driven(each, way=whole) for each in EPISODES], bench="whole")
        assert ranking_page(folder, folder / "ranking.md") == ""
        keep(folder, name, "0ld", [driven(each, way=fast) for each in EPISODES[:5]], bench="fast")
        keep(folder, "default", "c0ffee", map(driven, EPISODES), bench="whole")
    text = ranking_page(folder, folder / "ranking.md")
    spl, fast_spl = "10.0 ± 0.0", "12.5 ± 0.0"
    assert cells(text, "paper") == ["5", "100.0", spl, "100", "100.0", fast_spl, "100", "0ld"]
    assert cells(text, "old, choosy 1.0")[2] == "20.0 ± 0.0" and "(Spearman): 1.00" in text


def test_how_much_spl_differs_between_episodes_stands_beside_it(tmp_path):
    folder = tmp_path / "ranking"
    for name, ways in (("old", (20.0, 10.0)), ("default", (10.0, 5.0))):
        for world in ("whole", "fast"):
            rows = [driven(each, way=way) for each, way in zip(EPISODES[:2], ways, strict=True)]
            keep(folder, name, "c0ffee", rows, bench=world)
    text = ranking_page(folder, folder / "ranking.md")
    assert cells(text, "old")[2] == "37.5 ± 12.5"
    assert cells(text, "default")[5] == "75.0 ± 25.0"


def test_distinct_models_of_goals_are_counted_where_they_are_recorded(folder):
    keep(folder, "default", "c0ffee", map(driven, EPISODES))
    assert "distinct models" not in search_page(folder, folder / "search.md")
    models = (("bed", "one"), ("bed", "own shape: bed 1040-0-0 of boards"), ("sofa", "one"))
    Store(folder / "homes.jsonl", HomeGoals).add(
        "newer", "c0ffee", "2 cores", *(HomeGoals(home, GOALS, models) for home in HOMES)
    )
    text = search_page(folder, folder / "search.md")
    assert cells(text, "bed")[:4] == ["2", "2", "1", "1"]
    assert cells(text, "sofa")[:4] == ["2", "1", "0", "1"]


def test_the_difference_of_spl_is_over_common_goals_alone():
    ours = [driven(each, way=5.0) for each in EPISODES]
    theirs = [driven(each, way=10.0) for each in EPISODES[:5]]
    assert spl_difference(ours, theirs)[0] == pytest.approx(0.5)
    assert spl_difference(ours, []) == (0.0, None)
