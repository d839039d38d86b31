"""`vizbot bench objectnav`: the paper's object-goal navigation (section IV-C)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from vizbot.bench.episodes.episode import Episode, EpisodeResult, HomeGoals, Variant
from vizbot.bench.episodes.oracles import COUNTERPARTS
from vizbot.bench.harness.board import BenchPlan, BenchResult, Job, goals_of_homes, run_missing
from vizbot.bench.harness.scores import NavigationScore, Rate
from vizbot.bench.harness.tables import counted, interval, named, percent, table
from vizbot.bench.objectnav import paper_figures
from vizbot.config import Config

NAME = "objectnav"
EPISODES, HOMES = 54, 4
"""At least so many (paper, section IV-C)."""
DEFAULT = "default"
SCALES = (1, 0, -1)
"""Driven singly on the same episodes."""
_QUICK_SHARE = 3
_ROOMS = (
    "A step is one run of Algorithm 1, with one embedded frame and at most 0.25 m or 30 degrees "
    "of motion. A start is over 3 m from everything that is asked for and outside of the room "
    "asked for, over 3 m from its floor as well where the home has such a place, else over 1.5 m."
    " Nobody stands beside the robot: at an edge it backs off by itself (`resume_safe`)."
    " SPL holds the way to a room against the shortest one that ends on its floor, though who "
    "looks into it from within 1.0 m has arrived as well: for rooms it is a little too high."
)

Results = Mapping[str, Sequence[EpisodeResult]]
"""Of the variants, by name."""


def run(board: BenchPlan) -> BenchResult:
    """Run what is missing and print the tables."""
    homes = goals_of_homes(board, 0 if board.quick else EPISODES, HOMES)
    episodes = episodes_in(homes, board.quick)
    wanted = [variant for variant in variants(board.config) if board.takes(variant.name)]
    driven = [v for v in wanted if v.counterpart is None]
    true = [v for v in wanted if v.counterpart is not None]
    default = next(v for v in variants(board.config) if v.name == DEFAULT)
    if true and default not in driven:
        driven.insert(0, default)  # it tells which episodes to repeat
    results = _by_name(run_missing(board, NAME, [(v, e) for v in driven for e in episodes]))
    if true:
        repeated = failed_and_as_many(results[DEFAULT])
        results |= _by_name(run_missing(board, NAME, [(v, e) for v in true for e in repeated]))
    return outcome(results, smoke_test=board.quick)


def episodes_in(homes: Sequence[HomeGoals], quick: bool = False) -> list[Episode]:
    """One for each goal that exists in each home.

    When quick, a third of each home's: each home begins at another one, so that all goals of the
    paper get their turn.
    """
    share = _QUICK_SHARE if quick else 1
    return [
        Episode(home.home, (goal,))
        for number, home in enumerate(homes)
        for goal in home.goals[number % share :: share]
    ]


def variants(config: Config) -> tuple[Variant, ...]:
    """The rows: as configured, each scale singly, each part switched to the truth."""
    single = (Variant(f"scale {scale}", with_scales(config, (scale,))) for scale in SCALES)
    true = (Variant(f"true {part}", config, part) for part in COUNTERPARTS)
    return (Variant(DEFAULT, config), *single, *true)


def with_scales(config: Config, scales: tuple[int, ...]) -> Config:
    """The same robot with patches of these scales."""
    mapper = config.perception.clip_mapper.model_copy(update={"scales": scales})
    perception = config.perception.model_copy(update={"clip_mapper": mapper})
    return config.model_copy(update={"perception": perception})


def failed_and_as_many(results: Sequence[EpisodeResult]) -> list[Episode]:
    """The episodes that failed and as many, or all, that succeeded, drawn by a fixed seed."""
    failed = [result.episode for result in results if not result.success]
    succeeded = [result.episode for result in results if result.success]
    count = min(len(failed), len(succeeded))
    drawn = np.random.default_rng(0).choice(len(succeeded), count, replace=False)
    return failed + [succeeded[i] for i in sorted(drawn)]


def outcome(results: Results, smoke_test: bool = False) -> BenchResult:
    """Everything that is printed about these results."""
    scores = {name: NavigationScore.of(rows) for name, rows in results.items() if rows}
    rows: list[dict[str, object]] = [_row(name, score) for name, score in scores.items()]
    rows += [
        {"row": method, "source": paper_figures.MARK, "success_rate": all_ / 100,
         "coco_success_rate": coco / 100, "others_success_rate": others / 100}
        for method, all_, coco, others in paper_figures.OBJECT_NAVIGATION
    ]  # fmt: skip
    summary: dict[str, object] = {}
    if DEFAULT in scores:
        best = _row(DEFAULT, scores[DEFAULT])
        keys = ("episodes", "success_rate", "success_low", "success_high", "others",
                "others_success_rate", "spl")  # fmt: skip
        summary = {key: best[key] for key in keys} | _against_single_scales(results)
    parts = [_main_table(scores), _ROOMS, _ablation(scores), _counterparts(results)]
    if DEFAULT in results:
        parts += [_by_goal(results[DEFAULT]), _failures(results[DEFAULT])]
    if smoke_test:
        parts.insert(0, "A smoke test on a part of the episodes: no claim.")
    return BenchResult(NAME, rows, summary, "\n\n".join(part for part in parts if part))


def _against_single_scales(results: Results) -> dict[str, object]:
    """Success of the default and of the best single scale on the episodes that all have driven."""
    singles = [f"scale {scale}" for scale in SCALES]
    succeeded = {
        name: {result.episode: result.success for result in results.get(name, ())}
        for name in (DEFAULT, *singles)
    }
    common = set.intersection(*(set(of_row) for of_row in succeeded.values()))
    rates = {
        name: Rate.over(of_row[episode] for episode in common).value
        for name, of_row in succeeded.items()
    }
    best = max((rate for name in singles if (rate := rates[name]) is not None), default=None)
    return {
        "single_scale_episodes": len(common),
        "single_scale_success_rate": best,
        "three_scale_success_rate": rates[DEFAULT],
    }


def _by_name(results: Mapping[Job, EpisodeResult]) -> dict[str, list[EpisodeResult]]:
    named: dict[str, list[EpisodeResult]] = {}
    for (variant, _), result in results.items():
        named.setdefault(variant.name, []).append(result)
    return named


def _row(name: str, score: NavigationScore) -> dict[str, object]:
    low, high = score.success.interval()
    return {
        "row": name,
        "episodes": score.success.of,
        "success_rate": score.success.value,
        "success_low": low,
        "success_high": high,
        "coco_success_rate": score.coco.value,
        "others": score.others.of,
        "others_success_rate": score.others.value,
        "spl": score.spl,
        "steps": score.steps,
        "steps_of_successes": score.steps_of_successes,
        "collisions": score.collisions,
        "ate_median": score.ate,
    }


def _main_table(scores: Mapping[str, NavigationScore]) -> str:
    header = ("method", "episodes", "SR", "95 %", "in COCO", "others", "SPL", "steps",
              "steps of successes", "collisions", "median ATE [m]")  # fmt: skip
    rows = [
        [f"{method} ({paper_figures.MARK})", 54, str(all_), "-", str(coco), str(others), *["-"] * 5]
        for method, all_, coco, others in paper_figures.OBJECT_NAVIGATION
    ]
    rows += [
        [f"vizbot, {name}", score.success.of, score.success, interval(score.success), score.coco,
         score.others, percent(score.spl), _whole(score.steps), _whole(score.steps_of_successes),
         score.collisions, score.ate]
        for name, score in scores.items()
        if not _is_true(name)
    ]  # fmt: skip
    return table(header, rows)


def _ablation(scores: Mapping[str, NavigationScore]) -> str:
    """The paper's scale sets; ours where they were driven, on the same episodes."""
    driven = {
        variant.config.perception.clip_mapper.scales: variant.name
        for variant in variants(Config())
        if variant.counterpart is None
    }
    rows = []
    for scales, features, success in paper_figures.SCALES:
        score = scores.get(driven.get(scales, ""))
        rate = None if score is None else score.success
        ours = [None, "-"] if rate is None else [rate, interval(rate)]
        rows.append([named(scales), features, str(success), *ours])
    header = ("scales", "features per image", f"SR ({paper_figures.MARK})", "SR of vizbot", "95 %")
    return table(header, rows)


def _counterparts(results: Results) -> str:
    """Which part is to blame: what failed and is mended by the truth, and what stays good."""
    default = {result.episode: result.success for result in results.get(DEFAULT, ())}
    true = {
        name: {result.episode: result for result in rows if result.episode in default}
        for name, rows in results.items()
        if _is_true(name)
    }
    true = {name: repeated for name, repeated in true.items() if repeated}
    if not true:
        return ""
    rows = []
    for name, repeated in true.items():
        score = NavigationScore.of(list(repeated.values()))
        again = [result for episode, result in repeated.items() if not default[episode]]
        kept = [result for episode, result in repeated.items() if default[episode]]
        rows.append(
            [name, score.success.of, score.success, interval(score.success), percent(score.spl),
             _whole(score.steps), _of(again), _of(kept)]
        )  # fmt: skip
    in_all = set.intersection(*(set(repeated) for repeated in true.values()))
    failed = [episode for episode in in_all if not default[episode]]
    mended = sum(any(row[episode].success for row in true.values()) for episode in failed)
    verdict = (
        f"Of {len(failed)} failed episodes that every counterpart repeated, the truth about one"
        f" part mends {mended}; {len(failed) - mended} fail whichever part is true, which leaves"
        " planning and Algorithm 1 itself, or several parts at once."
    )
    header = ("counterpart", "episodes", "SR", "95 %", "SPL", "steps",
              "failed ones that now succeed", "succeeded ones that still do")  # fmt: skip
    return f"{table(header, rows)}\n\n{verdict}"


def _is_true(row: str) -> bool:
    return row.startswith("true ")


def _by_goal(results: Sequence[EpisodeResult]) -> str:
    goals = list(dict.fromkeys(result.goals[0].text for result in results))
    rows = []
    for text in goals:
        of_goal = [result for result in results if result.goals[0].text == text]
        score = NavigationScore.of(of_goal)
        rows.append([text, _of(of_goal), percent(score.spl), _whole(score.steps)])
    return table(("goal", "succeeded", "SPL", "steps"), rows)


def _failures(results: Sequence[EpisodeResult]) -> str:
    failed = [result for result in results if not result.success]
    if not failed:
        return ""
    rows = [
        [f"home {r.episode.home}, {r.goals[0].text}", r.goals[0].reason, r.goals[0].distance,
         r.goals[0].answer, r.goals[0].steps]
        for r in failed
    ]  # fmt: skip
    return table(("failed", "why", "distance [m]", "what the robot said", "steps"), rows)


def _of(results: Sequence[EpisodeResult]) -> str:
    return counted(Rate.over(result.success for result in results))


def _whole(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"
