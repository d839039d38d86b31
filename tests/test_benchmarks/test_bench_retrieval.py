from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.episodes.episode import (
    BelievedAnswer,
    ExplorationResult,
    HomeGoals,
    QueryResult,
)
from benchmarks.episodes.exploration import SCALE_SETS, elements_of_scales
from benchmarks.harness.bench_plan import UNATTENDED, BenchPlan
from benchmarks.harness.fingerprint import Fingerprint
from benchmarks.objectnav import retrieval
from mapping.clip.config import ClipMapperConfig
from mapping.clip.patches import patch_boxes
from tests.test_benchmarks.printed_table import cells
from vizbot.config import Config

ANSWER = QueryResult(1000, (1, 0, -1), "sofa", True, 0.5, 0.4, (1.0, 2.0), True, True)
ABSENT = replace(ANSWER, text="tv", exists=False, correct=False)


def test_elements_of_a_scale_are_told_by_the_size_of_their_patch():
    config = ClipMapperConfig(scales=(1, 0, -1, -2))
    bundle = SimpleNamespace(elements=SimpleNamespace(boxes=patch_boxes(640, 480, config)))
    counts = [len(elements_of_scales(bundle, scales, config)) for scales in SCALE_SETS]
    # The paper's features per image, but that S = 224 gives 1, 4 and 20 patches of 640x480.
    assert counts == [1, 4, 20, 88, 5, 25, 113]
    assert np.array_equal(elements_of_scales(bundle, SCALE_SETS[-1], config), np.arange(113))


def test_a_home_is_explored_once_for_the_same_robot(tmp_path, monkeypatch):
    explored = []

    def inline(work, jobs, title, describe):
        for job in jobs:
            explored.append(job.home)
            found = ExplorationResult(job.home, True, "all was seen", 90)
            answers = [replace(ANSWER, home=job.home)]
            assert describe(job, (found, answers))
            yield job, (found, answers)

    monkeypatch.setattr(
        retrieval, "goals_of_homes",
        lambda plan, count: [HomeGoals(seed, ("sofa",)) for seed in plan.seeds[:count]],
    )  # fmt: skip
    monkeypatch.setattr(retrieval, "in_parallel", inline)
    monkeypatch.setattr(Fingerprint, "still_holds", lambda made: True)
    made = Fingerprint("embedded", "homes", "episodes", "oracles", "c0ffee", "2 cores")
    for homes, queries in (((1000, 1001), 2), ((1001, 1000, 1002), 3), ((1002,), 1)):
        outcome = retrieval.run_retrieval(BenchPlan(Config(), tmp_path, made, homes=homes))
        assert outcome.summary["queries"] == queries
    assert explored == [1000, 1001, 1002]
    retrieval.run_retrieval(BenchPlan(Config(), tmp_path, made, quick=True))
    assert explored[3:] == [1100, 1101]
    retrieval.run_retrieval(BenchPlan(Config(), tmp_path, made))
    assert explored[5:] == list(range(1060, 1068))


def test_precision_counts_only_what_exists():
    right = retrieval.precision([ANSWER, replace(ANSWER, correct=False), ABSENT])
    assert (right.count, right.trials) == (1, 2)


def test_every_scale_set_of_the_paper_has_its_row_and_the_default_makes_the_summary():
    wrong = [replace(ANSWER, scales=(scale,), correct=False) for scale in (1, 0, -1)]
    outcome = retrieval.retrieval_result([ANSWER, *wrong, ABSENT], (1, 0, -1))
    ours = [row for row in outcome.rows if "source" not in row]
    assert [tuple(row["scales"]) for row in ours] == list(SCALE_SETS)
    assert ours[0]["precision_at_1"] == 0.0
    assert ours[5]["precision_at_1"] == 1.0
    assert ours[6]["precision_at_1"] is None
    assert outcome.summary["queries"] == 1
    assert outcome.summary["precision_at_1"] == 1.0
    assert outcome.summary["single_scale_precision_at_1"] == 0.0
    assert outcome.text.count("paper, not run here") == 4
    assert outcome.text.count("no direct comparison") == 1
    assert "75.9" in outcome.text


def test_every_scale_set_is_shown_by_our_rule_and_by_the_paper_s():
    wrong_alone = replace(ANSWER, most_similar_correct=False)
    outcome = retrieval.retrieval_result([ANSWER, wrong_alone], (1, 0, -1))
    row = cells(outcome.text, "{1, 0, -1}")
    assert (row[0], row[3]) == ("100.0", "50.0")
    assert outcome.summary["most_similar_precision_at_1"] == 0.5


def test_precision_has_an_interval_over_homes_beside_wilsons():
    wrong = replace(ANSWER, home=1001, correct=False)
    text = retrieval.retrieval_result([ANSWER, ANSWER, wrong], (1, 0, -1)).text
    assert cells(text, "vizbot, default")[2:4] == ["21 to 94", "0 to 100"]


def test_three_scales_are_held_against_single_ones_by_both_rules():
    queries = [replace(ANSWER, text=text) for text in ("sofa", "bed", "tv", "sink")]
    singles = [
        replace(answer, scales=(scale,), correct=answer.text == "tv", most_similar_correct=True)
        for answer in queries
        for scale in (1, 0, -1)
    ]
    three = [replace(answer, most_similar_correct=answer.text == "bed") for answer in queries]
    summary = retrieval.retrieval_result([*three, *singles, ABSENT], (1, 0, -1)).summary
    assert summary["single_scale_precision_at_1"] == 0.25
    assert (summary["three_scale_wins"], summary["three_scale_losses"]) == (3, 0)
    assert summary["three_scale_p"] == pytest.approx(2 / 2**3)
    assert summary["most_similar_single_scale_precision_at_1"] == 1.0
    assert summary["most_similar_three_scale_losses"] == 3
    assert summary["most_similar_three_scales_better"] is False


def test_the_probabilities_of_first_answers_are_held_against_what_is_right():
    answers = [
        replace(ANSWER, believed=BelievedAnswer(0.9, True)),
        replace(ANSWER, correct=False, believed=BelievedAnswer(0.8, False)),
        replace(ABSENT, believed=BelievedAnswer(0.1, False)),
        replace(ANSWER, scales=(1,)),
    ]
    outcome = retrieval.retrieval_result(answers, (1, 0, -1))
    assert (outcome.summary["queries"], outcome.summary["precision_at_1"]) == (2, 0.5)
    assert outcome.summary["calibration_error"] == pytest.approx((0.1 + 0.8 + 0.1) / 3)
    loss = -(np.log(0.9) + np.log(0.2) + np.log(0.9)) / 3
    assert outcome.summary["log_loss"] == pytest.approx(loss)
    assert cells(outcome.text, "0.8 to 1.0")[:2] == ["0.85", "1 of 2"]


def test_answers_from_before_there_was_a_belief_have_no_figure_of_it():
    outcome = retrieval.retrieval_result([ANSWER], (1, 0, -1))
    for key in ("calibration_error", "log_loss"):
        assert outcome.summary[key] is None
    assert "probab" not in outcome.text


@pytest.mark.parametrize(
    ("similarity", "answered"),
    [(0.5, ["1 of 1", "1 of 1", "1 of 2"]), (0.41, ["1 of 1", "1 of 1", "0 of 2"])],
)
def test_thresholds_trade_answers_for_false_alarms(similarity, answered):
    answers = [ANSWER, replace(ABSENT, similarity=0.3), replace(ABSENT, similarity=similarity)]
    text = retrieval.retrieval_result(answers, (1, 0, -1)).text
    assert cells(text, "110% of the default")[:3] == answered


def test_how_the_homes_were_explored_stands_below():
    explorations = [
        ExplorationResult(1001, False, "not done within 3000 steps", 3000),
        ExplorationResult(1000, True, "everything that can be reached was seen", 812),
    ]
    text = retrieval.retrieval_result([ANSWER], (1, 0, -1), explorations).text
    assert text.index("home 1000") < text.index("home 1001")
    assert cells(text, "home 1000")[:2] == ["812", "explored"]
    assert cells(text, "home 1001")[:3] == ["3000", "cut off", "not done within 3000 steps"]


def test_maps_are_asked_with_the_cosines_of_another_encoder_in_a_file_of_their_own(
    tmp_path, monkeypatch
):
    jobs = []

    def in_parallel(function, asked, name, line):
        jobs.extend((job.home, job.encoder_scale, job.folder) for job in asked)
        explored = ExplorationResult(1000, True, "seen", 9)
        yield from ((job, (explored, [ANSWER])) for job in asked)

    monkeypatch.setattr(retrieval, "in_parallel", in_parallel)
    monkeypatch.setattr(retrieval, "require_unchanged", lambda plan: None)
    monkeypatch.setattr(
        retrieval, "goals_of_homes", lambda plan, count: [HomeGoals(1000, ("sofa",))]
    )
    made = Fingerprint("embedded", "homes", "episodes", "oracles", "c0ffee", "2 cores of X")
    for rows in (None, ("scaled",), ("scaled",)):
        plan = BenchPlan(UNATTENDED, tmp_path, made, (1000,), rows=rows)
        assert retrieval.run_retrieval(plan).summary["queries"] == 1
    assert [job[:2] for job in jobs] == [(1000, None), (1000, "clip")]
    assert jobs[0][2] == jobs[1][2]  # one map for both
    assert (tmp_path / "retrieval-queries-scaled.jsonl").exists()
