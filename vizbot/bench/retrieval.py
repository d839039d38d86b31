"""`vizbot bench retrieval`: maps of explored homes are asked (paper, offline object retrieval)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from sim_stubs.goals import IN_COCO
from vizbot.bench import fingerprint, paper
from vizbot.bench.board import Board, Outcome, goals_of_homes, results_file
from vizbot.bench.episodes import QueryResult, Variant
from vizbot.bench.exploration import SCALE_SETS, explore_and_ask
from vizbot.bench.objectnav import EPISODES, HOMES, with_scales
from vizbot.bench.scores import Rate
from vizbot.bench.store import Store
from vizbot.bench.tables import interval, named, table
from vizbot.bench.workers import in_parallel

NAME = "retrieval"
MAPS = Path("runs/scoreboard")
"""Where the explored maps are kept; they are too large to be committed."""
_QUICK_HOMES = 2
_SHARES = (0.8, 0.9, 1.0, 1.1, 1.2)
"""Thresholds that are compared, as shares of the default one."""


def run(board: Board) -> Outcome:
    """Explore what is missing, ask, and print the tables."""
    homes = goals_of_homes(board, 0 if board.quick else EPISODES, HOMES)
    seeds = [each.home for each in homes][: _QUICK_HOMES if board.quick else None]
    explorer = Variant("explorer", with_scales(board.config, SCALE_SETS[-1]))
    key = fingerprint.key_of(explorer)
    store = Store(results_file(board.folder, NAME, "queries"), QueryResult)
    asked = {answer.home for answer in store.of(key)}
    jobs = [(explorer.config, s, MAPS / key / f"home-{s}") for s in seeds if s not in asked]
    commit, hardware = fingerprint.commit(), fingerprint.hardware()
    for _, answers in in_parallel(explore_and_ask, jobs, NAME, _described):
        store.add(key, commit, hardware, *answers)
    if board.full:
        store.drop_others(key)
    answers = [answer for answer in store.of(key) if answer.home in seeds]
    scales = board.config.perception.clip_mapper.scales
    return outcome(answers, scales, smoke_test=board.quick)


def outcome(
    answers: Sequence[QueryResult],
    scales: tuple[int, ...],
    smoke_test: bool = False,
) -> Outcome:
    """Everything that is printed about these answers.

    Args:
        answers: To all goals, by all scale sets.
        scales: The default set.
        smoke_test: Whether only a part was run.
    """
    default = [answer for answer in answers if answer.scales == scales]
    rows: list[dict[str, object]] = [
        {"row": named(each), "scales": list(each)} | _rates(_of_scales(answers, each))
        for each in SCALE_SETS
    ]
    rows += [
        {"row": method, "source": paper.MARK, "precision_at_1": all_ / 100,
         "coco_precision_at_1": coco / 100, "others_precision_at_1": others / 100}
        for method, all_, coco, others in paper.RETRIEVAL
    ]  # fmt: skip
    right = precision(default)
    low, high = right.interval()
    summary: dict[str, object] = {
        "queries": right.of,
        "precision_at_1": right.value,
        "precision_low": low,
        "precision_high": high,
    }
    parts = [_main_table(default), _scales_table(answers), _thresholds(default)]
    if smoke_test:
        parts.insert(0, "A smoke test on a part of the homes: no claim.")
    return Outcome(NAME, rows, summary, "\n\n".join(parts))


def precision(answers: Sequence[QueryResult]) -> Rate:
    """How many questions for what exists have the right best answer."""
    return Rate.over(answer.correct for answer in answers if answer.exists)


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
        [f"{method} ({paper.MARK})", 54, str(all_), "-", str(coco), str(others)]
        for method, all_, coco, others in paper.RETRIEVAL
    ]
    right = precision(default)
    coco = precision([answer for answer in default if answer.text in IN_COCO])
    others = precision([answer for answer in default if answer.text not in IN_COCO])
    rows.append(["vizbot, default", right.of, right, interval(right), coco, others])
    return table(("method", "queries", "P@1", "95 %", "in COCO", "others"), rows)


def _scales_table(answers: Sequence[QueryResult]) -> str:
    rows = [
        [named(scales), right := precision(_of_scales(answers, scales)), interval(right),
         str(success)]
        for scales, _, success in paper.SCALES
    ]  # fmt: skip
    return table(("scales", "P@1", "95 %", f"success of navigation ({paper.MARK})"), rows)


def _thresholds(default: Sequence[QueryResult]) -> str:
    """What a map that may say "not here" answers: the paper's map always answers."""
    rows = []
    for share in _SHARES:
        exist = [answer for answer in default if answer.exists]
        absent = [answer for answer in default if not answer.exists]
        rows.append(
            [f"{share:.0%} of the default",
             precision([answer for answer in exist if _is_answered(answer, share)]),
             Rate.over(_is_answered(answer, share) for answer in exist),
             Rate.over(_is_answered(answer, share) for answer in absent)]
        )  # fmt: skip
    header = ("threshold", "P@1 of what is answered", "answered of what exists",
              "answered of what does not exist")  # fmt: skip
    return table(header, rows)


def _is_answered(answer: QueryResult, share: float) -> bool:
    return answer.similarity > share * answer.threshold


def _described(job: tuple[object, int, Path], answers: Sequence[QueryResult]) -> str:
    return f"home {job[1]}: {len(answers)} questions"
