"""What is to be run and where it is kept: only what is missing is run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vizbot.bench.episodes.episode import Episode, EpisodeResult, HomeGoals, Variant
from vizbot.bench.episodes.homes import FIRST_HOME, survey
from vizbot.bench.episodes.run import run_episode
from vizbot.bench.harness.fingerprint import Fingerprint
from vizbot.bench.harness.store import Store
from vizbot.bench.harness.workers import in_parallel
from vizbot.config import Config
from vizbot.core.errors import ConfigError

UNATTENDED = Config.model_validate({"roomba": {"resume_safe": True}})
"""Nobody stands beside the robot in a benchmark: at an edge it backs off and goes on by itself."""


@dataclass(frozen=True, slots=True)
class BenchPlan:
    """What a person asked for.

    Attributes:
        config: Settings of the robot.
        folder: Where finished results are kept.
        made: What they are made with.
        homes: Seeds; None for those of the scoreboard.
        quick: A small part of the episodes, as a smoke test.
        rows: Names of the variants; None for all of them.
    """

    config: Config
    folder: Path
    made: Fingerprint
    homes: tuple[int, ...] | None = None
    quick: bool = False
    rows: tuple[str, ...] | None = None

    @property
    def full(self) -> bool:
        """Whether this is the whole scoreboard, which may be claimed."""
        return self.homes is None and not self.quick

    def takes(self, row: str) -> bool:
        """Whether a row is asked for; a quick run drives the default alone."""
        return row in self.rows if self.rows is not None else row == "default" or not self.quick


@dataclass(frozen=True, slots=True)
class BenchResult:
    """What a benchmark prints.

    Attributes:
        name: Of the benchmark.
        rows: Of its tables, for programs.
        summary: Its main figures, for programs.
        text: Its tables in Markdown, for people.
    """

    name: str
    rows: list[dict[str, object]]
    summary: dict[str, object]
    text: str


Job = tuple[Variant, Episode]


def run_missing(board: BenchPlan, bench: str, jobs: Sequence[Job]) -> dict[Job, EpisodeResult]:
    """Every episode of `jobs`, from the files or run now, in the order of `jobs`.

    Raises:
        ConfigError: the sources are no longer those that the bench began with.
    """
    require_unchanged(board)
    stores, keys = {}, {}
    done: dict[tuple[str, Episode], EpisodeResult] = {}
    for variant in {job[0].name: job[0] for job in jobs}.values():
        store = Store(results_file(board.folder, bench, variant.name), EpisodeResult)
        stores[variant.name], keys[variant.name] = store, board.made.key_of(variant)
        for result in store.of(keys[variant.name]):
            done[variant.name, result.episode] = result
    missing = [job for job in jobs if (job[0].name, job[1]) not in done]
    for (variant, episode), result in in_parallel(run_episode, missing, bench, _described):
        key = keys[variant.name]
        stores[variant.name].add(key, board.made.commit, board.made.hardware, result)
        done[variant.name, episode] = result
    if board.full:
        for name, store in stores.items():
            store.drop_others(keys[name])
    return {job: done[job[0].name, job[1]] for job in jobs}


def require_unchanged(board: BenchPlan) -> None:
    """Processes that start now load the sources as they are now: they must be the board's.

    Raises:
        ConfigError: they are not.
    """
    if not board.made.still_holds():
        raise ConfigError(
            "sources or weights have changed since the bench began; run it again: what is finished"
            " is kept"
        )


def results_file(folder: Path, bench: str, row: str) -> Path:
    """Where a row is kept."""
    return folder / f"{bench}-{row.replace(' ', '-')}.jsonl"


def goals_of_homes(board: BenchPlan, episodes: int, homes: int) -> list[HomeGoals]:
    """The homes of the scoreboard in order, none skipped, and what can be asked for in them.

    Args:
        board: May name other homes.
        episodes: At least so many goals in all.
        homes: At least so many homes.
    """
    store = Store(board.folder / "homes.jsonl", HomeGoals)
    known = {each.home: each for each in store.of(board.made.homes)}

    def look_at(seeds: Sequence[int]) -> None:
        missing = [seed for seed in seeds if seed not in known]
        for seed, goals in in_parallel(survey, missing, "homes", _surveyed):
            store.add(board.made.homes, board.made.commit, board.made.hardware, goals)
            known[seed] = goals

    if board.homes is not None:
        look_at(board.homes)
        return [known[seed] for seed in board.homes]
    seeds = list(range(FIRST_HOME, FIRST_HOME + homes))
    look_at(seeds)
    while sum(len(known[seed].goals) for seed in seeds) < episodes:
        seeds.append(seeds[-1] + 1)
        look_at(seeds[-1:])
    return [known[seed] for seed in seeds]


def _described(job: Job, result: EpisodeResult) -> str:
    variant, episode = job
    goals = ", ".join(
        f"{goal.text}: {goal.reason or 'success'} in {goal.steps} steps" for goal in result.goals
    )
    return f"{variant.name}, home {episode.home}: {goals} ({result.wall_seconds:.0f} s)"


def _surveyed(seed: int, goals: HomeGoals) -> str:
    return f"home {seed}: {len(goals.goals)} goals"
