"""Runs kept episodes again in another order, and says which do not come out as they were.

`python -m tests.tools.repeat_episodes FOLDER BENCH ROW`, for example `docs/results/rows/search
objectnav default`, in a fresh clone at the commit of the rows.
"""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import typer

from benchmarks.episodes.episode import Episode, EpisodeResult, Variant
from benchmarks.episodes.run import run_episode
from benchmarks.harness.bench_plan import UNATTENDED, results_file
from benchmarks.harness.fingerprint import Fingerprint
from benchmarks.harness.store import Store
from benchmarks.harness.workers import in_parallel
from benchmarks.objectnav import multi_goal, single_goal
from vizbot.core.errors import ConfigError

EPISODES = 10
"""Number of episodes that are drawn."""


def variant_of(bench: str, row: str) -> Variant:
    """The variant of a row of a benchmark.

    Raises:
        ConfigError: there is no such row.
    """
    rows = {
        single_goal.NAME: {each.name: each for each in single_goal.variants(UNATTENDED)},
        multi_goal.NAME: {each.name: each for each in multi_goal.variants(UNATTENDED)},
    }
    if row not in rows.get(bench, {}):
        known = "; ".join(f"{name}: {', '.join(each)}" for name, each in rows.items())
        raise ConfigError(f"no row {row!r} of {bench!r}; use {known}")
    return rows[bench][row]


def kept_results(folder: Path, bench: str, variant: Variant) -> list[EpisodeResult]:
    """The kept results of a row that were made with the present sources.

    Raises:
        ConfigError: there are none.
    """
    path = results_file(folder, bench, variant.name)
    store = Store(path, EpisodeResult)
    kept = store.results_with_key(Fingerprint.taken(variant.config.clip).key_of(variant))
    if not kept:
        commits = ", ".join(dict.fromkeys(line.commit for line in store.fullest())) or "none"
        raise ConfigError(
            f"{path} has no row of these sources; check out its commit (there: {commits})"
        )
    return kept


def drawn(kept: list[EpisodeResult], count: int = EPISODES) -> list[EpisodeResult]:
    """Some of the results, drawn by seed 0, in an order that is not theirs."""
    order = np.random.default_rng(0).choice(len(kept), min(count, len(kept)), replace=False)
    if (np.diff(order) > 0).all():
        order = order[::-1]
    return [kept[i] for i in order]


def differences(before: EpisodeResult, again: EpisodeResult) -> list[str]:
    """What differs, one line each; the duration on this machine may."""
    return [
        f"{each.name}: {getattr(before, each.name)} before, {getattr(again, each.name)} now"
        for each in fields(EpisodeResult)
        if each.compare and getattr(before, each.name) != getattr(again, each.name)
    ]


def repeated(variant: Variant, chosen: list[EpisodeResult]) -> dict[Episode, list[str]]:
    """Run these episodes again; what differs of each, in the order in which they ended."""
    before = {result.episode: result for result in chosen}
    jobs = [(variant, episode) for episode in before]
    return {
        job[1]: differences(before[job[1]], again)
        for job, again in in_parallel(run_episode, jobs, "again", _line)
    }


def _line(job: tuple[Variant, Episode], result: EpisodeResult) -> str:
    steps = sum(goal.steps for goal in result.goals)
    return f"home {job[1].home}, {job[1].goals[0]}: {steps} steps"


def repeat(folder: Path, bench: str, row: str, count: int = EPISODES) -> None:
    """Run some episodes of a row again; end with 1 where one differs."""
    try:
        variant = variant_of(bench, row)
        chosen = drawn(kept_results(folder, bench, variant), count)
    except ConfigError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(1) from error
    found = repeated(variant, chosen)
    for episode, lines in found.items():
        for line in lines:
            typer.echo(f"home {episode.home}, {episode.goals}, {episode.number}: {line[:300]}")
    differing = sum(bool(lines) for lines in found.values())
    typer.echo(f"{bench}, {row}: {len(found) - differing} of {len(found)} episodes are equal")
    raise typer.Exit(1 if differing else 0)


if __name__ == "__main__":
    typer.run(repeat)
