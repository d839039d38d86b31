"""How far the robot drives on after it first stood where a stop would have been a success.

`python -m benchmarks.objectnav.overshoot FOLDER ROW ...` asks the scorer of every place on the
true paths of kept episodes, and keeps what comes of it beside them. What is driven after that is
what a perfect decision to have arrived would save. `--worlds FILE,FILE` says where homes drawn by
others lie now.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, median
from typing import Annotated

import numpy as np
import typer

from benchmarks.episodes.episode import Episode, EpisodeResult, Home
from benchmarks.episodes.homes import open_benchmark_home
from benchmarks.harness.bench_plan import UNATTENDED, results_file
from benchmarks.harness.store import Store
from benchmarks.harness.tables import markdown_table
from benchmarks.harness.workers import in_parallel
from benchmarks.objectnav.single_goal import NAME as OBJECTNAV
from sim_stubs.scoring.success import judge
from sim_stubs.world.world_spec import require_world
from vizbot.core.errors import ConfigError

NAME = "overshoot"


@dataclass(frozen=True, slots=True)
class Overshoot:
    """The way of an episode, and where on it the robot might have stopped.

    Attributes:
        episode: The episode.
        way: Length of the driven path [m].
        before: What of it was driven when the robot first stood where a stop would have been a
            success [m]; None where it never did.
        arrived: Whether it did stop with success.
    """

    episode: Episode
    way: float
    before: float | None
    arrived: bool

    @property
    def after(self) -> float | None:
        """What was driven after that [m]."""
        return None if self.before is None else max(0.0, self.way - self.before)


OfHome = tuple[Home, list[EpisodeResult]]
"""A home, as it is found now, and the episodes of a row in it."""


def overshoots(job: OfHome) -> list[Overshoot]:
    """Of each episode, asked where its home stands."""
    home, results = job
    with open_benchmark_home(home, UNATTENDED) as world:
        found = []
        for result in results:
            goal, track = result.goals[0], np.array(result.track)
            driven = np.append(0.0, np.linalg.norm(np.diff(track, axis=0), axis=1).cumsum())
            before = None
            for (x, y), way in zip(track.tolist(), driven.tolist(), strict=True):
                world.place(x, y, 0.0)  # the scorer turns the robot itself
                if judge(world, goal.text, stopped=True).success:
                    before = round(way, 2)
                    break
            found.append(Overshoot(result.episode, goal.path_length, before, goal.success))
        return found


def ways_before_and_after(each: Sequence[Overshoot]) -> tuple[list[float], list[float]]:
    """What was driven until a stop would have done, and after that, where it ever would [m]."""
    before = [one.before for one in each if one.before is not None]
    return before, [one.after for one in each if one.after is not None]


def overshoot_table(folder: Path, rows: Sequence[str]) -> str:
    """A table of the kept overshoots of these rows; empty where none are kept."""
    lines: list[list[object]] = []
    for row in rows:
        stored = Store(results_file(folder, NAME, row), Overshoot).fullest()
        if not stored:
            continue
        each = [line.result for line in stored]
        before, after = ways_before_and_after(each)
        lines.append(
            [row, len(each), len(before),
             *(f"{figure(ways):.1f}" if ways else None
               for figure, ways in ((mean, before), (mean, after), (median, after))),
             sum(one.before is not None and not one.arrived for one in each)]
        )  # fmt: skip
    header = ("row", "episodes", "stood where a stop would do", "driven before [m]",
              "driven after, mean [m]", "median [m]", "of them not reached")  # fmt: skip
    return markdown_table(header, lines) if lines else ""


def ask(
    folder: Annotated[Path, typer.Argument(help="Folder of the kept rows.")],
    rows: Annotated[list[str], typer.Argument(help="Names of the rows.")],
    worlds: Annotated[
        str, typer.Option(help="Homes drawn by others, where they lie now, between commas.")
    ] = "",
) -> None:
    """Ask the scorer of the paths of kept rows, and keep what it says beside them."""
    found_at = {Path(world).name: world for world in worlds.split(",") if world}
    for row in rows:
        stored = Store(results_file(folder, OBJECTNAV, row), EpisodeResult).fullest()
        by_home: dict[Home, list[EpisodeResult]] = {}
        for line in stored:
            home = line.result.episode.home
            home = found_at.get(Path(str(home)).name, home)
            by_home.setdefault(home, []).append(line.result)
        jobs = sorted(by_home.items(), key=str)
        _require_homes(by_home)
        path = results_file(folder, NAME, row)
        path.unlink(missing_ok=True)
        kept = Store(path, Overshoot)
        for _, found in in_parallel(overshoots, jobs, f"{NAME}, {row}", _home_line):
            kept.add(stored[0].key, stored[0].commit, stored[0].hardware, *found)


def _require_homes(homes: Iterable[Home]) -> None:
    try:
        for home in homes:
            require_world(str(home))
    except ConfigError as error:
        raise typer.BadParameter(f"{error}; say by --worlds where it lies now") from error


def _home_line(job: OfHome, found: Sequence[Overshoot]) -> str:
    return f"home {job[0]}: {len(found)} paths"


if __name__ == "__main__":
    typer.run(ask)
