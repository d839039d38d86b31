"""`vizbot bench multi`: four goals in a row (paper, multi-object-goal navigation)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.episodes.episode import (
    FAR,
    Episode,
    EpisodeResult,
    HomeGoals,
    Variant,
    seed_of_home,
)
from benchmarks.harness.bench_plan import (
    BOARD,
    PAPER,
    BenchPlan,
    BenchResult,
    goals_of_homes,
    run_missing,
)
from benchmarks.harness.scores import Rate, interval_over_homes
from benchmarks.harness.tables import interval_text, markdown_table, percent_range
from benchmarks.objectnav import paper_figures
from vizbot.config import Config, with_method

NAME = "multi"
EPISODES, GOALS = 100, 4
"""Episodes in all homes of the board together, and goals in each (paper, section IV-E)."""
_QUICK_HOMES = 2
DEFAULT, OVER_3_M = "default", f"over {FAR:.0f} m"

Results = Mapping[str, Sequence[EpisodeResult]]
"""Results of the rows, by name."""


def run_multi_goal(plan: BenchPlan) -> BenchResult:
    """Run what is missing and print the table."""
    homes = goals_of_homes(plan, _QUICK_HOMES if plan.quick else None)
    count = len(homes) if plan.quick else episodes_in(homes)
    jobs = [
        (variant, episode)
        for variant in variants(plan.config)
        if plan.includes(variant.name)
        for episode in multi_goal_episodes(homes, count, far=variant.name == OVER_3_M)
    ]
    results: dict[str, list[EpisodeResult]] = {}
    for (variant, _), result in run_missing(plan, NAME, jobs).items():
        results.setdefault(variant.name, []).append(result)
    return multi_goal_result(results, smoke_test=plan.quick)


def variants(config: Config) -> tuple[Variant, ...]:
    """The rows: any four goals, four that are far from one another, any four by the paper's method.

    A goal is far when it is over 3 m of way from where the robot stands.
    """
    paper = Variant(PAPER, with_method(config, "paper"))
    return (Variant(DEFAULT, config), Variant(OVER_3_M, config), paper)


def episodes_in(homes: Sequence[HomeGoals]) -> int:
    """Number of episodes in these homes, in proportion to those of the board."""
    return EPISODES * len(homes) // len(BOARD)


def multi_goal_episodes(homes: Sequence[HomeGoals], count: int, far: bool = False) -> list[Episode]:
    """Four different goals, drawn by home and number, for `count` episodes in these homes.

    Every home has as many episodes as the others; the first ones may have one more.

    Args:
        homes: The homes.
        count: Number of episodes.
        far: Whether all goals of the home follow in the drawn order, of which the run takes those
            that are far from where the robot stands.
    """
    episodes = []
    for position, home in enumerate(homes):
        for number in range(1, 1 + len(range(position, count, len(homes)))):
            rng = np.random.default_rng((seed_of_home(home.home), number))
            goals = tuple(home.goals[i] for i in rng.permutation(len(home.goals)))
            if far:
                episodes.append(Episode(home.home, goals, number, choose=GOALS))
            else:
                episodes.append(Episode(home.home, goals[:GOALS], number))
    return episodes


def at_least_rates(results: Sequence[EpisodeResult]) -> tuple[Rate, ...]:
    """Episodes that reach at least 1, 2, 3, 4 goals."""
    return tuple(
        Rate.over(result.reached >= goals for result in results) for goals in range(1, GOALS + 1)
    )


def within_reach(results: Sequence[EpisodeResult]) -> Rate:
    """Later goals that were given where the robot already stood within their reach."""
    return Rate.over(goal.shortest_path == 0.0 for r in results for goal in r.goals[1:])


def multi_goal_result(results: Results, smoke_test: bool = False) -> BenchResult:
    """Rows, summary and tables of these results."""
    rows = [_row(name, episodes) for name, episodes in results.items()]
    rows += [
        {"row": method, "source": paper_figures.MARK, "episodes": 100} | _counts(counts)
        for method, counts in paper_figures.MULTI
    ]
    summary: dict[str, object] = {}
    headline = PAPER if DEFAULT not in results else DEFAULT
    for name, prefix in ((headline, ""), (OVER_3_M, "far_")):
        if name in results:
            summary |= {f"{prefix}{key}": value for key, value in _summary(results[name]).items()}
    parts = [_table(results), *(_later_goals(name, rows) for name, rows in results.items())]
    parts += [_failures(results[headline])] if headline in results else []
    if smoke_test:
        parts.insert(0, "A smoke test on a part of the episodes: no claim.")
    return BenchResult(NAME, rows, summary, "\n\n".join(part for part in parts if part))


def _row(name: str, results: Sequence[EpisodeResult]) -> dict[str, object]:
    row: dict[str, object] = {"row": name, "episodes": len(results)}
    return row | _counts([rate.count for rate in at_least_rates(results)])


def _summary(results: Sequence[EpisodeResult]) -> dict[str, object]:
    four, at_once = at_least_rates(results)[-1], within_reach(results)
    low, high = four.interval()
    return {
        "episodes": len(results),
        "four_in_a_row": four.count,
        "four_in_a_row_rate": four.value,
        "four_in_a_row_low": low,
        "four_in_a_row_high": high,
        "later_goals": at_once.trials,
        "later_goals_within_reach": at_once.count,
    }


def _counts(counts: Sequence[int]) -> dict[str, object]:
    return {f"at_least_{goals}": count for goals, count in enumerate(counts, start=1)}


def _table(results: Results) -> str:
    rows: list[list[object]] = [
        [f"{method} ({paper_figures.MARK})", 100, *counts, "-", "-"]
        for method, counts in paper_figures.MULTI
    ]
    for name, episodes in results.items():
        rates = at_least_rates(episodes)
        ours = [f"vizbot, {name}", len(episodes), *(rate.count for rate in rates)]
        over_homes = interval_over_homes((r.episode.home, r.reached >= GOALS) for r in episodes)
        rows.append([*ours, interval_text(rates[-1]), percent_range(over_homes)])
    header = ("episodes that reach at least", "of", "1", "2", "3", "4",
              "95 % of the last [%] (Wilson)", "95 % of the last [%] over homes")  # fmt: skip
    return markdown_table(header, rows)


def _later_goals(name: str, results: Sequence[EpisodeResult]) -> str:
    """How many later goals needed no way, and which episodes ran out of far ones."""
    at_once = within_reach(results)
    text = (
        f"Row {name}: of {at_once.trials} later goals {at_once.count} were given where the robot"
        " already stood within reach."
    )
    if name == OVER_3_M:
        text += (
            " Each next goal is the first, in an order drawn by home and number, that is over"
            f" {FAR:.0f} m of way from where the robot truly stands, which it does not know."
        )
    out = sum(not r.success and all(goal.success for goal in r.goals) for r in results)
    return f"{text} {out} episodes ended because no goal was that far." if out else text


def _failures(results: Sequence[EpisodeResult]) -> str:
    """A table of the goals at which episodes ended early."""
    ended = Counter(r.goals[-1].text for r in results if not r.goals[-1].success)
    commanded = Counter(goal.text for result in results for goal in result.goals)
    rows = [
        [text, count, commanded[text]]
        for text, count in sorted(ended.items(), key=lambda item: (-item[1], item[0]))
    ]
    header = ("goal that ended an episode", "times", "times commanded")
    return markdown_table(header, rows) if rows else ""
