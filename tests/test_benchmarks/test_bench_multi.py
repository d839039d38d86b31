from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.episodes.episode import Episode, EpisodeResult, GoalResult, HomeGoals
from benchmarks.harness.bench_plan import BenchPlan
from benchmarks.harness.fingerprint import Fingerprint
from benchmarks.objectnav import multi_goal
from tests.test_benchmarks.printed_table import cells
from vizbot.config import Config

HOME = HomeGoals(1000, ("bed", "chair", "sofa", "kitchen", "window", "tv"))
FOUR = ("bed", "chair", "sofa", "tv")


def reached(count):
    told = FOUR[: count + 1]
    goals = tuple(
        GoalResult(
            text, i < count, True, "" if i < count else "far", "seen", 1.0, 10, 1.0, 1.0, 2.0
        )
        for i, text in enumerate(told)
    )
    return EpisodeResult(Episode(1000, FOUR, 1), goals, 0, None, 1.0, (), (0.0, 0.0, 0.0))


def test_100_episodes_in_eight_homes_ask_for_four_different_things_each_has():
    homes = [HomeGoals(seed, HOME.goals) for seed in range(1020, 1028)]
    episodes = multi_goal.multi_goal_episodes(homes, multi_goal.episodes_in(homes))
    of_home = Counter(episode.home for episode in episodes)
    assert list(of_home) == list(range(1020, 1028))
    assert list(of_home.values()) == [13] * 4 + [12] * 4
    assert len(set(episodes)) == 100
    for episode in episodes:
        assert len(set(episode.goals)) == 4
        assert set(episode.goals) <= set(HOME.goals)
    firsts = {episode.goals[0] for episode in episodes}
    assert firsts == set(HOME.goals)


def test_a_part_of_the_homes_has_its_part_of_the_episodes():
    assert multi_goal.episodes_in([HOME]) == 12
    assert multi_goal.episodes_in([HOME] * 4) == 50


def test_the_same_goals_are_drawn_every_time():
    drawn = multi_goal.multi_goal_episodes([HOME], 12)
    assert multi_goal.multi_goal_episodes([HOME], 12) == drawn
    assert multi_goal.multi_goal_episodes([HOME], 1) == drawn[:1]


def test_episodes_are_counted_that_reach_at_least_so_many_goals():
    outcome = multi_goal.multi_goal_result(
        {"default": [reached(4), reached(4), reached(2), reached(0)]}
    )
    assert [rate.count for rate in multi_goal.at_least_rates([reached(2)])] == [1, 1, 0, 0]
    assert outcome.rows[0] == {
        "row": "default", "episodes": 4,
        "at_least_1": 3, "at_least_2": 3, "at_least_3": 2, "at_least_4": 2,
    }  # fmt: skip
    assert outcome.summary["episodes"] == 4
    assert outcome.summary["four_in_a_row"] == 2


def test_the_paper_stands_beside_ours_and_is_marked():
    outcome = multi_goal.multi_goal_result({"default": [reached(4)]})
    assert [row["at_least_4"] for row in outcome.rows[1:]] == [14, 12, 37]
    assert all(row["source"] == "paper, not run here" for row in outcome.rows[1:])


def test_the_last_rate_has_an_interval_over_homes_beside_wilsons():
    failed = replace(reached(0), episode=Episode(1001, FOUR, 1))
    text = multi_goal.multi_goal_result({"default": [reached(4), reached(4), failed]}).text
    assert cells(text, "vizbot, default")[-2:] == ["21 to 94", "0 to 100"]


def test_goals_that_end_episodes_are_named_with_how_often_they_were_told():
    text = multi_goal.multi_goal_result({"default": [reached(0), reached(0), reached(1)]}).text
    assert cells(text, "bed")[:2] == ["2", "3"]


@pytest.mark.parametrize("quick", [True, False])
def test_a_smoke_test_says_so(quick):
    outcome = multi_goal.multi_goal_result({"default": [reached(4)]}, quick)
    assert outcome.text.startswith("A smoke test") is quick


def test_far_goals_follow_in_an_order_that_home_and_number_draw():
    near, far = (multi_goal.multi_goal_episodes([HOME], 12, far=far) for far in (False, True))
    for four, candidates in zip(near, far, strict=True):
        assert set(candidates.goals) == set(HOME.goals)
        assert candidates.goals[:4] == four.goals
        assert (candidates.number, candidates.count, four.count) == (four.number, 4, 4)


def with_ways(result, *ways):
    goals = [replace(goal, shortest_path=way) for goal, way in zip(result.goals, ways, strict=True)]
    return replace(result, goals=tuple(goals))


def test_both_rows_say_how_many_later_goals_were_within_reach_at_once():
    near = [with_ways(reached(4), 0.0, 0.0, 5.0, 0.0), with_ways(reached(1), 4.0, 0.4)]
    far = [with_ways(reached(4), 0.0, 3.1, 4.0, 9.0)]
    outcome = multi_goal.multi_goal_result({"default": near, "over 3 m": far})
    summary = outcome.summary
    assert (summary["later_goals"], summary["later_goals_within_reach"]) == (4, 2)
    assert (summary["far_later_goals"], summary["far_later_goals_within_reach"]) == (3, 0)
    assert (summary["four_in_a_row"], summary["far_four_in_a_row"]) == (1, 1)
    assert "Row default: of 4 later goals 2 were given where" in outcome.text
    assert "Row over 3 m: of 3 later goals 0 were given where" in outcome.text
    assert [row["row"] for row in outcome.rows[:2]] == ["default", "over 3 m"]


def test_an_episode_that_runs_out_of_far_goals_is_told_and_blames_no_goal():
    ended = replace(reached(4), goals=reached(4).goals[:2])
    assert not ended.success
    text = multi_goal.multi_goal_result({"over 3 m": [ended]}).text
    assert "1 episodes ended because no goal was that far." in text
    assert "goal that ended an episode" not in text


def test_both_rows_are_driven_unless_one_is_asked_for(monkeypatch):
    driven = []

    def run_missing(plan, bench, jobs):
        driven.append(jobs)
        return {job: reached(4) for job in jobs}

    monkeypatch.setattr(multi_goal, "run_missing", run_missing)
    monkeypatch.setattr(multi_goal, "goals_of_homes", lambda plan, count: [HOME] * (count or 8))
    made = Fingerprint("embedded", "homes", "episodes", "oracles", "c0ffee", "2 cores")
    for options in ({}, {"quick": True}, {"rows": ("over 3 m",)}, {"rows": ("paper",)}):
        multi_goal.run_multi_goal(BenchPlan(Config(), Path(), made, **options))
    counts = [Counter(variant.name for variant, _ in jobs) for jobs in driven]
    assert counts == [
        {"default": 100, "over 3 m": 100}, {"default": 2}, {"over 3 m": 100}, {"paper": 100}
    ]  # fmt: skip
    assert {episode.choose for variant, episode in driven[2]} == {4}
    assert {variant.config.objectnav.method for variant, _ in driven[3]} == {"paper"}
    assert [e for _, e in driven[3]] == [e for v, e in driven[0] if v.name == "default"]


def test_the_summary_is_that_of_the_papers_method_where_it_is_driven_alone():
    alone = multi_goal.multi_goal_result({"paper": [reached(4), reached(2)]})
    assert (alone.summary["episodes"], alone.summary["four_in_a_row"]) == (2, 1)
    both = multi_goal.multi_goal_result({"default": [reached(4)], "paper": [reached(2)]})
    assert (both.summary["episodes"], both.summary["four_in_a_row"]) == (1, 1)
