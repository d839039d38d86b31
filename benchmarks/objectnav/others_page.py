"""`docs/results/others.md`: object goals in homes that others have drawn."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from benchmarks.episodes.episode import EpisodeResult
from benchmarks.harness.bench_plan import results_file
from benchmarks.harness.scores import NavigationScore
from benchmarks.harness.store import Store
from benchmarks.harness.tables import (
    fraction_text,
    fraction_with_interval,
    markdown_table,
    percent,
    percent_range,
)
from benchmarks.objectnav.home_tables import seen_section
from benchmarks.objectnav.single_goal import DEFAULT, NAME

_TEXT = """There is one episode for each of the paper's goals that a home has, that can be seen, and
that can be started for over 3 m away (`vizbot bench objectnav --worlds FILE,FILE`). The authors of
these homes, which come with Sweet Home 3D, chose rooms and furniture for other purposes. The models
of furniture lie in the files of the homes: they are not from the catalogue that training and the
board use. Encoder and belief were learned in homes that our own program makes, and it shows: half
of the goals are not reached, and most of those end as not found."""


def others_page(folder: Path, page: Path) -> str:
    """The page of the kept episodes in homes drawn by others; empty without any."""
    lines = Store(results_file(folder, NAME, DEFAULT), EpisodeResult).fullest()
    if not lines:
        return ""
    results = [line.result for line in lines]
    homes = dict.fromkeys(result.episode.home for result in results)
    groups = {
        Path(str(home)).stem: [r for r in results if r.episode.home == home] for home in homes
    }
    rows = []
    for name, of_home in {**groups, "all": results}.items():
        score = NavigationScore.from_results(of_home)
        rows.append(
            [name, fraction_with_interval(score.success), fraction_text(score.said_wrongly),
             percent(score.spl), score.steps and f"{score.steps:.0f}", score.path_of_successes,
             score.shortest_of_successes, score.collisions]
        )  # fmt: skip
    header = ("home", "reached", "wrong arrivals", "SPL", "steps", "driven [m]", "shortest [m]",
              "collisions")  # fmt: skip
    ends = Counter(_end(result) for result in results)
    over_homes = percent_range(NavigationScore.from_results(results).success_over_homes)
    parts = [
        "# Object goals in homes drawn by others",
        markdown_table(header, rows),
        f"Over homes the 95 % interval of all is {over_homes} %. Commit"
        f" {' and '.join(dict.fromkeys(line.commit for line in lines))}.",
        _TEXT,
        markdown_table(("how the episode ended", "episodes"), ends.most_common()),
        seen_section(results),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


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
