"""How much of a home the robot says that it has seen, beside the truth."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from benchmarks.episodes.episode import EpisodeResult, GoalResult
from benchmarks.harness.tables import markdown_table
from vizbot.core.observer import Outcome

CLOSE = 10
"""What is close to the truth [points of a hundred]."""
_NOTE = (
    "Differences are in points of a hundred of the floor that can be reached. Before the"
    " robot has seen the end of a home it does not know how large the home is."
)


def seen_section(results: Sequence[EpisodeResult], absent: Sequence[EpisodeResult] = ()) -> str:
    """The section of a page about these searches; empty where the truth was not kept."""
    goals = [result.goals[0] for result in results]
    ended = {
        outcome.replace("_", " "): [goal for goal in goals if goal.outcome is outcome]
        for outcome in (Outcome.NOT_FOUND, Outcome.ARRIVED, Outcome.GAVE_UP)
    }
    vain = [result.goals[0] for result in absent]
    ended["not found, and is not there"] = [g for g in vain if g.outcome is Outcome.NOT_FOUND]
    lines: list[list[object]] = []
    for name, kept in ended.items():
        if off := _said_too_much(kept):
            within = sum(abs(each) <= CLOSE for each in off)
            lines.append(
                [name, len(off), f"{np.mean(off):+.1f}", within, f"{max(off, key=abs):+.1f}"]
            )
    if not lines:
        return ""
    header = ("search ended", "episodes", "said too much, mean", f"within {CLOSE}", "farthest off")
    title = "## How much of the home the robot says that it has seen"
    return f"{title}\n\n{markdown_table(header, lines)}\n\n{_NOTE}"


def _said_too_much(goals: Iterable[GoalResult]) -> list[float]:
    """By how many points, for each goal of which the truth was kept."""
    return [
        100 * (goal.said_seen - goal.truly_seen)
        for goal in goals
        if goal.said_seen is not None and goal.truly_seen is not None
    ]
