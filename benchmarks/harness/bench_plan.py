"""The plan of a benchmark, its result, and runs of the episodes that have no result yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.ablations.ablation import ABLATIONS
from benchmarks.episodes.episode import (
    EncoderScale,
    Episode,
    EpisodeResult,
    Home,
    HomeGoals,
    Variant,
)
from benchmarks.episodes.homes import survey
from benchmarks.episodes.run import run_episode
from benchmarks.harness.fingerprint import Fingerprint
from benchmarks.harness.store import Store
from benchmarks.harness.workers import in_parallel
from vizbot.config import Config
from vizbot.core.errors import ConfigError

UNATTENDED = Config.model_validate({"roomba": {"resume_safe": True}})
"""Settings of a robot without an operator: it backs off from an edge and goes on by itself."""
BOARD = tuple(range(1060, 1068))
"""Homes of the board, which are driven whole and in which nothing is developed."""
QUICK_SHARE = tuple(range(1100, 1108))
"""Homes of development, of which a quick run takes a part."""
PAPER = "paper"
"""Name of the row of the paper's method of search."""
PERFECT_STOP = "perfect stop"
"""Name of the row of searches that end where a stop is first a success."""
ENCODER_ROWS: dict[EncoderScale, str] = {
    "clip": "scaled",
    "offset": "offset",
    "unknown": "unknown scale",
}
"""Names of the rows of other encoders' cosines."""
SEARCHED = "by searching"
"""Row of searches for what is not there."""
ABLATION_ROWS = {part: f"without {part}" for part in ABLATIONS}
"""Names of the rows of searches without a part."""
ONLY_ASKED_FOR = (PAPER, *ENCODER_ROWS.values(), SEARCHED, *ABLATION_ROWS.values(), PERFECT_STOP)
"""Rows that are driven only when they are asked for."""
QUICK_SHARE_ROWS = "quick_share"
"""Folder, beside that of the board, with the finished episodes of quick runs."""


@dataclass(frozen=True, slots=True)
class BenchPlan:
    """Which episodes of a benchmark are wanted, with which settings, and where results are kept.

    Attributes:
        config: Settings of the robot.
        folder: Folder of the finished results.
        fingerprint: The sources, weights and homes that the results depend on.
        homes: The homes; None for those of the board or of the quick share.
        quick: Whether only a part of the episodes is run, which may be claimed nowhere.
        rows: Names of the variants; None for all of them.
        goals: Number of goals that are driven in each home, the first ones; None for all.
    """

    config: Config
    folder: Path
    fingerprint: Fingerprint
    homes: tuple[Home, ...] | None = None
    quick: bool = False
    rows: tuple[str, ...] | None = None
    goals: int | None = None

    @property
    def full(self) -> bool:
        """Whether the plan is the whole board, whose figures may be claimed."""
        return self.homes is None and not self.quick and self.goals is None

    @property
    def seeds(self) -> tuple[Home, ...]:
        """The homes, in order."""
        return self.homes or (QUICK_SHARE if self.quick else BOARD)

    def includes(self, row: str) -> bool:
        """Whether the plan has this row; without names a quick plan has only the default one."""
        if self.rows is not None:
            return row in self.rows
        return row == "default" or not (self.quick or row in ONLY_ASKED_FOR)


@dataclass(frozen=True, slots=True)
class BenchResult:
    """What a benchmark prints.

    Attributes:
        name: Name of the benchmark.
        rows: Rows of its tables, for programs.
        summary: Main figures, for programs.
        text: Tables in Markdown, for people.
    """

    name: str
    rows: list[dict[str, object]]
    summary: dict[str, object]
    text: str


Job = tuple[Variant, Episode]


def run_missing(plan: BenchPlan, bench: str, jobs: Sequence[Job]) -> dict[Job, EpisodeResult]:
    """Return the result of every job, in the order of `jobs`; run those that have none yet.

    Raises:
        ConfigError: the sources have changed since the benchmark began.
    """
    require_unchanged(plan)
    stores, keys = {}, {}
    done: dict[tuple[str, Episode], EpisodeResult] = {}
    for variant in {job[0].name: job[0] for job in jobs}.values():
        store = Store(results_file(plan.folder, bench, variant.name), EpisodeResult)
        stores[variant.name], keys[variant.name] = store, plan.fingerprint.key_of(variant)
        for result in store.results_with_key(keys[variant.name]):
            done[variant.name, result.episode] = result
    missing = [job for job in jobs if (job[0].name, job[1]) not in done]
    for (variant, episode), result in in_parallel(run_episode, missing, bench, _episode_line):
        key = keys[variant.name]
        stores[variant.name].add(key, plan.fingerprint.commit, plan.fingerprint.hardware, result)
        done[variant.name, episode] = result
    if plan.full:
        for name, store in stores.items():
            store.drop_others(keys[name])
    return {job: done[job[0].name, job[1]] for job in jobs}


def require_unchanged(plan: BenchPlan) -> None:
    """Check that the sources are still those of the plan, because new processes load them anew.

    Raises:
        ConfigError: the sources have changed.
    """
    if not plan.fingerprint.still_holds():
        raise ConfigError(
            "sources or weights have changed since the bench began; run it again: what is finished"
            " is kept"
        )


def results_file(folder: Path, bench: str, row: str) -> Path:
    """The file that holds the results of a row."""
    return folder / f"{bench}-{row.replace(' ', '-')}.jsonl"


def goals_of_homes(plan: BenchPlan, count: int | None = None) -> list[HomeGoals]:
    """The homes of a plan in order, the first `count` or all, and the goals that exist in them."""
    seeds = plan.seeds[:count]
    store = Store(plan.folder / "homes.jsonl", HomeGoals)
    known = {each.home: each for each in store.results_with_key(plan.fingerprint.homes)}
    missing = [seed for seed in seeds if seed not in known]
    for seed, goals in in_parallel(survey, missing, "homes", _survey_line):
        store.add(plan.fingerprint.homes, plan.fingerprint.commit, plan.fingerprint.hardware, goals)
        known[seed] = goals
    return [known[seed] for seed in seeds]


def _episode_line(job: Job, result: EpisodeResult) -> str:
    variant, episode = job
    goals = ", ".join(
        f"{goal.text}: {goal.reason or 'success'} in {goal.steps} steps" for goal in result.goals
    )
    return f"{variant.name}, home {episode.home}: {goals} ({result.wall_seconds:.0f} s)"


def _survey_line(seed: Home, goals: HomeGoals) -> str:
    return f"home {seed}: {len(goals.goals)} goals"
