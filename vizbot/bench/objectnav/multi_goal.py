"""`vizbot bench multi`: four goals in a row (paper, multi-object-goal navigation)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vizbot.bench.episodes.episode import Episode, EpisodeResult, HomeGoals, Variant
from vizbot.bench.harness.bench_plan import (
    BOARD,
    BenchPlan,
    BenchResult,
    goals_of_homes,
    run_missing,
)
from vizbot.bench.harness.scores import Rate, interval_over_homes
from vizbot.bench.harness.tables import interval_text, markdown_table, percent_range
from vizbot.bench.objectnav import paper_figures

NAME = "multi"
EPISODES, GOALS = 100, 4
"""Episodes in all homes of the scoreboard together, and goals in each (paper, section IV-E)."""
_QUICK_HOMES = 2
DEFAULT = "default"


def run_multi_goal(plan: BenchPlan) -> BenchResult:
    """Run what is missing and print the table."""
    homes = goals_of_homes(plan, _QUICK_HOMES if plan.quick else None)
    episodes = multi_goal_episodes(homes, len(homes) if plan.quick else episodes_in(homes))
    variant = Variant(DEFAULT, plan.config)
    results = run_missing(plan, NAME, [(variant, episode) for episode in episodes])
    return multi_goal_result(list(results.values()), smoke_test=plan.quick)


def episodes_in(homes: Sequence[HomeGoals]) -> int:
    """Number of episodes in these homes, in proportion to those of the scoreboard."""
    return EPISODES * len(homes) // len(BOARD)


def multi_goal_episodes(homes: Sequence[HomeGoals], count: int) -> list[Episode]:
    """Four different goals, drawn by home and number, for `count` episodes in these homes.

    Every home has as many episodes as the others; the first ones may have one more.
    """
    episodes = []
    for position, home in enumerate(homes):
        for number in range(1, 1 + len(range(position, count, len(homes)))):
            rng = np.random.default_rng((home.home, number))
            goals = rng.permutation(len(home.goals))[:GOALS]
            episodes.append(Episode(home.home, tuple(home.goals[i] for i in goals), number))
    return episodes


def at_least_rates(results: Sequence[EpisodeResult]) -> tuple[Rate, ...]:
    """Episodes that reach at least 1, 2, 3, 4 goals."""
    return tuple(
        Rate.over(result.reached >= goals for result in results) for goals in range(1, GOALS + 1)
    )


def multi_goal_result(results: Sequence[EpisodeResult], smoke_test: bool = False) -> BenchResult:
    """Rows, summary and tables of these results."""
    rates = at_least_rates(results)
    low, high = rates[-1].interval()
    ours: dict[str, object] = {"row": DEFAULT, "episodes": len(results)}
    ours |= _counts([rate.count for rate in rates])
    rows = [ours]
    rows += [
        {"row": method, "source": paper_figures.MARK, "episodes": 100} | _counts(counts)
        for method, counts in paper_figures.MULTI
    ]
    summary: dict[str, object] = {
        "episodes": len(results),
        "four_in_a_row": rates[-1].count,
        "four_in_a_row_rate": rates[-1].value,
        "four_in_a_row_low": low,
        "four_in_a_row_high": high,
    }
    parts = [_table(results), _failures(results)]
    if smoke_test:
        parts.insert(0, "A smoke test on a part of the episodes: no claim.")
    return BenchResult(NAME, rows, summary, "\n\n".join(part for part in parts if part))


def _counts(counts: Sequence[int]) -> dict[str, object]:
    return {f"at_least_{goals}": count for goals, count in enumerate(counts, start=1)}


def _table(results: Sequence[EpisodeResult]) -> str:
    rows: list[list[object]] = [
        [f"{method} ({paper_figures.MARK})", 100, *counts, "-", "-"]
        for method, counts in paper_figures.MULTI
    ]
    rates = at_least_rates(results)
    ours = [f"vizbot, {DEFAULT}", len(results), *(rate.count for rate in rates)]
    over_homes = interval_over_homes((r.episode.home, r.reached >= GOALS) for r in results)
    rows.append([*ours, interval_text(rates[-1]), percent_range(over_homes)])
    header = ("episodes that reach at least", "of", "1", "2", "3", "4",
              "95 % of the last [%] (Wilson)", "95 % of the last [%] over homes")  # fmt: skip
    return markdown_table(header, rows)


def _failures(results: Sequence[EpisodeResult]) -> str:
    """A table of the goals at which episodes ended early."""
    ended = [result.goals[-1] for result in results if not result.success]
    counts = {text: 0 for text in sorted({goal.text for goal in ended})}
    for goal in ended:
        counts[goal.text] += 1
    commanded = [goal.text for result in results for goal in result.goals]
    rows = [
        [text, count, commanded.count(text)]
        for text, count in sorted(counts.items(), key=lambda item: -item[1])
    ]
    return (
        markdown_table(("goal that ended an episode", "times", "times commanded"), rows)
        if rows
        else ""
    )
