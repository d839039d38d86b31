"""`docs/scoreboard.md`: the page of the whole board, written from the finished episodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim_stubs.furniture import read_catalogue
from sim_stubs.furniture_split import counts
from vizbot.bench import multi, objectnav, retrieval
from vizbot.bench.board import Outcome, results_file
from vizbot.bench.episodes import EpisodeResult, QueryResult
from vizbot.bench.pictures import draw_episode
from vizbot.bench.store import Kept, Store
from vizbot.bench.tables import percent, table
from vizbot.bench.workers import in_parallel
from vizbot.config import Config
from vizbot.core.files import write_whole

FIRST_LINE = (
    "Homes, encoder and furniture split are ours, not the paper's: these figures are no direct"
    " comparison with its own, which are quoted beside them."
)
TARGETS = (
    (objectnav.NAME, "success_rate", "success of navigation", 0.87),
    (objectnav.NAME, "others_success_rate", "success, objects not in COCO", 0.93),
    (retrieval.NAME, "precision_at_1", "precision@1 of retrieval", 0.83),
    (multi.NAME, "four_in_a_row_rate", "four goals in a row", 0.44),
)
"""Benchmark, key of its summary, what it is, and what must be reached."""
_PICTURES = 6
"""Of each kind at most."""


def write_page(folder: Path, config: Config) -> Path:
    """Write `<folder>.md` and the pictures that it shows.

    Args:
        folder: Where the finished episodes are kept.
        config: The robot's, for its default scales.

    Returns:
        The page.
    """
    rows = {
        f"{objectnav.NAME}, {variant.name}": _kept(folder, objectnav.NAME, variant.name)
        for variant in objectnav.variants(config)
    }
    driven = {name.split(", ")[1]: _results(lines) for name, lines in rows.items() if lines}
    in_a_row = _kept(folder, multi.NAME, multi.DEFAULT)
    asked = Store(results_file(folder, retrieval.NAME, "queries"), QueryResult).fullest()
    outcomes: dict[str, Outcome] = {}
    if driven:
        outcomes["Object-goal navigation"] = objectnav.outcome(driven)
    if asked:
        scales = config.perception.clip_mapper.scales
        outcomes["Retrieval"] = retrieval.outcome(_results(asked), scales)
    if in_a_row:
        outcomes["Four goals in a row"] = multi.outcome(_results(in_a_row))
    made: dict[str, Sequence[Kept[Any]]] = {**rows, retrieval.NAME: asked, multi.NAME: in_a_row}
    parts = [FIRST_LINE, "# Scoreboard", _made_with(made), _targets(list(outcomes.values()))]
    for title, outcome in outcomes.items():
        parts += [f"## {title}", outcome.text]
    parts += _pictures(folder, pictured(driven.get(objectnav.DEFAULT, [])), config)
    parts += ["## Furniture", _furniture()]
    page = folder.with_suffix(".md")
    write_whole(page, ("\n\n".join(part for part in parts if part) + "\n").encode())
    return page


def pictured(results: Sequence[EpisodeResult]) -> list[EpisodeResult]:
    """Failures and successes, drawn by a fixed seed, in the order they were asked."""
    rng = np.random.default_rng(0)
    chosen: set[int] = set()
    for success in (False, True):
        alike = [i for i, result in enumerate(results) if result.success is success]
        chosen |= set(rng.permutation(alike)[:_PICTURES].tolist())
    return [results[i] for i in sorted(chosen, key=lambda i: (results[i].success, i))]


def _kept(folder: Path, bench: str, row: str) -> list[Kept[EpisodeResult]]:
    return Store(results_file(folder, bench, row), EpisodeResult).fullest()


def _results(lines: Sequence[Kept[Any]]) -> list[Any]:
    return [line.result for line in lines]


def _made_with(rows: Mapping[str, Sequence[Kept[Any]]]) -> str:
    """Which rows were run at which commit, and on what."""
    of_commit: dict[str, list[str]] = {}
    for name, lines in rows.items():
        if lines:
            commits = " and ".join(dict.fromkeys(line.commit for line in lines))
            of_commit.setdefault(commits, []).append(name)
    machines = dict.fromkeys(line.hardware for lines in rows.values() for line in lines)
    told = [f"- {commit}: {'; '.join(names)}" for commit, names in of_commit.items()]
    return "\n".join([f"Run on {', '.join(machines)}, at these commits of the sources:", "", *told])


def _targets(outcomes: Sequence[Outcome]) -> str:
    of_name = {outcome.name: outcome.summary for outcome in outcomes}
    rows = []
    for name, key, what, target in TARGETS:
        value = of_name.get(name, {}).get(key)
        reached = "not run" if value is None else "yes" if float(str(value)) >= target else "no"
        shown = "-" if value is None else percent(float(str(value)))
        rows.append([what, percent(target), shown, reached])
    return table(("must reach", "at least", "here", "reached"), rows)


def _furniture() -> str:
    """How many models of each class the encoder may have seen, and how many it has not."""
    rows = [
        [label, count.training, count.held_out, "yes" if count.shapes else "no"]
        for label, count in counts(read_catalogue()).items()
    ]
    header = ("class", "models in training homes", "held out for these homes", "own shapes too")
    told = "The encoder was trained on other models of furniture than those it is judged on."
    return f"{told}\n\n{table(header, rows)}"


def _pictures(folder: Path, chosen: Sequence[EpisodeResult], config: Config) -> list[str]:
    """Draw the episodes beside their results; the page's lines that show them."""
    if not chosen:
        return []
    parts = [
        "## Pictures",
        "Left the true home from above, which the robot never sees, with its way in red from the"
        " blue dot to the red one and what was asked for in green; right its last look.",
    ]
    drawn = in_parallel(_draw, [(result, config) for result in chosen], "pictures", _described)
    jpegs = {job[0].episode: jpeg for job, jpeg in drawn}
    for old in folder.glob("*.jpg"):
        old.unlink()
    for result in chosen:
        name = f"{result.episode.home}-{result.episode.goals[0].replace(' ', '-')}.jpg"
        write_whole(folder / name, jpegs[result.episode])
        verdict = "success" if result.success else "failure"
        alt = f"{verdict}: {result.episode.goals[0]} in home {result.episode.home}"
        parts.append(f"![{alt}]({folder.name}/{name})")
    return parts


def _draw(job: tuple[EpisodeResult, Config]) -> bytes:
    return draw_episode(*job)


def _described(job: tuple[EpisodeResult, Config], jpeg: bytes) -> str:
    return f"home {job[0].episode.home}, {job[0].episode.goals[0]}"
