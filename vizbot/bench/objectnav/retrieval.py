"""`vizbot bench retrieval`: maps of explored homes are asked (paper, offline object retrieval)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from sim_stubs.scoring.goals import IN_COCO
from vizbot.bench.episodes.episode import ExplorationResult, QueryResult, Variant
from vizbot.bench.episodes.exploration import SCALE_SETS, explore_and_ask
from vizbot.bench.harness.board import (
    BenchPlan,
    BenchResult,
    goals_of_homes,
    require_unchanged,
    results_file,
)
from vizbot.bench.harness.scores import Rate
from vizbot.bench.harness.store import Store
from vizbot.bench.harness.tables import counted, interval, named, table
from vizbot.bench.harness.workers import in_parallel
from vizbot.bench.objectnav import paper_figures
from vizbot.bench.objectnav.single_goal import EPISODES, HOMES, with_scales

NAME = "retrieval"
MAPS = Path("runs/scoreboard")
"""Where the explored maps are kept; they are too large to be committed."""
_QUICK_HOMES = 2
_SHARES = (0.8, 0.9, 1.0, 1.1, 1.2)
"""Thresholds that are compared, as shares of the default one."""


def run(board: BenchPlan) -> BenchResult:
    """Explore what is missing, ask, and print the tables."""
    homes = goals_of_homes(board, 0 if board.quick else EPISODES, HOMES)
    seeds = [each.home for each in homes][: _QUICK_HOMES if board.quick else None]
    require_unchanged(board)
    explorer = Variant("explorer", with_scales(board.config, SCALE_SETS[-1]))
    made = board.made
    key = made.key_of(explorer)
    explorations, queries = stores(board.folder)
    asked = {answer.home for answer in queries.of(key)}
    jobs = [(explorer.config, s, MAPS / key / f"home-{s}") for s in seeds if s not in asked]
    for _, (exploration, answers) in in_parallel(explore_and_ask, jobs, NAME, _described):
        explorations.add(key, made.commit, made.hardware, exploration)
        queries.add(key, made.commit, made.hardware, *answers)
    if board.full:
        explorations.drop_others(key)
        queries.drop_others(key)
    return outcome(
        [answer for answer in queries.of(key) if answer.home in seeds],
        board.config.perception.clip_mapper.scales,
        [exploration for exploration in explorations.of(key) if exploration.home in seeds],
        smoke_test=board.quick,
    )


def stores(folder: Path) -> tuple[Store[ExplorationResult], Store[QueryResult]]:
    """What is kept: how the explorations ended, and the answers of their maps."""
    return (
        Store(results_file(folder, NAME, "explorations"), ExplorationResult),
        Store(results_file(folder, NAME, "queries"), QueryResult),
    )


def outcome(
    answers: Sequence[QueryResult],
    scales: tuple[int, ...],
    explorations: Sequence[ExplorationResult] = (),
    smoke_test: bool = False,
) -> BenchResult:
    """Everything that is printed about these answers.

    Args:
        answers: To all goals, by all scale sets.
        scales: The default set.
        explorations: Of the maps that were asked.
        smoke_test: Whether only a part was run.
    """
    default = [answer for answer in answers if answer.scales == scales]
    rows: list[dict[str, object]] = [
        {"row": named(each), "scales": list(each)} | _rates(_of_scales(answers, each))
        for each in SCALE_SETS
    ]
    rows += [
        {"row": method, "source": paper_figures.MARK, "precision_at_1": all_ / 100,
         "coco_precision_at_1": coco / 100, "others_precision_at_1": others / 100}
        for method, all_, coco, others in paper_figures.RETRIEVAL
    ]  # fmt: skip
    right = precision(default)
    low, high = right.interval()
    singles = [precision(_of_scales(answers, (scale,))).value for scale in scales]
    summary: dict[str, object] = {
        "queries": right.of,
        "precision_at_1": right.value,
        "precision_low": low,
        "precision_high": high,
        "most_similar_precision_at_1": precision(_by_the_paper(default)).value,
        "single_scale_precision_at_1": max((v for v in singles if v is not None), default=None),
    }
    parts = [_main_table(default), _scales_table(answers), _thresholds(default)]
    parts.append(_explorations(explorations))
    if smoke_test:
        parts.insert(0, "A smoke test on a part of the homes: no claim.")
    return BenchResult(NAME, rows, summary, "\n\n".join(part for part in parts if part))


def precision(answers: Sequence[QueryResult]) -> Rate:
    """How many questions for what exists have the right best answer."""
    return Rate.over(answer.correct for answer in answers if answer.exists)


def _by_the_paper(answers: Sequence[QueryResult]) -> list[QueryResult]:
    """The same questions, answered by the most similar element alone."""
    return [replace(answer, correct=answer.most_similar_correct) for answer in answers]


def _rates(answers: Sequence[QueryResult]) -> dict[str, object]:
    coco = [answer for answer in answers if answer.text in IN_COCO]
    others = [answer for answer in answers if answer.text not in IN_COCO]
    return {
        "queries": precision(answers).of,
        "precision_at_1": precision(answers).value,
        "coco_precision_at_1": precision(coco).value,
        "others_precision_at_1": precision(others).value,
    }


def _of_scales(answers: Sequence[QueryResult], scales: tuple[int, ...]) -> list[QueryResult]:
    return [answer for answer in answers if answer.scales == scales]


def _main_table(default: Sequence[QueryResult]) -> str:
    rows: list[list[object]] = [
        [f"{method} ({paper_figures.MARK})", 54, str(all_), "-", str(coco), str(others)]
        for method, all_, coco, others in paper_figures.RETRIEVAL
    ]
    for method, answers in (
        ("vizbot, default: where views agree", default),
        ("vizbot, the most similar element, as in the paper", _by_the_paper(default)),
    ):
        right = precision(answers)
        coco = precision([answer for answer in answers if answer.text in IN_COCO])
        others = precision([answer for answer in answers if answer.text not in IN_COCO])
        rows.append([method, right.of, right, interval(right), coco, others])
    return table(("method", "queries", "P@1", "95 %", "in COCO", "others"), rows)


def _scales_table(answers: Sequence[QueryResult]) -> str:
    rows = []
    for scales, _, success in paper_figures.SCALES:
        of_scales = _of_scales(answers, scales)
        right, alone = precision(of_scales), precision(_by_the_paper(of_scales))
        rows.append(
            [named(scales), right, interval(right), alone, interval(alone), str(success)]
        )  # fmt: skip
    header = ("scales", "P@1, where views agree", "95 %", "P@1, the most similar", "95 %",
              f"success of navigation ({paper_figures.MARK})")  # fmt: skip
    return table(header, rows)


def _thresholds(default: Sequence[QueryResult]) -> str:
    """What a map that may say "not here" answers: the paper's map always answers."""
    rows = []
    for share in _SHARES:
        exist = [answer for answer in default if answer.exists]
        absent = [answer for answer in default if not answer.exists]
        rows.append(
            [f"{share:.0%} of the default",
             counted(precision([answer for answer in exist if _is_answered(answer, share)])),
             counted(Rate.over(_is_answered(answer, share) for answer in exist)),
             counted(Rate.over(_is_answered(answer, share) for answer in absent))]
        )  # fmt: skip
    header = ("threshold", "right of what is answered", "answered of what exists",
              "answered of what does not exist")  # fmt: skip
    return table(header, rows)


def _is_answered(answer: QueryResult, share: float) -> bool:
    return answer.similarity > share * answer.threshold


def _explorations(explorations: Sequence[ExplorationResult]) -> str:
    """How the homes were explored; what was never seen cannot be found."""
    of_home = {each.home: each for each in explorations}
    rows = [
        [f"home {home}", of_home[home].steps,
         "explored" if of_home[home].explored else "cut off", of_home[home].reason]
        for home in sorted(of_home)
    ]  # fmt: skip
    return table(("exploration", "steps", "ended", "why"), rows) if rows else ""


def _described(
    job: tuple[object, int, Path], result: tuple[ExplorationResult, list[QueryResult]]
) -> str:
    exploration, answers = result
    return f"home {job[1]}: {exploration.steps} steps, {len(answers)} questions"
