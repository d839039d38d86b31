"""How much of a home the robot says that it has seen, beside the truth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vizbot.bench.episodes.episode import EpisodeResult
from vizbot.bench.harness.tables import markdown_table
from vizbot.core.observer import Outcome

_NOTE = (
    "Of the floor that can be reached, when the search ends; in points of a hundred. Before the"
    " robot has seen the end of a home it does not know how large that is; it says that there is"
    " none when little is left to see."
)


def seen_section(results: Sequence[EpisodeResult]) -> str:
    """The section of a page about these searches; empty where the truth was not kept."""
    lines: list[list[object]] = []
    for outcome in (Outcome.NOT_FOUND, Outcome.ARRIVED, Outcome.GAVE_UP):
        off = [
            100 * (goal.said_seen - goal.truly_seen)
            for goal in (result.goals[0] for result in results)
            if goal.outcome is outcome
            and goal.said_seen is not None
            and goal.truly_seen is not None
        ]
        if off:
            within = sum(abs(each) <= 10 for each in off)
            ended = outcome.replace("_", " ")
            lines.append(
                [ended, len(off), f"{np.mean(off):+.1f}", within, f"{max(off, key=abs):+.1f}"]
            )
    if not lines:
        return ""
    header = ("ended", "episodes", "said too much, mean", "within 10", "farthest off")
    title = "## How much of the home it said that it had seen"
    return f"{title}\n\n{_NOTE}\n\n{markdown_table(header, lines)}"
