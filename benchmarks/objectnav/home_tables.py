"""Tables of homes: their goals, the models that count as these, and how much of them is seen."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from benchmarks.episodes.episode import EpisodeResult, GoalResult, Home, HomeGoals
from benchmarks.episodes.homes import OWN_SHAPE
from benchmarks.harness.tables import markdown_table
from sim_stubs.homes.furniture.procedural import DEVELOPMENT, FIRST_IN_TURN
from sim_stubs.homes.home import HELD_OUT
from sim_stubs.scoring.success import GOALS
from vizbot.core.observer import Outcome

CLOSE = 10
"""What is close to the truth [points of a hundred]."""
_NOTE = (
    "Differences are in points of a hundred of the floor that can be reached. Before the"
    " robot has seen the end of a home it does not know how large the home is."
)


def homes_table(homes: Sequence[HomeGoals]) -> str:
    """A table of the goals that each home lacks."""
    rows = [
        [f"home {each.home}", len(each.goals),
         ", ".join(goal for goal in GOALS if goal not in each.goals) or "nothing"]
        for each in homes
    ]  # fmt: skip
    return markdown_table(("home", "goals", "lacks"), rows)


def models_section(homes: Sequence[HomeGoals]) -> str:
    """How many distinct models of each goal the homes have, and how many of them development saw.

    Empty where the models were not recorded.
    """
    if not all(each.models for each in homes):
        return ""
    models: dict[str, set[str]] = {goal: set() for goal in GOALS}
    unseen: set[str] = set()
    for each in homes:
        for goal, model in each.models:
            models[goal].add(model)
            if model.startswith(OWN_SHAPE) and not _in_development(each.home):
                unseen.add(model)
    rows = [
        [goal, sum(goal in each.goals for each in homes), len(models[goal]),
         sum(model.startswith(OWN_SHAPE) for model in models[goal]), len(models[goal] - unseen)]
        for goal in GOALS
        if models[goal]
    ]  # fmt: skip
    text = (
        "Different models that count as a goal, in all of these homes together; each of our own"
        f" shapes is one. Development drove in homes {HELD_OUT} to {FIRST_IN_TURN - 1} and"
        f" {DEVELOPMENT[0]} to {DEVELOPMENT[-1]}: it has seen all models that the catalogue holds"
        " out, and the shapes of those homes, but none of the shapes of other homes from"
        f" {FIRST_IN_TURN} on."
    )
    header = ("goal", "homes", "different models", "own shapes", "seen in development")
    return f"{markdown_table(header, rows)}\n\n{text}"


def _in_development(home: Home) -> bool:
    return isinstance(home, str) or home < FIRST_IN_TURN or home in DEVELOPMENT


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
