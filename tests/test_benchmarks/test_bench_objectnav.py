"""What benches keep of the board, with episodes that nobody drives."""

from pathlib import Path

import pytest

from benchmarks.episodes.episode import Episode, EpisodeResult, GoalResult, HomeGoals
from benchmarks.harness import bench_plan
from benchmarks.harness.bench_plan import BenchPlan
from benchmarks.harness.fingerprint import Fingerprint
from benchmarks.harness.store import Store
from benchmarks.objectnav import single_goal
from tests.test_benchmarks.printed_table import cells
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.observer import Outcome

GOALS = ("bed", "chair", "sofa", "kitchen", "window")


def driven(job, fails=()):
    """What a robot would do that fails at some goals, unless it has an oracle for them."""
    variant, episode = job
    success = episode.goals[0] not in fails or variant.oracle == "encoder"
    reason = "" if success else "3.00 m away"
    answer = GoalResult(
        episode.goals[0], success, True, reason, "seen", 3.0, 100, 8.0, 4.0, 20.0, stuck=False
    )
    return EpisodeResult(episode, (answer,), 0, 0.01, 5.0, ((0.0, 0.0),), (0.0, 0.0, 0.0))


@pytest.fixture
def fake(monkeypatch):
    """Homes and episodes without a simulator; which episodes were driven, in order."""
    ran = []

    def inline(work, jobs, title, describe):
        for job in jobs:
            result = HomeGoals(job, GOALS) if title == "homes" else driven(job, ("sofa", "window"))
            if title != "homes":
                ran.append((job[0].name, job[1]))
            describe(job, result)
            yield job, result

    monkeypatch.setattr(bench_plan, "in_parallel", inline)
    monkeypatch.setattr(Fingerprint, "still_holds", lambda made: True)
    return ran


MADE = Fingerprint("embedded", "homes", "episodes", "oracles", "c0ffee", "2 cores")


def asked(tmp_path: Path, **options) -> BenchPlan:
    return BenchPlan(Config(), tmp_path, MADE, **options)


@pytest.mark.parametrize(
    ("homes", "count"), [(None, None), ((1007, 1003), None), (("1140+bare", "1141+bare"), 3)]
)
def test_every_goal_of_every_home_or_its_first_ones_are_driven_to(fake, tmp_path, homes, count):
    single_goal.run_single_goal(asked(tmp_path, rows=("default",), homes=homes, goals=count))
    expected = [Episode(h, (goal,)) for h in homes or range(1060, 1068) for goal in GOALS[:count]]
    assert fake == [("default", episode) for episode in expected]
    assert not asked(tmp_path, goals=3).full


def test_the_rows_are_driven_on_the_same_episodes(fake, tmp_path):
    single_goal.run_single_goal(asked(tmp_path, homes=(1000,)))
    of_row = {}
    for row, episode in fake:
        of_row.setdefault(row, []).append(episode)
    assert of_row["scale 1"] == of_row["scale 0"] == of_row["scale -1"] == of_row["default"]
    assert [v.config.perception.clip_mapper.scales for v in single_goal.variants(Config())][:4] == [
        (1, 0, -1), (1,), (0,), (-1,)
    ]  # fmt: skip


def test_oracles_repeat_what_failed_and_as_many_that_succeeded(fake, tmp_path):
    outcome = single_goal.run_single_goal(asked(tmp_path, homes=(1000,)))
    for part in ("pose", "depth", "encoder", "map"):
        repeated = [episode.goals[0] for row, episode in fake if row == f"true {part}"]
        assert repeated[:2] == ["sofa", "window"]
        assert len(set(repeated)) == 4
    assert cells(outcome.text, "true encoder") == [
        "4", "100.0", "51 to 100", "50.0", "100", "2 of 2", "2 of 2"
    ]  # fmt: skip
    assert cells(outcome.text, "true pose")[-2:] == ["0 of 2", "2 of 2"]
    assert "Of 2 failed episodes that every oracle repeated" in outcome.text
    assert (
        "repeated, 2 succeed with the truth" in outcome.text
        and "whichever part" not in outcome.text
    )


def test_only_failures_that_every_oracle_repeated_count_as_explained_or_not():
    default, *_, pose, depth, encoder, true_map = single_goal.variants(Config())
    episodes = [Episode(1000, (goal,)) for goal in ("sofa", "window")]
    results = {
        v.name: [driven((v, e), ("sofa", "window")) for e in episodes]
        for v in (default, pose, depth, true_map)
    }
    results[encoder.name] = [driven((encoder, episodes[0]), ("sofa", "window"))]
    text = single_goal.single_goal_result(results).text
    assert "Of 1 failed episodes that every oracle repeated" in text
    assert "repeated, 1 succeed with the truth" in text and "whichever part" not in text


def test_every_driven_row_is_printed_in_full(fake, tmp_path):
    text = single_goal.run_single_goal(asked(tmp_path, homes=(1000,))).text
    for row in ("default", "scale 1", "scale 0", "scale -1"):
        assert cells(text, f"vizbot, {row}") == [
            "5", "60.0", "23 to 88", "-", "66.7", "50.0", "30.0", "0", "100", "100",
            "8.0", "4.0", "0", "0.01",
        ]  # fmt: skip


def test_the_default_is_held_against_the_best_single_scale_on_the_same_episodes():
    default, one, zero, minus_one, *_ = single_goal.variants(Config())
    episodes = [Episode(1000, (goal,)) for goal in GOALS]

    def row(variant, fails, which=slice(None)):
        return {variant.name: [driven((variant, e), fails) for e in episodes[which]]}

    results = row(default, ("sofa",)) | row(one, GOALS) | row(zero, ("bed", "chair"))
    assert single_goal.single_goal_result(results).summary["single_scale_success_rate"] is None
    results |= row(minus_one, ("bed",), slice(4))
    summary = single_goal.single_goal_result(results).summary
    assert summary["single_scale_episodes"] == 4
    assert summary["single_scale_success_rate"] == 0.75
    assert summary["three_scale_success_rate"] == 0.75


def as_kept(stuck, success=False):
    """The result of an episode as a row keeps it; None is an older one, without `stuck`."""
    goal = GoalResult(
        "bed", success, False, "", "", 3.0, 100, 8.0, 4.0, 20.0, Outcome.GAVE_UP, stuck=stuck
    )
    return EpisodeResult(Episode(1100, ("bed",)), (goal,), 0, 0.01, 5.0, (), (0.0, 0.0, 0.0))


def test_stuck_counts_the_failed_episodes_that_stood_still(tmp_path):
    store = Store(tmp_path / "rows.jsonl", EpisodeResult)
    store.add("k", "c", "h", *map(as_kept, (True, False, True)), as_kept(False, success=True))
    kept = Store(tmp_path / "rows.jsonl", EpisodeResult).results_with_key("k")
    result = single_goal.single_goal_result({"default": kept})
    assert result.summary["stuck"] == 2
    assert result.rows[0]["stuck"] == 2
    assert cells(result.text, "vizbot, default")[7] == "2"
    assert "not known" not in result.text


def test_what_rows_of_before_do_not_say_of_stuck_is_not_counted_as_none(tmp_path):
    result = single_goal.single_goal_result({"default": [as_kept(False), as_kept(None)]})
    assert result.summary["stuck"] is None
    assert cells(result.text, "vizbot, default")[7] == "-"
    assert "Of 1 failed ones it is not known" in result.text
    reached = [as_kept(None, success=True), as_kept(True)]
    assert single_goal.single_goal_result({"default": reached}).summary["stuck"] == 1


def test_sources_that_change_under_way_end_the_run(fake, tmp_path, monkeypatch):
    monkeypatch.setattr(Fingerprint, "still_holds", lambda made: len(fake) == 0)
    with pytest.raises(ConfigError, match="run it again"):
        single_goal.run_single_goal(asked(tmp_path, homes=(1000,)))
    assert {row for row, _ in fake} == {"default", "scale 1", "scale 0", "scale -1"}
    assert len((tmp_path / "objectnav-default.jsonl").read_text().splitlines()) == 5


def test_a_second_run_does_only_what_is_missing(fake, tmp_path):
    single_goal.run_single_goal(asked(tmp_path, rows=("default",), homes=(1000,)))
    fake.clear()
    single_goal.run_single_goal(asked(tmp_path, rows=("default",), homes=(1000, 1001)))
    assert {episode.home for _, episode in fake} == {1001}


def test_a_run_that_is_killed_keeps_what_was_finished(fake, tmp_path, monkeypatch):
    through = bench_plan.in_parallel

    def killed(work, jobs, title, describe):
        for count, finished in enumerate(through(work, jobs, title, describe)):
            if title != "homes" and count == 3:
                raise KeyboardInterrupt
            yield finished

    monkeypatch.setattr(bench_plan, "in_parallel", killed)
    with pytest.raises(KeyboardInterrupt):
        single_goal.run_single_goal(asked(tmp_path, rows=("default",), homes=(1000,)))
    fake.clear()
    monkeypatch.setattr(bench_plan, "in_parallel", through)
    single_goal.run_single_goal(asked(tmp_path, rows=("default",), homes=(1000,)))
    assert [episode.goals[0] for _, episode in fake] == ["kitchen", "window"]


def test_quick_takes_a_third_of_homes_1100_to_1107_in_turns_and_claims_nothing(fake, tmp_path):
    outcome = single_goal.run_single_goal(asked(tmp_path, quick=True))
    assert {row for row, _ in fake} == {"default"}
    assert {episode.home for _, episode in fake} == set(range(1100, 1108))
    assert [episode.goals[0] for _, episode in fake][:7] == [
        "bed", "kitchen", "chair", "window", "sofa", "bed", "kitchen"
    ]  # fmt: skip
    assert outcome.text.startswith("The quick share") and "no claim" in outcome.text


def test_an_oracle_repeats_every_episode_of_a_quick_run_and_named_homes_are_told(fake, tmp_path):
    wanted = asked(tmp_path, quick=True, homes=(1040, 1041), rows=("true encoder",))
    outcome = single_goal.run_single_goal(wanted)
    default, true = ([e for row, e in fake if row == name] for name in ("default", "true encoder"))
    assert true == default and len(true) == 4
    assert outcome.text.startswith("Every third goal of these homes.")


ROWS_BY_OTHERS = ("default", "true encoder", "perfect stop", "paper")


def test_in_homes_by_others_all_rows_are_driven_to_the_same_goals_and_resume(fake, tmp_path):
    homes = ("a.jar/Studio", "b.sh3d")
    plan = asked(tmp_path, homes=homes, rows=ROWS_BY_OTHERS)
    outcome = single_goal.run_single_goal(plan)
    expected = [Episode(home, (goal,)) for home in homes for goal in GOALS]
    assert {row: [e for of, e in fake if of == row] for row, _ in fake} == dict.fromkeys(
        ROWS_BY_OTHERS, expected
    )
    assert cells(outcome.text, "true encoder")[-2:] == ["4 of 4", "6 of 6"]
    assert cells(outcome.text, "perfect stop")[0] == "10"
    assert outcome.summary["stuck"] == 0 and outcome.summary["success_rate"] == 0.6
    path = tmp_path / "objectnav-perfect-stop.jsonl"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:7]))
    fake.clear()
    assert single_goal.run_single_goal(plan).summary == outcome.summary
    assert fake == [("perfect stop", episode) for episode in expected[7:]]


def test_a_search_without_a_part_is_driven_to_one_goal_of_five_when_asked_for(fake, tmp_path):
    homes, ablated = tuple(range(1040, 1048)), "without likeness at frontiers"
    single_goal.run_single_goal(asked(tmp_path, homes=homes, rows=(ablated,)))
    assert [(row, e.home, *e.goals) for row, e in fake][:6] == [
        (ablated, 1040 + i, goal) for i, goal in enumerate([*GOALS, "bed"])
    ]
    assert len(fake) == len(homes)


def test_a_home_is_surveyed_once(fake, tmp_path):
    plan = asked(tmp_path, homes=(1100, 1101))
    assert [each.home for each in bench_plan.goals_of_homes(plan, 1)] == [1100]
    surveyed = (tmp_path / "homes.jsonl").read_text()
    assert len(surveyed.splitlines()) == 1
    bench_plan.goals_of_homes(plan)
    assert (tmp_path / "homes.jsonl").read_text().startswith(surveyed)
    assert len((tmp_path / "homes.jsonl").read_text().splitlines()) == 2


def test_the_paper_stands_beside_ours_and_is_marked(fake, tmp_path):
    outcome = single_goal.run_single_goal(asked(tmp_path, rows=("default",), homes=(1000,)))
    quoted = [row for row in outcome.rows if "source" in row]
    assert len(quoted) == 5
    assert {row["source"] for row in quoted} == {"paper, not run here"}
    assert quoted[-1]["success_rate"] == pytest.approx(0.87)
    assert outcome.text.count("paper, not run here") == 5
    assert outcome.text.count("no direct comparison") == 1
    assert cells(outcome.text, "{1, 0, -1}")[:3] == ["25", "87.0", "60.0"]


def test_the_summary_has_what_checks_read(fake, tmp_path):
    summary = single_goal.run_single_goal(asked(tmp_path, rows=("default",), homes=(1000,))).summary
    assert set(summary) == {
        "episodes", "success_rate", "success_low", "success_high", "others", "others_success_rate",
        "spl", "single_scale_episodes", "single_scale_success_rate", "three_scale_success_rate",
        "three_scale_wins", "three_scale_losses", "three_scale_p", "three_scales_better",
        "steps_mean", "false_claims", "stuck",
    }  # fmt: skip
    assert summary["episodes"] == 5
    assert summary["success_rate"] == 0.6
    assert (summary["steps_mean"], summary["false_claims"]) == (100, 0.4)
    assert summary["success_low"] == pytest.approx(0.2307, abs=1e-4)
    assert summary["others_success_rate"] == 0.5
    assert summary["spl"] == pytest.approx(0.3)


def test_where_nothing_failed_there_is_nobody_to_blame():
    results = [driven((single_goal.variants(Config())[0], Episode(1000, ("bed",))))]
    assert single_goal.failed_and_as_many(results) == []


def test_the_row_of_the_papers_method_is_driven_only_when_asked_for(fake, tmp_path):
    single_goal.run_single_goal(asked(tmp_path, homes=(1100,)))
    assert "paper" not in {row for row, _ in fake}
    fake.clear()
    outcome = single_goal.run_single_goal(asked(tmp_path, rows=("paper",), homes=(1100,)))
    assert fake == [("paper", Episode(1100, (goal,))) for goal in GOALS]
    assert (outcome.rows[0]["row"], outcome.rows[0]["success_rate"]) == ("paper", 0.6)
    assert outcome.summary["success_rate"] == 0.6 and "others_p" not in outcome.summary
    assert cells(outcome.text, "vizbot, paper")[:2] == ["5", "60.0"]


def test_the_papers_method_has_rows_of_its_own_beside_those_of_the_default(fake, tmp_path):
    default, *others = single_goal.variants(Config())
    paper = next(each for each in others if each.name == "paper")
    assert paper.config.objectnav.method == "paper"
    assert MADE.key_of(paper) != MADE.key_of(default)
    both = single_goal.run_single_goal(asked(tmp_path, rows=("default", "paper"), homes=(1100,)))
    alone = single_goal.run_single_goal(asked(tmp_path, rows=("default",), homes=(1100,)))
    assert both.summary == alone.summary
    scales = [line for line in both.text.splitlines() if line.startswith("| {1, 0, -1} ")]
    assert scales == [line for line in alone.text.splitlines() if line in scales]
