"""`vizbot bench objectnav --fast`: rules of the search compared in the fast world.

It is for development and for no figure: two thirds of its homes are to tune in, a third to report
on, and all are homes of development.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.ablations.ablation import ABLATIONS
from benchmarks.episodes.episode import EncoderScale, Episode, EpisodeResult, HomeGoals
from benchmarks.episodes.run import encoder_of
from benchmarks.fast_world.walk import FastHome, SearchRule, Walk
from benchmarks.harness.bench_plan import (
    ABLATION_ROWS,
    QUICK_SHARE,
    BenchPlan,
    BenchResult,
    goals_of_homes,
)
from benchmarks.harness.fingerprint import key_of_robot, key_of_settings, key_of_sources
from benchmarks.harness.scores import NavigationScore, interval_over_homes, spl
from benchmarks.harness.store import Store
from benchmarks.harness.tables import markdown_table
from benchmarks.harness.workers import in_parallel
from benchmarks.objectnav.single_goal import QUICK_SHARE_OF, single_goal_episodes
from vizbot.config import Config, with_method
from vizbot.objectnav.search_parts import ALL_PARTS

NAME = "objectnav --fast"
TUNING, REPORTING = tuple(range(1100, 1108)), tuple(range(1108, 1112))
"""Homes in which rules may be tuned, and homes that say what came of it."""
DEVELOPMENT = (range(1000), range(1100, 1200), (7305,))
"""Homes of development; all others are boards, which the fast world does not enter. In 7305 a bare
wall once held searches for ever."""
DEFAULT = "default"
_VIEWS = (
    "sim_stubs",
    "mapping/clip/places/footprint.py",
    "mapping/clip/mapper.py",
    "mapping/clip/patches.py",
    "mapping/occupancy/planar_scan.py",
    "vizbot/rehearsal/belief_fit/places.py",
    "vizbot/rehearsal/belief_fit/views.py",
)
"""Sources that can change a view."""
_NO_CLAIM = "The fast world: true poses, pictures made before. For development, never for a figure."


@dataclass(frozen=True, slots=True)
class _Job:
    """All episodes of a rule in a home that have no result yet."""

    rule: SearchRule
    episodes: tuple[Episode, ...]
    views: Path
    scale: EncoderScale | None


def rules(config: Config) -> tuple[SearchRule, ...]:
    """The rows: as configured, by the paper's method, and without each part."""
    without = [SearchRule(ABLATION_ROWS[part], config, ABLATIONS[part])
               for part in ABLATIONS]  # fmt: skip
    return (
        SearchRule(DEFAULT, config),
        SearchRule("paper", with_method(config, "paper")),
        *without,
    )


def is_of_development(home: int) -> bool:
    """Whether rules may be tried in this home."""
    return any(home in homes for homes in DEVELOPMENT)


def run_fast(plan: BenchPlan, scale: EncoderScale | None = None) -> BenchResult:
    """Walk the episodes that have no result yet, and print the tables.

    Args:
        plan: Its homes; without them those to tune in and to report on. Where it is quick, the
            episodes of the quick share, so that a rule can be compared with the whole loop. Its
            rows; without them all but those without a part of the search.
        scale: Of the encoder's cosines; None for its own.
    """
    homes = plan.homes or (QUICK_SHARE if plan.quick else (*TUNING, *REPORTING))
    goals = goals_of_homes(BenchPlan(plan.config, plan.folder, plan.fingerprint, homes))
    chosen = [
        rule
        for rule in rules(plan.config)
        if (rule.parts == ALL_PARTS if plan.rows is None else rule.name in plan.rows)
    ]
    episodes = single_goal_episodes(goals, QUICK_SHARE_OF) if plan.quick else episodes_of(goals)
    results = {rule.name: _run_missing(rule, episodes, plan, scale) for rule in chosen}
    return fast_result(results)


def episodes_of(homes: Sequence[HomeGoals]) -> list[Episode]:
    """Every goal of every home."""
    return [Episode(home.home, (goal,)) for home in homes for goal in home.goals]


def _run_missing(
    rule: SearchRule, episodes: Sequence[Episode], plan: BenchPlan, scale: EncoderScale | None
) -> list[EpisodeResult]:
    name = "-".join(["fast", *rule.name.split(), *([scale] if scale else [])])
    store = Store(plan.folder / f"{name}.jsonl", EpisodeResult)
    key = "-".join(
        (
            key_of_robot("benchmarks/episodes", "benchmarks/fast_world"),
            key_of_settings(rule.config),
        )
    )
    done = {result.episode: result for result in store.results_with_key(key)}
    by_home: dict[object, list[Episode]] = {}
    for episode in episodes:
        if episode not in done:
            by_home.setdefault(episode.home, []).append(episode)
    encoder = encoder_of(rule.config).model_id
    views = plan.folder / "views" / f"{encoder}-{_key_of_views(rule.config)}".replace("/", "_")
    jobs = [_Job(rule, tuple(each), views, scale) for each in by_home.values()]
    for _, walked in in_parallel(_walk_home, jobs, f"fast, {rule.name}", _home_line):
        for result in walked:
            store.add(key, plan.fingerprint.commit, plan.fingerprint.hardware, result)
            done[result.episode] = result
    return [done[episode] for episode in episodes]


def _key_of_views(config: Config) -> str:
    perception = config.perception
    settings = key_of_settings(perception.clip_mapper, perception.depth_mapper.scan, config.mount)
    return f"{key_of_sources(*_VIEWS)}-{settings}"


def _walk_home(job: _Job) -> list[EpisodeResult]:
    """Walk the episodes of one home."""
    config, home = job.rule.config, job.episodes[0].home
    assert isinstance(home, int)
    with FastHome(home, config, encoder_of(config), job.views, job.scale) as opened:
        return [Walk(opened, job.rule, episode).run() for episode in job.episodes]


def _home_line(job: _Job, results: Sequence[EpisodeResult]) -> str:
    reached = sum(result.success for result in results)
    seconds = sum(result.wall_seconds for result in results)
    return f"home {job.episodes[0].home}: {reached} of {len(results)} ({seconds:.0f} s)"


def fast_result(results: Mapping[str, Sequence[EpisodeResult]]) -> BenchResult:
    """Rows, summary and tables of these results, by the name of their rule."""
    rows: list[dict[str, object]] = []
    tables = [_NO_CLAIM]
    for title, homes in (("to tune in", TUNING), ("to report on", REPORTING), ("all", None)):
        part = {
            name: {r.episode: r for r in each if homes is None or r.episode.home in homes}
            for name, each in results.items()
        }
        if not any(part.values()):
            continue
        of_part = [_row(title, name, each, part.get(DEFAULT, {})) for name, each in part.items()]
        rows += of_part
        table = markdown_table(list(of_part[0]), [list(row.values()) for row in of_part])
        tables.append(f"## Homes {title}\n\n{table}")
    whole = [row for row in rows if row["homes"] == "all"]
    summary = {
        str(row["row"]): {k: row[k] for k in ("episodes", "success_rate", "spl")} for row in whole
    }
    return BenchResult(NAME, rows, dict(summary), "\n\n".join(tables))


def _row(
    homes: str,
    name: str,
    results: Mapping[Episode, EpisodeResult],
    default: Mapping[Episode, EpisodeResult],
) -> dict[str, object]:
    """A row of the table; `gain` is the difference of SPL to the default row, paired.

    `gain_low` is what it is at least with a probability of 95 %, one-sided, over homes.
    """
    score = NavigationScore.from_results(list(results.values()))
    goals = [result.goals[0] for result in results.values()]
    own = {episode: spl(result.goals) or 0.0 for episode, result in results.items()}
    gains = {each: own[each] - (spl(default[each].goals) or 0.0) for each in own if each in default}
    bounds = interval_over_homes([(k.home, gain) for k, gain in gains.items()], (5.0, 95.0))
    return {
        "row": name,
        "homes": homes,
        "episodes": len(results),
        "success_rate": score.success.value,
        "spl": score.spl,
        "gain": float(np.mean([*gains.values()])) if gains else None,
        "gain_low": bounds and bounds[0],
        "steps": score.steps,
        "way": float(np.mean([goal.path_length for goal in goals])),
        "false_claims": float(np.mean([goal.claimed and not goal.success for goal in goals])),
        "seconds": float(np.mean([result.wall_seconds for result in results.values()])),
    }
