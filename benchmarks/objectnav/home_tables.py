"""Tables of the homes of a board: their goals, and the models of furniture that count as these."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.episodes.episode import Home, HomeGoals
from benchmarks.episodes.homes import OWN_SHAPE
from benchmarks.harness.tables import markdown_table
from sim_stubs.homes.furniture.home_shapes import DEVELOPMENT, FIRST_IN_TURN
from sim_stubs.homes.home import HELD_OUT
from sim_stubs.scoring.success import GOALS


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
