"""`docs/scoreboard.md`: the page of the whole board, written from the finished episodes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sim_stubs.furniture import read_catalogue
from sim_stubs.furniture_split import counts
from vizbot.bench import multi, objectnav, retrieval
from vizbot.bench.board import results_file
from vizbot.bench.episodes import EpisodeResult, QueryResult
from vizbot.bench.pictures import draw_episode
from vizbot.bench.store import Kept, Store
from vizbot.bench.tables import table
from vizbot.bench.workers import in_parallel
from vizbot.config import Config
from vizbot.core.files import write_whole

FIRST_LINE = (
    "Homes, encoder and furniture split are ours, not the paper's: these figures are no direct"
    " comparison with its own, which are quoted beside them."
)
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
    driven = {v.name: _kept(folder, objectnav.NAME, v.name) for v in objectnav.variants(config)}
    driven = {name: lines for name, lines in driven.items() if lines}
    in_a_row = _kept(folder, multi.NAME, multi.DEFAULT)
    store = Store(results_file(folder, retrieval.NAME, "queries"), QueryResult)
    asked = store.fullest()
    parts = [FIRST_LINE, "# Scoreboard", _made_with([*driven.values(), in_a_row, asked])]
    parts.append(_furniture())
    if driven:
        results = {name: [line.result for line in lines] for name, lines in driven.items()}
        parts += ["## Object-goal navigation", objectnav.outcome(results).text]
    if asked:
        scales = config.perception.clip_mapper.scales
        answers = retrieval.outcome([line.result for line in asked], scales)
        parts += ["## Retrieval", answers.text]
    if in_a_row:
        parts += ["## Four goals in a row", multi.outcome([x.result for x in in_a_row]).text]
    chosen = pictured([x.result for x in driven.get(objectnav.DEFAULT, [])])
    parts += _pictures(folder, chosen, config)
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


def _made_with(rows: Sequence[Sequence[Kept[EpisodeResult]] | Sequence[Kept[QueryResult]]]) -> str:
    """Commits and machines, each once."""
    lines = [line for row in rows for line in row]
    commits = ", ".join(dict.fromkeys(line.commit for line in lines))
    machines = ", ".join(dict.fromkeys(line.hardware for line in lines))
    return f"Run at commit {commits} on {machines}, two processes of one thread each."


def _furniture() -> str:
    """How many models of each class the encoder may have seen, and how many it has not."""
    sides = counts(read_catalogue())
    rows = [
        [label, count.training, count.held_out, "yes" if count.shapes else "no"]
        for label, count in sides.items()
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
