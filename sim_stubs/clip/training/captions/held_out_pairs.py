"""What is kept out of every caption, so that the encoder can be examined on what it was never told.

Each word is told, and so is each thing, each colour and each relation; only the combinations are
not. The pictures of homes do show them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cache

import numpy as np
from numpy.typing import NDArray

from sim_stubs.clip.training.captions.facts import ATOM_INDEX, ATOMS
from sim_stubs.homes.vocabulary import SYNONYMS, kinds

WITHHELD_COLOURS: tuple[tuple[str, str], ...] = (
    ("purple", "sofa"), ("brown", "sofa"), ("orange", "armchair"), ("white", "armchair"),
    ("green", "chair"), ("pink", "chair"), ("purple", "bed"), ("brown", "bed"),
    ("red", "carpet"), ("black", "carpet"), ("purple", "carpet"), ("white", "wardrobe"),
    ("blue", "desk"), ("red", "chest of drawers"), ("blue", "chest of drawers"),
    ("blue", "vase"), ("green", "vase"), ("black", "nightstand"), ("red", "curtain"),
    ("blue", "kitchen cabinet"), ("green", "table"),
)  # fmt: skip
"""Colours of things."""

WITHHELD_RELATIONS: tuple[tuple[str, str, str], ...] = (
    ("nightstand", "next to", "bed"), ("chair", "next to", "desk"), ("plant", "next to", "sofa"),
    ("refrigerator", "next to", "kitchen cabinet"), ("toilet", "next to", "bathtub"),
    ("chair", "next to", "radiator"), ("computer", "on", "desk"), ("vase", "on", "table"),
    ("microwave", "on", "kitchen cabinet"), ("lamp", "on", "nightstand"),
    ("picture", "above", "bed"), ("picture", "above", "sofa"),
    ("mirror", "above", "chest of drawers"), ("coffee table", "in front of", "sofa"),
    ("chair", "in front of", "desk"),
)  # fmt: skip
"""How two things stand to each other."""


def relation_key(thing: str, relation: str, other: str) -> str:
    """Key of the atom of a relation; "next to" has one for both ways."""
    first, second = sorted((thing, other)) if relation == "next to" else (thing, other)
    return f"{first} {relation} {second}"


def is_withheld(text: str, atoms: Iterable[str]) -> bool:
    """Whether a caption would tell a withheld combination, in any words."""
    words = re.findall(r"\w+", text)
    return any(
        colour in words and named.search(text) is not None
        for colour, named in _names_by_colour().items()
    ) or any(_is_withheld_relation(key) for key in atoms)


@cache
def withheld_atoms() -> Mapping[str, NDArray[np.int64]]:
    """For each colour, columns (2, N) in `ATOMS` of withheld things of it, and of those things."""
    columns: dict[str, list[tuple[int, int]]] = {}
    for i, atom in enumerate(ATOMS):
        if atom.family == "colour" and is_withheld(atom.key, ()):
            columns.setdefault(atom.colour, []).append((i, ATOM_INDEX[atom.thing]))
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
    atom = ATOMS[ATOM_INDEX[key]]
    if not atom.relation:
        return False
    ways = ((atom.thing, atom.other), (atom.other, atom.thing))
    return any(
        relation == atom.relation and a in kinds(one) and b in kinds(other)
        for a, relation, b in WITHHELD_RELATIONS
        for one, other in (ways if relation == "next to" else ways[:1])
    )
