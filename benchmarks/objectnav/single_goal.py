"""`vizbot bench objectnav`: the paper's object-goal navigation (section IV-C)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from benchmarks.episodes.episode import Episode, EpisodeResult, HomeGoals, Variant
from benchmarks.episodes.oracles import ORACLES
from benchmarks.episodes.run import LAST, RADIUS
from benchmarks.harness.bench_plan import (
    ABLATION_ROWS,
    ENCODER_ROWS,
    ONLY_ASKED_FOR,
    PAPER,
    PERFECT_STOP,
    BenchPlan,
    BenchResult,
    Job,
    goals_of_homes,
    run_missing,
)
from benchmarks.harness.scores import NavigationScore, Rate
from benchmarks.harness.tables import (
    fraction_text,
    interval_text,
    markdown_table,
    percent,
    percent_range,
    scale_set_text,
)
from benchmarks.objectnav import paper_figures
from benchmarks.objectnav.scale_comparison import ScaleComparison
from vizbot.config import Config, with_method

NAME = "objectnav"
DEFAULT = "default"
SCALES = (1, 0, -1)
"""Scales that are driven singly on the same episodes."""
QUICK_SHARE_OF, _ABLATED_SHARE = 3, 5
"""One of so many goals of each home is driven in a quick run, and without a part of the search."""
_ROOMS = (
    "Driven and shortest are mean lengths of the paths of successes, and of the shortest paths "
    "from the same starts. A step is one decision, with one embedded frame and at most "
    "0.25 m or 30 degrees of motion. A start is over 3 m from everything that is asked for and "
    "outside of the room "
    "asked for, over 3 m from its floor as well where the home has such a place, else over 1.5 m."
    " Nobody stands beside the robot: at an edge it backs off by itself."
    " SPL holds the way to a room against the shortest one that ends on its floor, though who "
    "looks into it from within 1.0 m has arrived as well: for rooms it is a little too high."
)

Results = Mapping[str, Sequence[EpisodeResult]]
"""Results of the variants, by name."""


def run_single_goal(plan: BenchPlan) -> BenchResult:
    """Run what is missing and print the tables."""
    homes = [replace(home, goals=home.goals[: plan.goals]) for home in goals_of_homes(plan)]
    episodes = single_goal_episodes(homes, QUICK_SHARE_OF if plan.quick else 1)
    few = single_goal_episodes(homes, _ABLATED_SHARE)
    wanted = [variant for variant in variants(plan.config) if plan.includes(variant.name)]
    without = [v for v in wanted if v.oracle is None]
    with_oracle = [v for v in wanted if v.oracle is not None]
    default = next(v for v in variants(plan.config) if v.name == DEFAULT)
    if with_oracle and default not in without:
        without.insert(0, default)  # it decides which episodes the oracles repeat
    jobs = [(v, e) for v in without for e in (episodes if v.ablated is None else few)]
    results = _by_name(run_missing(plan, NAME, jobs))
    if with_oracle:
        unseeded = any(isinstance(home, str) for home in plan.seeds)  # few goals: all are paired
        all_of_them = plan.quick or unseeded
        repeated = episodes if all_of_them else failed_and_as_many(results[DEFAULT])
        results |= _by_name(
            run_missing(plan, NAME, [(v, e) for v in with_oracle for e in repeated])
        )
    note = ""
    if plan.quick:
        note = "The quick share, every third goal of homes of development: no claim."
    if plan.quick and plan.homes is not None:
        note = "Every third goal of these homes."
    if plan.goals is not None:
        note = f"The first {plan.goals} goals of each home."
    return single_goal_result(results, note)


def single_goal_episodes(homes: Sequence[HomeGoals], share: int = 1) -> list[Episode]:
    """One episode for each goal that exists in each home, or for one of so many goals of each.

    Each home begins at another goal, so that all goals of the paper get their turn.
    """
    return [
        Episode(home.home, (goal,))
        for number, home in enumerate(homes)
        for goal in home.goals[number % share :: share]
    ]


def variants(config: Config) -> tuple[Variant, ...]:
    """The rows.

    As configured, each scale, the paper's method, others' cosines, without parts, oracles, and the
    truth about when to stop.
    """
    paper = Variant(PAPER, with_method(config, "paper"))
    single = (Variant(f"scale {scale}", with_scales(config, (scale,))) for scale in SCALES)
    true = (Variant(f"true {part}", config, part) for part in ORACLES)
    others = (Variant(name, config, encoder_scale=scale) for scale, name in ENCODER_ROWS.items())
    fewer = (Variant(name, config, ablated=part) for part, name in ABLATION_ROWS.items())
    stop = Variant(PERFECT_STOP, config, "stop")
    return (Variant(DEFAULT, config), *single, paper, *others, *fewer, *true, stop)


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


def single_goal_result(results: Results, note: str = "") -> BenchResult:
    """Rows, summary and tables of these results, which a note may stand before."""
    scores = {name: NavigationScore.from_results(rows) for name, rows in results.items() if rows}
    rows: list[dict[str, object]] = [_row(name, score) for name, score in scores.items()]
    rows += [
        {"row": method, "source": paper_figures.MARK, "success_rate": all_ / 100,
         "coco_success_rate": coco / 100, "others_success_rate": others / 100}
        for method, all_, coco, others in paper_figures.OBJECT_NAVIGATION
    ]  # fmt: skip
    compared = _scale_comparison(results)
    summary: dict[str, object] = {}
    headline = next((row for row in (DEFAULT, *ONLY_ASKED_FOR) if row in scores), None)
    if headline is not None:
        best = _row(headline, scores[headline])
        keys = ("episodes", "success_rate", "success_low", "success_high", "others",
                "others_success_rate", "spl", "false_claims", "stuck")  # fmt: skip
        summary = {key: best[key] for key in keys} | {"steps_mean": best["steps"]}
    if DEFAULT in scores:
        summary |= compared.summary() | {
            "single_scale_episodes": compared.three.trials,
            "single_scale_success_rate": compared.best_single,
            "three_scale_success_rate": compared.three.value,
        }
    parts = [
        _main_table(scores),
        _stuck(results),
        _ROOMS,
        _ablation(scores),
        compared.table("success"),
    ]
    parts.append(oracle_table(results))
    if headline is not None and headline in results:
        parts += [_by_goal(results[headline]), _failures(results[headline])]
    return BenchResult(NAME, rows, summary, "\n\n".join(part for part in (note, *parts) if part))


def _scale_comparison(results: Results) -> ScaleComparison:
    """The default against single scales on the episodes that all have driven."""
    succeeded = {
        name: {result.episode: result.success for result in results.get(name, ())}
        for name in (DEFAULT, *(f"scale {scale}" for scale in SCALES))
    }
    return ScaleComparison.over(succeeded.pop(DEFAULT), succeeded)


def _by_name(results: Mapping[Job, EpisodeResult]) -> dict[str, list[EpisodeResult]]:
    named: dict[str, list[EpisodeResult]] = {}
    for (variant, _), result in results.items():
        named.setdefault(variant.name, []).append(result)
    return named


def _row(name: str, score: NavigationScore) -> dict[str, object]:
    low, high = score.success.interval()
    return {
        "row": name,
        "episodes": score.success.trials,
        "success_rate": score.success.value,
        "success_low": low,
        "success_high": high,
        "coco_success_rate": score.coco.value,
        "others": score.others.trials,
        "others_success_rate": score.others.value,
        "spl": score.spl,
        "false_claims": score.said_wrongly.value,
        "stuck": score.stuck,
        "steps": score.steps,
        "steps_of_successes": score.steps_of_successes,
        "path_of_successes": score.path_of_successes,
        "shortest_path_of_successes": score.shortest_of_successes,
        "collisions": score.collisions,
        "ate_median": score.ate,
    }


def _main_table(scores: Mapping[str, NavigationScore]) -> str:
    header = ("method", "episodes", "SR", "95 % (Wilson)", "95 % over homes", "in COCO", "others",
              "SPL", "stuck", "steps", "steps of successes", "driven [m]", "shortest [m]",
              "collisions", "median ATE [m]")  # fmt: skip
    rows = [
        [f"{method} ({paper_figures.MARK})", 54, str(all_), "-", "-", str(coco), str(others),
         *["-"] * 8]
        for method, all_, coco, others in paper_figures.OBJECT_NAVIGATION
    ]  # fmt: skip
    rows += [
        [f"vizbot, {name}", score.success.trials, score.success, interval_text(score.success),
         percent_range(score.success_over_homes), score.coco, score.others, percent(score.spl),
         score.stuck, _whole(score.steps), _whole(score.steps_of_successes),
         _tenths(score.path_of_successes), _tenths(score.shortest_of_successes),
         score.collisions, score.ate]
        for name, score in scores.items()
        if not _is_true(name)
    ]  # fmt: skip
    return markdown_table(header, rows)


def _stuck(results: Results) -> str:
    """What the column says, and of how many episodes it can say nothing."""
    unknown = [
        r for row in results.values() for r in row if not r.success and r.goals[0].stuck is None
    ]
    said = (
        "Stuck are failed episodes that the robot ended because nothing brought it on, and those"
        f" whose last {LAST} steps before the limit of steps lie within a circle of {RADIUS} m"
        " radius."
    )
    if unknown:
        said += (
            f" Of {len(unknown)} failed ones it is not known: they were driven before it was kept."
        )
    return said


def _ablation(scores: Mapping[str, NavigationScore]) -> str:
    """A table of the paper's scale sets, with our rates where they were driven."""
    driven = {
        variant.config.perception.clip_mapper.scales: variant.name
        for variant in variants(Config())
        if variant.oracle is None and variant.name not in ONLY_ASKED_FOR
    }
    rows = []
    for scales, features, success in paper_figures.SCALES:
        score = scores.get(driven.get(scales, ""))
        ours: list[object] = [None, "-", "-"]
        if score is not None:
            over_homes = percent_range(score.success_over_homes)
            ours = [score.success, interval_text(score.success), over_homes]
        rows.append([scale_set_text(scales), features, str(success), *ours])
    header = ("scales", "features per image", f"SR ({paper_figures.HEAD})", "SR of vizbot",
              "95 % (Wilson)", "95 % over homes")  # fmt: skip
    return markdown_table(header, rows)


def oracle_table(results: Results) -> str:
    """A table of the oracles: which failures succeed with each one, and which successes stay.

    Empty without an episode that both the default row and an oracle drove.
    """
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
        score = NavigationScore.from_results(list(repeated.values()))
        again = [result for episode, result in repeated.items() if not default[episode]]
        kept = [result for episode, result in repeated.items() if default[episode]]
        rows.append(
            [name, score.success.trials, score.success, interval_text(score.success),
             percent(score.spl), _whole(score.steps), _succeeded(again), _succeeded(kept)]
        )  # fmt: skip
    in_all = set.intersection(*(set(repeated) for repeated in true.values()))
    failed = [episode for episode in in_all if not default[episode]]
    mended = sum(any(row[episode].success for row in true.values()) for episode in failed)
    verdict = (
        f"Of {len(failed)} failed episodes that every oracle repeated, {mended} succeed with the"
        " truth about one part or another."
    )
    if fail := len(failed) - mended:
        verdict += (
            f" {fail} fail whichever part is true, which leaves planning and the search itself,"
            " or several parts at once."
        )
    header = ("oracle", "episodes", "SR", "95 % (Wilson)", "SPL", "steps",
              "failed ones that now succeed", "succeeded ones that still do")  # fmt: skip
    return f"{markdown_table(header, rows)}\n\n{verdict}"


def _is_true(row: str) -> bool:
    return row.startswith("true ") or row == PERFECT_STOP


def _by_goal(results: Sequence[EpisodeResult]) -> str:
    goals = list(dict.fromkeys(result.goals[0].text for result in results))
    rows = []
    for text in goals:
        of_goal = [result for result in results if result.goals[0].text == text]
        score = NavigationScore.from_results(of_goal)
        rows.append([text, _succeeded(of_goal), percent(score.spl), _whole(score.steps)])
    return markdown_table(("goal", "succeeded", "SPL", "steps"), rows)


def _failures(results: Sequence[EpisodeResult]) -> str:
    failed = [result for result in results if not result.success]
    if not failed:
        return ""
    rows = [
        [f"home {r.episode.home}, {r.goals[0].text}", r.goals[0].reason, r.goals[0].distance,
         r.goals[0].answer, r.goals[0].steps]
        for r in failed
    ]  # fmt: skip
    return markdown_table(("failed", "why", "distance [m]", "what the robot said", "steps"), rows)


def _succeeded(results: Sequence[EpisodeResult]) -> str:
    return fraction_text(Rate.over(result.success for result in results))


def _whole(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"


def _tenths(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"
