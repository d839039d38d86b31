"""`vizbot bench absent`: saved maps are asked for what is in the home, and for what is not.

The row `by searching` drives: the robot searches for what is not there, and has to end that by a
decision of its own.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.episodes.absent_things import HomeQuestions, ThingAnswer, absent_episodes, ask_home
from benchmarks.episodes.episode import EncoderScale, EpisodeResult, GoalResult, Variant
from benchmarks.harness.bench_plan import (
    ENCODER_ROWS,
    SEARCHED,
    BenchPlan,
    BenchResult,
    require_unchanged,
    results_file,
    run_missing,
)
from benchmarks.harness.scores import Rate, interval_over_homes
from benchmarks.harness.store import Store
from benchmarks.harness.tables import interval_text, markdown_table, percent_range
from benchmarks.harness.workers import in_parallel
from benchmarks.objectnav.retrieval import MAPS, explorer_of
from vizbot.core.observer import Outcome

NAME = "absent"
DEFAULT = "default"
ROWS: Mapping[str, EncoderScale | None] = {
    DEFAULT: None, **{row: scale for scale, row in ENCODER_ROWS.items()}
}  # fmt: skip
"""Rows, and whose cosines the encoder has in them."""
COUNT = 13
"""Questions of each kind to a home: over 100 in the eight homes of a board."""
SEARCHES = 5
"""Searches in a home: 40 in the eight homes of a board."""
_QUICK_HOMES = 2
WORDS = Path(__file__).with_suffix(".toml")
"""What is asked for though it is not there."""


def run_absent(plan: BenchPlan) -> BenchResult:
    """Explore and ask the homes that have no answers yet, and print the table."""
    require_unchanged(plan)
    seeds = [home for home in plan.seeds if isinstance(home, int)]
    seeds = seeds[:_QUICK_HOMES] if plan.quick else seeds
    explorer = explorer_of(plan.config)
    folder = MAPS / plan.fingerprint.key_of(explorer)
    words = tomllib.loads(WORDS.read_text(encoding="utf-8"))
    results: dict[str, list[ThingAnswer]] = {}
    for row, scale in ROWS.items():
        if not plan.includes(row):
            continue
        store = Store(results_file(plan.folder, NAME, row), ThingAnswer)
        key = plan.fingerprint.key_of(Variant(row, explorer.config, encoder_scale=scale))
        asked = {answer.home for answer in store.results_with_key(key)}
        jobs = [
            HomeQuestions(
                explorer.config, scale, seed, folder / f"home-{seed}",
                tuple(words["nowhere"]), tuple(words["elsewhere"]), COUNT,
            )
            for seed in seeds
            if seed not in asked
        ]  # fmt: skip
        for _, answers in in_parallel(ask_home, jobs, f"{NAME}, {row}", _home_line):
            store.add(key, plan.fingerprint.commit, plan.fingerprint.hardware, *answers)
        answers = store.results_with_key(key)
        results[row] = [answer for answer in answers if answer.home in seeds]
    searched: list[EpisodeResult] = []
    if plan.includes(SEARCHED):
        variant = Variant(SEARCHED, plan.config)
        episodes = [
            episode
            for seed in seeds
            for episode in absent_episodes(seed, words["nowhere"], words["elsewhere"], SEARCHES)
        ]
        searched = [*run_missing(plan, NAME, [(variant, each) for each in episodes]).values()]
    return absent_result(results, searched)


def absent_result(
    results: Mapping[str, Sequence[ThingAnswer]], searched: Sequence[EpisodeResult] = ()
) -> BenchResult:
    """Rows, summary and table of the answers of each row.

    The summary is that of the first row; of the searches where no map was asked.
    """
    rows = [{"row": name, **_figures(answers)} for name, answers in results.items()]
    summary = _figures(next(iter(results.values()), ()))
    table = [line for name, answers in results.items() for line in _lines(name, answers)]
    if searched:
        goals = [goal for each in searched for goal in each.goals]
        refused = Rate.over(map(is_refusal, goals))
        if not results:
            summary |= {"asked": refused.trials, "refused": refused.value}
        rows.append({"row": SEARCHED, "asked": refused.trials, "refused": refused.value,
                     "claimed": Rate.over(goal.claimed for goal in goals).value,
                     "steps": float(np.mean([goal.steps for goal in goals]))})  # fmt: skip
        over_homes = interval_over_homes(
            (each.episode.home, is_refusal(goal)) for each in searched for goal in each.goals
        )
        wilson, range_ = interval_text(refused), percent_range(over_homes)
        table.append([SEARCHED, "absent", refused.trials, refused, wilson, range_])
    header = ("row", "asked for", "questions", "right", "95 % (Wilson)", "95 % over homes")
    text = markdown_table(header, table)
    return BenchResult(NAME, rows, summary, text)


def _figures(answers: Sequence[ThingAnswer]) -> dict[str, object]:
    present, absent = found_rate(answers), refused_rate(answers)
    return {
        "asked": absent.trials,
        "present_asked": present.trials,
        "refused": absent.value,
        "found": present.value,
    }


def found_rate(answers: Sequence[ThingAnswer]) -> Rate:
    """How many present things are located at the right place."""
    return Rate.over(a.located and a.correct for a in answers if a.kind == "present")


def refused_rate(answers: Sequence[ThingAnswer]) -> Rate:
    """How many absent things are refused."""
    return Rate.over(not a.located for a in answers if a.kind != "present")


def is_refusal(goal: GoalResult) -> bool:
    """Whether the robot decided that it is not there; running out of steps is no decision."""
    return goal.outcome is Outcome.NOT_FOUND


def _lines(name: str, answers: Sequence[ThingAnswer]) -> list[list[object]]:
    """A line for present things, and one for each kind of absent ones."""
    lines: list[list[object]] = []
    for kind in ("present", "elsewhere", "nowhere"):
        of_kind = [answer for answer in answers if answer.kind == kind]
        right = found_rate(of_kind) if kind == "present" else refused_rate(of_kind)
        over_homes = interval_over_homes(
            (a.home, a.located and a.correct if kind == "present" else not a.located)
            for a in of_kind
        )
        wilson, range_ = interval_text(right), percent_range(over_homes)
        lines.append([name, kind, right.trials, right, wilson, range_])
    return lines


def _home_line(job: HomeQuestions, answers: Sequence[ThingAnswer]) -> str:
    return f"home {job.home}: {len(answers)} questions"
