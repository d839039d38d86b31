"""`docs/results/others.md`: object goals in homes that others have drawn."""

from __future__ import annotations

from pathlib import Path

from benchmarks.episodes.episode import EpisodeResult, Home, HomeGoals
from benchmarks.harness.bench_plan import results_file
from benchmarks.harness.scores import NavigationScore
from benchmarks.harness.store import Store
from benchmarks.harness.tables import (
    fraction_with_interval,
    markdown_table,
    percent,
    percent_range,
)
from benchmarks.objectnav.seen_section import seen_section
from benchmarks.objectnav.single_goal import DEFAULT, NAME

_TITLE = """# Object goals in homes drawn by others

One episode for each of the paper's goals in example homes that come with Sweet Home 3D
(`vizbot bench objectnav --worlds FILE,FILE`). Rooms and furniture were chosen by their authors for
other ends; the models are from the same catalogue as those that training and boards use. A goal
counts where the home has it, it can be seen, and an episode can start over 3 m away from it."""


def others_page(folder: Path, page: Path) -> str:
    """The page of the kept episodes in homes drawn by others; empty without any.

    Args:
        folder: Folder of the kept episodes.
        page: The file that the text is for.
    """
    lines = Store(results_file(folder, NAME, DEFAULT), EpisodeResult).fullest()
    if not lines:
        return ""
    surveyed = Store(folder / "homes.jsonl", HomeGoals).fullest()
    results = [line.result for line in lines]
    score = NavigationScore.from_results(results)
    rows = []
    for home in dict.fromkeys(result.episode.home for result in results):
        of_home = [result for result in results if result.episode.home == home]
        here = NavigationScore.from_results(of_home)
        rows.append(
            [name_of_home(home), fraction_with_interval(here.success), percent(here.spl),
             here.steps and f"{here.steps:.0f}", here.path_of_successes, here.shortest_of_successes,
             here.collisions]
        )  # fmt: skip
    table = markdown_table(
        ("home", "reached", "SPL", "steps", "driven [m]", "shortest [m]", "collisions"), rows
    )
    episodes = [
        [f"{name_of_home(r.episode.home)}, {r.goals[0].text}",
         "reached" if r.success else r.goals[0].reason, r.goals[0].steps,
         r.goals[0].path_length, r.goals[0].shortest_path]
        for r in results
    ]  # fmt: skip
    each = markdown_table(
        ("episode", "how it ended", "steps", "driven [m]", "shortest [m]"), episodes
    )
    goals = [[name_of_home(line.result.home), ", ".join(line.result.goals)] for line in surveyed]
    made = f"Commit {' and '.join(dict.fromkeys(line.commit for line in lines))}."
    total = (
        f"Together {fraction_with_interval(score.success)}, over homes"
        f" {percent_range(score.success_over_homes)} %, SPL {percent(score.spl)} %. {made}"
    )
    homes = markdown_table(("home", "goals"), goals)
    parts = [_TITLE, table, total, each, homes, seen_section(results)]
    return "\n\n".join(part for part in parts if part) + "\n"


def name_of_home(home: Home) -> str:
    """A home in a few words."""
    return f"home {home}" if isinstance(home, int) else Path(home).stem
