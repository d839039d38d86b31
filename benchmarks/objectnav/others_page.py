"""`docs/results/others.md`: object goals in homes that others have drawn."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.encoder.page import homes_by_others
from benchmarks.episodes.episode import EpisodeResult
from benchmarks.harness.bench_plan import PAPER, PERFECT_STOP
from benchmarks.harness.scores import NavigationScore, Rate
from benchmarks.harness.store import StoredResult
from benchmarks.harness.tables import fraction_with_interval, markdown_table, percent, percent_range
from benchmarks.objectnav.home_tables import seen_section
from benchmarks.objectnav.overshoot import overshoot_table
from benchmarks.objectnav.search_page import (
    differences,
    kept_row,
    made_with,
    results_of,
    spl_over_homes,
    with_default_beside,
)
from benchmarks.objectnav.single_goal import DEFAULT
from vizbot.core.observer import Outcome

ROWS = (DEFAULT, "true encoder", PERFECT_STOP, PAPER)
"""Rows of the page, where they were driven."""
_TEXT = """There is one episode for each of the paper's goals that a home has, that can be seen, and
that can be started for over 3 m away (`vizbot bench objectnav --worlds FILE,FILE --rows "default,
true encoder,perfect stop,paper"`). All rows have the same goals, starts and noise. The authors of
these homes, which come with Sweet Home 3D, chose rooms and furniture for other purposes. The models
of furniture lie in the files of the homes: they are not from the catalogue that the board uses.
Every goal is there, so that each "not found" is wrong. Wrong arrivals are counted among those that
the robot claims. Intervals are of 95 %. `true encoder` reads what each pixel shows; `perfect stop`
ends where it first stands where a stop is a success, unless it has ended before; `paper` is the
paper's method."""


def others_page(folder: Path, page: Path) -> str:
    """The page of the kept episodes in homes drawn by others; empty without the default row."""
    rows = {
        name: [_in_named_home(line) for line in row]
        for name in ROWS
        if (row := kept_row(folder, name))
    }
    if DEFAULT not in rows:
        return ""
    results = results_of(rows[DEFAULT])
    homes = dict.fromkeys(result.episode.home for result in results)
    header = ("reached", "not found", "wrong arrivals of claims", "SPL", "stuck", "steps",
              "driven [m]", "shortest [m]", "collisions")  # fmt: skip
    of_homes = [
        [home, *_figures([each for each in results if each.episode.home == home])]
        for home in homes
    ]  # fmt: skip
    ends = Counter(_end(result) for result in results)
    way = overshoot_table(folder, ROWS)
    parts = [
        "# Object goals in homes drawn by others",
        markdown_table(("row", *header), with_default_beside(rows, ROWS, _figures)),
        differences(rows, ROWS[1:]),
        _TEXT,
        made_with(rows),
        f"## The row `{DEFAULT}`",
        markdown_table(("home", *header), of_homes),
        markdown_table(("how the episode ended", "episodes"), ends.most_common()),
        way and f"## Way before and after a stop would have been a success\n\n{way}",
        seen_section(results),
        homes_by_others(folder.with_name("encoder")),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _in_named_home(line: StoredResult[EpisodeResult]) -> StoredResult[EpisodeResult]:
    """An episode in the home of this name, so that rows pair wherever its file lay."""
    episode = line.result.episode
    named = replace(episode, home=Path(str(episode.home)).stem)
    return replace(line, result=replace(line.result, episode=named))


def _figures(results: Sequence[EpisodeResult]) -> list[object]:
    score = NavigationScore.from_results(results)
    goals = [result.goals[0] for result in results]
    not_found = Rate.over(goal.outcome is Outcome.NOT_FOUND for goal in goals)
    wrong = Rate.over(not goal.success for goal in goals if goal.claimed)
    return [
        fraction_with_interval(score.success) + _over_homes(score.success_over_homes),
        fraction_with_interval(not_found), fraction_with_interval(wrong),
        percent(score.spl) + _over_homes(spl_over_homes(results)), score.stuck,
        score.steps and f"{score.steps:.0f}", score.path_of_successes, score.shortest_of_successes,
        score.collisions,
    ]  # fmt: skip


def _over_homes(interval: tuple[float, float] | None) -> str:
    return "" if interval is None else f", over homes {percent_range(interval)}"


def _end(result: EpisodeResult) -> str:
    """How an episode ended, in a few words."""
    goal = result.goals[0]
    if goal.success:
        return "reached"
    if goal.claimed:
        return "the robot said wrongly that it had arrived"
    return (
        "the search ended by an error" if goal.outcome is None else goal.outcome.replace("_", " ")
    )
