"""`vizbot bench retrieval`: queries to maps of explored homes (paper, offline object retrieval)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from benchmarks.episodes.episode import EncoderScale, ExplorationResult, QueryResult, Variant
from benchmarks.episodes.exploration import SCALE_SETS, HomeToAsk, explore_and_ask
from benchmarks.harness.bench_plan import (
    ENCODER_ROWS,
    BenchPlan,
    BenchResult,
    goals_of_homes,
    require_unchanged,
    results_file,
)
from benchmarks.harness.scores import (
    Rate,
    expected_calibration_error,
    interval_over_homes,
    log_loss,
)
from benchmarks.harness.store import Store
from benchmarks.harness.tables import (
    fraction_text,
    interval_text,
    markdown_table,
    percent_range,
    scale_set_text,
)
from benchmarks.harness.workers import in_parallel
from benchmarks.objectnav import paper_figures
from benchmarks.objectnav.scale_comparison import ScaleComparison
from benchmarks.objectnav.single_goal import with_scales
from sim_stubs.scoring.success import IN_COCO
from vizbot.config import Config

NAME = "retrieval"
MAPS = Path("runs/board")
"""Folder of the explored maps, which are too large to be committed."""
_QUICK_HOMES = 2
_SHARES = (0.8, 0.9, 1.0, 1.1, 1.2)
"""Compared thresholds, as shares of the default one."""
_PROBABILITIES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.01)
"""Bounds of the bins in which probabilities are compared with the truth."""


def run_retrieval(plan: BenchPlan) -> BenchResult:
    """Explore and query the homes that have no results yet, and print the tables."""
    homes = goals_of_homes(plan, _QUICK_HOMES if plan.quick else None)
    seeds = [each.home for each in homes if isinstance(each.home, int)]
    require_unchanged(plan)
    scale = next((scale for scale, row in ENCODER_ROWS.items() if plan.rows == (row,)), None)
    explorer, fingerprint = explorer_of(plan.config), plan.fingerprint
    maps = MAPS / fingerprint.key_of(explorer)
    key = fingerprint.key_of(replace(explorer, encoder_scale=scale))
    explorations, queries = retrieval_stores(plan.folder, scale)
    asked = {answer.home for answer in queries.results_with_key(key)}
    jobs = [
        HomeToAsk(explorer.config, seed, maps / f"home-{seed}", scale)
        for seed in seeds
        if seed not in asked
    ]
    for _, (exploration, answers) in in_parallel(explore_and_ask, jobs, NAME, _exploration_line):
        explorations.add(key, fingerprint.commit, fingerprint.hardware, exploration)
        queries.add(key, fingerprint.commit, fingerprint.hardware, *answers)
    if plan.full:
        explorations.drop_others(key)
        queries.drop_others(key)
    answers = [each for each in queries.results_with_key(key) if each.home in seeds]
    explored = [each for each in explorations.results_with_key(key) if each.home in seeds]
    scales = plan.config.perception.clip_mapper.scales
    return retrieval_result(answers, scales, explored, smoke_test=plan.quick)


def explorer_of(config: Config) -> Variant:
    """The robot that explores homes, with patches of all scales."""
    return Variant("explorer", with_scales(config, SCALE_SETS[-1]))


def retrieval_stores(
    folder: Path, scale: EncoderScale | None = None
) -> tuple[Store[ExplorationResult], Store[QueryResult]]:
    """The stores of the explorations and of the answers of their maps, by an encoder's cosines."""
    row = "" if scale is None else f" {ENCODER_ROWS[scale]}"
    return (
        Store(results_file(folder, NAME, f"explorations{row}"), ExplorationResult),
        Store(results_file(folder, NAME, f"queries{row}"), QueryResult),
    )


def retrieval_result(
    answers: Sequence[QueryResult],
    scales: tuple[int, ...],
    explorations: Sequence[ExplorationResult] = (),
    smoke_test: bool = False,
) -> BenchResult:
    """Rows, summary and tables of these answers."""
    default = [answer for answer in answers if answer.scales == scales]
    rows: list[dict[str, object]] = [
        {"row": scale_set_text(each), "scales": list(each)} | _rates(_of_scales(answers, each))
        for each in SCALE_SETS
    ]
    rows += [
        {"row": method, "source": paper_figures.MARK, "precision_at_1": all_ / 100,
         "coco_precision_at_1": coco / 100, "others_precision_at_1": others / 100}
        for method, all_, coco, others in paper_figures.RETRIEVAL
    ]  # fmt: skip
    right = precision(default)
    low, high = right.interval()
    by_robot = _scale_comparison(answers, scales)
    by_paper_rule = _scale_comparison(_by_paper_rule(answers), scales)
    summary: dict[str, object] = {
        "queries": right.trials,
        "precision_at_1": right.value,
        "precision_low": low,
        "precision_high": high,
        "most_similar_precision_at_1": precision(_by_paper_rule(default)).value,
        "calibration_error": expected_calibration_error(_judged(default)),
        "log_loss": log_loss(_judged(default)),
        "single_scale_precision_at_1": by_robot.best_single,
        "most_similar_single_scale_precision_at_1": by_paper_rule.best_single,
    }
    summary |= by_robot.summary() | by_paper_rule.summary("most_similar_")
    parts = [_main_table(default), _scales_table(answers)]
    parts.append(by_robot.table("the robot's answer"))
    parts.append(by_paper_rule.table("the most similar element"))
    parts += [_thresholds(default), _reliability(default), _explorations(explorations)]
    if smoke_test:
        parts.insert(0, "A smoke test on a part of the homes: no claim.")
    return BenchResult(NAME, rows, summary, "\n\n".join(part for part in parts if part))


def precision(answers: Sequence[QueryResult]) -> Rate:
    """How many queries for existing things have a correct best answer."""
    return Rate.over(answer.correct for answer in answers if answer.exists)


def _scale_comparison(answers: Sequence[QueryResult], scales: tuple[int, ...]) -> ScaleComparison:
    """These scales together against each of them alone, on queries for existing things."""

    def right(of: tuple[int, ...]) -> dict[tuple[int, str], bool]:
        existing = (answer for answer in _of_scales(answers, of) if answer.exists)
        return {(answer.home, answer.text): answer.correct for answer in existing}

    singles = {f"scale {scale}": right((scale,)) for scale in scales}
    return ScaleComparison.over(right(scales), singles)


def _over_homes(answers: Sequence[QueryResult]) -> str:
    """95 % interval of the precision over homes."""
    existing = (answer for answer in answers if answer.exists)
    return percent_range(interval_over_homes((a.home, a.correct) for a in existing))


def _by_paper_rule(answers: Sequence[QueryResult]) -> list[QueryResult]:
    """The same queries, answered by the most similar element alone."""
    return [replace(answer, correct=answer.most_similar_correct) for answer in answers]


def _judged(answers: Sequence[QueryResult]) -> list[tuple[float, bool]]:
    """Probability of each first answer by belief, and whether it is right."""
    return [(a.believed.probability, a.believed.correct) for a in answers if a.believed is not None]


def _rates(answers: Sequence[QueryResult]) -> dict[str, object]:
    coco = [answer for answer in answers if answer.text in IN_COCO]
    others = [answer for answer in answers if answer.text not in IN_COCO]
    return {
        "queries": precision(answers).trials,
        "precision_at_1": precision(answers).value,
        "coco_precision_at_1": precision(coco).value,
        "others_precision_at_1": precision(others).value,
    }


def _of_scales(answers: Sequence[QueryResult], scales: tuple[int, ...]) -> list[QueryResult]:
    return [answer for answer in answers if answer.scales == scales]


def _main_table(default: Sequence[QueryResult]) -> str:
    rows: list[list[object]] = [
        [f"{method} ({paper_figures.MARK})", 54, str(all_), "-", "-", str(coco), str(others)]
        for method, all_, coco, others in paper_figures.RETRIEVAL
    ]
    for method, answers in (
        ("vizbot, default", default),
        ("vizbot, the most similar element, as in the paper", _by_paper_rule(default)),
    ):
        right = precision(answers)
        coco = precision([answer for answer in answers if answer.text in IN_COCO])
        others = precision([answer for answer in answers if answer.text not in IN_COCO])
        rows.append(
            [method, right.trials, right, interval_text(right), _over_homes(answers), coco, others]
        )  # fmt: skip
    header = ("method", "queries", "P@1", "95 % (Wilson)", "95 % over homes", "in COCO", "others")
    return markdown_table(header, rows)


def _scales_table(answers: Sequence[QueryResult]) -> str:
    rows = []
    for scales, _, success in paper_figures.SCALES:
        of_scales = _of_scales(answers, scales)
        row: list[object] = [scale_set_text(scales)]
        for by_rule in (of_scales, _by_paper_rule(of_scales)):
            right = precision(by_rule)
            row += [right, interval_text(right), _over_homes(by_rule)]
        rows.append([*row, str(success)])
    header = ("scales", "P@1, the robot's answer", "95 % (Wilson)", "95 % over homes",
              "P@1, the most similar", "95 % (Wilson)", "95 % over homes",
              f"success of navigation ({paper_figures.HEAD})")  # fmt: skip
    return markdown_table(header, rows)


def _thresholds(default: Sequence[QueryResult]) -> str:
    """A table of answers above thresholds; the paper's map always answers."""
    rows = []
    for share in _SHARES:
        exist = [answer for answer in default if answer.exists]
        absent = [answer for answer in default if not answer.exists]
        rows.append(
            [f"{share:.0%} of the default",
             fraction_text(precision([answer for answer in exist if _is_answered(answer, share)])),
             fraction_text(Rate.over(_is_answered(answer, share) for answer in exist)),
             fraction_text(Rate.over(_is_answered(answer, share) for answer in absent))]
        )  # fmt: skip
    header = ("threshold", "right of what is answered", "answered of what exists",
              "answered of what does not exist")  # fmt: skip
    return markdown_table(header, rows)


def _is_answered(answer: QueryResult, share: float) -> bool:
    believed = answer.believed
    score = answer.similarity if believed is None else believed.probability
    return score > share * answer.threshold


def _reliability(answers: Sequence[QueryResult]) -> str:
    """A table of the probabilities of first answers by belief, and how many are right."""
    rows: list[list[object]] = []
    for low, high in pairwise(_PROBABILITIES):
        judged = [(p, right) for p, right in _judged(answers) if low <= p < high]
        if judged:
            mean = sum(p for p, _ in judged) / len(judged)
            right = fraction_text(Rate.over(right for _, right in judged))
            rows.append([f"{low:.1f} to {min(high, 1.0):.1f}", f"{mean:.2f}", right])
    header = ("probability of the first answer", "mean", "right, of all that was asked")
    return markdown_table(header, rows) if rows else ""


def _explorations(explorations: Sequence[ExplorationResult]) -> str:
    """A table of the explorations; a map cannot find what was never seen."""
    of_home = {each.home: each for each in explorations}
    rows = [
        [f"home {home}", of_home[home].steps,
         "explored" if of_home[home].explored else "cut off", of_home[home].reason]
        for home in sorted(of_home)
    ]  # fmt: skip
    return markdown_table(("exploration", "steps", "ended", "why"), rows) if rows else ""


def _exploration_line(job: HomeToAsk, result: tuple[ExplorationResult, list[QueryResult]]) -> str:
    exploration, answers = result
    return f"home {job.home}: {exploration.steps} steps, {len(answers)} questions"
