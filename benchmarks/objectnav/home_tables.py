"""Sections of the scoreboard's page about its homes: goals, models of furniture, their history."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.episodes.episode import Home, HomeGoals
from benchmarks.episodes.homes import OWN_SHAPE
from benchmarks.harness.bench_plan import QUICK_SHARE
from benchmarks.harness.tables import markdown_table
from sim_stubs.homes.furniture.catalogue import read_catalogue
from sim_stubs.homes.furniture.home_shapes import DEVELOPMENT, FIRST_IN_TURN
from sim_stubs.homes.furniture.split import counts
from sim_stubs.homes.home import HELD_OUT
from sim_stubs.homes.textures import surfaces
from sim_stubs.scoring.goals import GOALS

FORMER_RUNS = (37, 46, 52, 55, 56, 54, 56, 54, 57, 59)
"""Goals, of 61, that were reached in whole runs in homes 1000 to 1003, in order of time."""


def board_note(homes: Sequence[HomeGoals]) -> str:
    """Where the board is driven, where the search is developed, and what the former board was."""
    runs = ", ".join(map(str, FORMER_RUNS))
    return (
        f"The board is driven whole in homes {homes[0].home} to {homes[-1].home}: every goal that"
        " exists there. The search is developed in others, up to 999 and from 1100 to 1199; the"
        f" quick share is a part of homes {QUICK_SHARE[0]} to {QUICK_SHARE[-1]}. The board before"
        f" this one was homes 1000 to 1003, which were driven whole at least {len(FORMER_RUNS)}"
        f" times while their failures were read in between: of 61 goals {runs} were reached, in"
        " this order."
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
    single = [goal for goal in GOALS if len(models[goal]) == 1]
    text = (
        "Models that count as a goal, in all of these homes together. Painted or scaled, a model"
        " stays the same; every shape of our own is a model, named by the seed that drew it."
        f" Development drove in homes {HELD_OUT} to {FIRST_IN_TURN - 1} and {DEVELOPMENT[0]} to"
        f" {DEVELOPMENT[-1]}: all models that the catalogue holds out count as seen, and so do the"
        f" shapes of those homes. The shapes of other homes from {FIRST_IN_TURN} on are drawn for"
        " one home each, from a range of seeds of their own: none of them counts as seen. What"
        " failed on the boards in homes 1030 to 1057 was read before the next was driven in others."
    )
    if single:
        text += f" Of these goals a single model was seen: {', '.join(single)}."
    header = ("goal", "homes", "distinct models", "own shapes", "seen in development")
    return f"{text}\n\n{markdown_table(header, rows)}"


def _in_development(home: Home) -> bool:
    return isinstance(home, str) or home < FIRST_IN_TURN or home in DEVELOPMENT


def furniture_section() -> str:
    """A table of the models of each class: seen in training, and held out."""
    rows = [
        [label, count.training, count.held_out, "yes" if count.shapes else "no"]
        for label, count in counts(read_catalogue()).items()
    ]
    header = ("class", "models in training homes", "held out for these homes", "own shapes too")
    training, held_out = (
        sum(len(surfaces.members(family, side)) for family in surfaces.FAMILIES)
        for side in (False, True)
    )
    origin = (
        "The encoder was trained on other models of furniture than those it is judged on. Stairs"
        " that lead down have no model in the catalogue: they are procedural on both sides,"
        " which differ in their materials alone. So are the things that the catalogue has no model"
        " of: one program draws them on both sides, in other proportions, colours and materials."
    )
    floors = (
        f"Pictures of floors, walls, ceilings, doors and steps: {training} for training homes,"
        f" {held_out} held out for these, {surfaces.TRAINING_SHARE:.0%} of each of"
        f" {len(surfaces.FAMILIES)} families on the side of training."
    )
    return f"{origin}\n\n{floors}\n\n{markdown_table(header, rows)}"
