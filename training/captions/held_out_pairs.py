"""Combinations that are held out of every caption, to examine the encoder on them.

Captions hold each word, each thing, each colour and each relation, but not these combinations. The
pictures of homes do show them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cache

import numpy as np
from numpy.typing import NDArray

from training.captions.facts import FACT_INDEX, FACTS
from vizbot.core.home_vocabulary import SYNONYMS, kinds

WITHHELD_COLOURS: tuple[tuple[str, str], ...] = (
    ("purple", "sofa"), ("brown", "sofa"), ("orange", "armchair"), ("white", "armchair"),
    ("green", "chair"), ("pink", "chair"), ("purple", "bed"), ("brown", "bed"),
    ("red", "carpet"), ("black", "carpet"), ("purple", "carpet"), ("white", "wardrobe"),
    ("blue", "desk"), ("red", "chest of drawers"), ("blue", "chest of drawers"),
    ("blue", "vase"), ("green", "vase"), ("black", "nightstand"), ("red", "curtain"),
    ("blue", "kitchen cabinet"), ("green", "table"),
)  # fmt: skip
"""Held-out pairs of colour and thing."""

WITHHELD_RELATIONS: tuple[tuple[str, str, str], ...] = (
    ("nightstand", "next to", "bed"), ("chair", "next to", "desk"), ("plant", "next to", "sofa"),
    ("refrigerator", "next to", "kitchen cabinet"), ("toilet", "next to", "bathtub"),
    ("chair", "next to", "radiator"), ("computer", "on", "desk"), ("vase", "on", "table"),
    ("microwave", "on", "kitchen cabinet"), ("lamp", "on", "nightstand"),
    ("picture", "above", "bed"), ("picture", "above", "sofa"),
    ("mirror", "above", "chest of drawers"), ("coffee table", "in front of", "sofa"),
    ("chair", "in front of", "desk"),
)  # fmt: skip
"""Held-out relations of two things."""


def relation_key(thing: str, relation: str, other: str) -> str:
    """Key of the fact of a relation; "next to" has one for both ways."""
    first, second = sorted((thing, other)) if relation == "next to" else (thing, other)
    return f"{first} {relation} {second}"


def is_withheld(text: str, facts: Iterable[str]) -> bool:
    """Whether a caption has a withheld combination, in any words."""
    words = re.findall(r"\w+", text)
    return any(
        colour in words and named.search(text) is not None
        for colour, named in _names_by_colour().items()
    ) or any(_is_withheld_relation(key) for key in facts)


@cache
def withheld_columns() -> Mapping[str, NDArray[np.int64]]:
    """Columns (2, N) in `FACTS` for each colour: withheld things of that colour, and the things."""
    columns: dict[str, list[tuple[int, int]]] = {}
    for i, fact in enumerate(FACTS):
        if fact.family == "colour" and is_withheld(fact.key, ()):
            columns.setdefault(fact.colour, []).append((i, FACT_INDEX[fact.thing]))
    return {colour: np.array(pairs, np.int64).T for colour, pairs in columns.items()}


@cache
def _names_by_colour() -> Mapping[str, re.Pattern[str]]:
    """For each colour, the words for things that must not be in one text with it."""
    names: dict[str, list[str]] = {}
    for colour, thing in WITHHELD_COLOURS:
        names.setdefault(colour, []).extend((thing, *SYNONYMS.get(thing, ())))
    return {
        colour: re.compile(rf"\b({'|'.join(map(re.escape, those))})(e?s)?\b")
        for colour, those in names.items()
    }


@cache
def _is_withheld_relation(key: str) -> bool:
    fact = FACTS[FACT_INDEX[key]]
    if not fact.relation:
        return False
    ways = ((fact.thing, fact.other), (fact.other, fact.thing))
    return any(
        relation == fact.relation and a in kinds(one) and b in kinds(other)
        for a, relation, b in WITHHELD_RELATIONS
        for one, other in (ways if relation == "next to" else ways[:1])
    )
