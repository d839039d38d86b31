"""Facts that a picture of a home can show, and how clearly a patch shows each.

A fact is a thing ("sofa"), a thing of a colour or material ("red sofa", "wooden table"), several
("two chair", "several chair"), a relation ("plant on table"), a room ("kitchen"), or that a whole
room is seen ("room"). Texts are built of facts, so that their truth on any patch can be computed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray

from vizbot.core.home_vocabulary import COLOURS, GROUPS, MATERIALS, ROOMS, THINGS

COUNTS = ("two", "several")
"""Exactly two; three or more."""
COUNTED = (
    "armchair", "bed", "chair", "curtain", "lamp", "nightstand", "office chair", "picture",
    "plant", "single bed", "sofa", "stool", "table", "table lamp", "wardrobe", "window",
)  # fmt: skip
"""Things that are counted."""

_ON_TOP = (
    "aquarium", "backpack", "blender", "book", "bottle", "bowl", "box", "cardboard box", "clock",
    "coffee machine", "computer", "cup", "cushion", "electric fan", "fan", "flowers", "kettle",
    "lamp", "laptop", "microwave", "monitor", "plant", "plate", "printer", "radio", "speaker",
    "table lamp", "teddy bear", "telephone", "toaster", "towel", "tv", "vase",
)  # fmt: skip
_TOPS = (
    "bed", "bench", "bookshelf", "cabinet", "chair", "chest of drawers", "coffee table", "desk",
    "dining table", "kitchen cabinet", "nightstand", "sofa", "stool", "table", "tv stand",
    "washing machine",
)  # fmt: skip
_ON_CARPET = (
    "armchair", "bed", "chair", "coffee table", "dining table", "office chair", "plant", "sofa",
    "stool", "table",
)  # fmt: skip
_BESIDE = (
    "armchair", "bathtub", "bed", "bench", "bidet", "bookshelf", "cabinet", "chair",
    "chest of drawers", "coffee table", "cardboard box", "crib", "desk", "dining table", "door",
    "dressing table", "dryer", "electric fan", "fan", "fireplace", "floor lamp", "guitar",
    "kitchen cabinet", "lamp", "laundry basket", "nightstand", "office chair", "oven", "piano",
    "plant", "radiator", "refrigerator", "shower", "sink", "sofa", "stairs", "stool", "suitcase",
    "table", "teddy bear", "toilet", "trash can", "tv stand", "wardrobe", "washing machine",
    "window",
)  # fmt: skip
_BEFORE = ("armchair", "bench", "carpet", "chair", "coffee table", "office chair", "plant",
           "sofa", "stool", "table")  # fmt: skip
_FRONTS = (
    "bathtub", "bed", "bookshelf", "chest of drawers", "desk", "dressing table", "fireplace",
    "kitchen cabinet", "mirror", "oven", "piano", "sink", "sofa", "toilet", "tv", "tv stand",
    "wardrobe", "washing machine", "window",
)  # fmt: skip
_HANGING = ("ceiling lamp", "clock", "lamp", "mirror", "picture", "range hood", "shelf", "tv",
            "wall cabinet", "wall lamp", "window")  # fmt: skip
_BELOW = (
    "armchair", "bathtub", "bed", "bench", "chest of drawers", "coffee table", "desk",
    "dining table", "fireplace", "hob", "kitchen cabinet", "nightstand", "oven", "radiator",
    "sink", "sofa", "table", "toilet", "tv stand", "washing machine",
)  # fmt: skip

RELATIONS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "on": tuple([(a, b) for a in _ON_TOP for b in _TOPS] + [(a, "carpet") for a in _ON_CARPET]),
    "next to": tuple((a, b) for a in _BESIDE for b in _BESIDE if a < b),
    "in front of": tuple((a, b) for a in _BEFORE for b in _FRONTS if a != b),
    "above": tuple((a, b) for a in _HANGING for b in _BELOW),
}
"""Pairs of things of each relation; "next to" has one pair for both directions."""


@dataclass(frozen=True, slots=True)
class Fact:
    """A fact that a picture can show.

    Attributes:
        thing: A class, a group or a room; "room" for any room seen as a whole.
        colour: Colour of the thing, or empty.
        material: Material of the thing as an adjective, or empty.
        count: "two", "several", or empty.
        relation: Relation of the thing to `other`, or empty.
        other: The other thing of the relation, or empty.
    """

    thing: str
    colour: str = ""
    material: str = ""
    count: str = ""
    relation: str = ""
    other: str = ""

    @property
    def key(self) -> str:
        """The fact in words."""
        words = (self.count, self.colour, self.material, self.thing, self.relation, self.other)
        return " ".join(word for word in words if word)

    @property
    def family(self) -> str:
        """Kind of the fact: thing, colour, material, count, relation or room."""
        if self.thing in ROOMS or self.thing == "room":
            return "room"
        parts = {"colour": self.colour, "material": self.material, "count": self.count,
                 "relation": self.relation}  # fmt: skip
        return next((name for name, word in parts.items() if word), "thing")


def _all_facts() -> tuple[Fact, ...]:
    things = (*THINGS, *GROUPS)
    return (
        *(Fact(room) for room in (*ROOMS, "room")),
        *(Fact(thing) for thing in things),
        *(Fact(thing, colour=colour) for thing in THINGS for colour in COLOURS),
        *(Fact(thing, material=word) for thing in THINGS for word in MATERIALS.values()),
        *(Fact(thing, count=count) for thing in COUNTED for count in COUNTS),
        *(Fact(a, relation=relation, other=b) for relation, pairs in RELATIONS.items()
          for a, b in pairs),
    )  # fmt: skip


FACTS: tuple[Fact, ...] = _all_facts()
"""Every fact, in the order of the columns of `Facts`."""
FACT_INDEX: Mapping[str, int] = {fact.key: i for i, fact in enumerate(FACTS)}
"""Column of each fact by its key."""
FACTS_DIGEST = sha256("\n".join(FACT_INDEX).encode()).hexdigest()[:16]
"""Digest of the vocabulary, which stored columns belong to."""


@dataclass(frozen=True, slots=True, eq=False)
class Facts:
    """Facts of P patches: a sparse (P, K) matrix by rows, K the number of `FACTS`.

    Attributes:
        starts: (P + 1,) int64, where each patch's entries start.
        indices: (E,) int32, column in `FACTS` of each entry.
        strengths: (E,) float32 above 0 to 1, how clearly the fact is shown; NaN where it is
            disputable and left out. A fact without an entry is not shown.
    """

    starts: NDArray[np.int64]
    indices: NDArray[np.int32]
    strengths: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.starts) - 1

    def columns(self, indices: NDArray[np.int64]) -> NDArray[np.float32]:
        """Strengths (P, C) of the facts `indices` (C,), each named once."""
        column_of = np.full(len(FACTS), -1)
        column_of[indices] = np.arange(len(indices))
        columns = column_of[self.indices]
        rows = np.repeat(np.arange(len(self)), np.diff(self.starts))
        dense = np.zeros((len(self), len(indices)), np.float32)
        dense[rows[columns >= 0], columns[columns >= 0]] = self.strengths[columns >= 0]
        return dense

    def take(self, patches: NDArray[np.int64]) -> Facts:
        """Facts of some patches, in that order."""
        counts = np.diff(self.starts)[patches]
        starts = np.concatenate([[0], np.cumsum(counts)])
        entries = np.arange(starts[-1]) + np.repeat(self.starts[patches] - starts[:-1], counts)
        return Facts(starts, self.indices[entries], self.strengths[entries])

    @staticmethod
    def from_dense(strengths: NDArray[np.float32], indices: NDArray[np.int64]) -> Facts:
        """Facts with strengths (P, C) of the facts `indices` (C,)."""
        rows, columns = np.nonzero(strengths != 0)
        starts = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=len(strengths)))])
        return Facts(starts, indices[columns].astype(np.int32), strengths[rows, columns])

    @staticmethod
    def joined(several: Sequence[Facts]) -> Facts:
        """All patches of `several`, one after another."""
        counts = np.concatenate([np.diff(facts.starts) for facts in several])
        return Facts(
            np.concatenate([[0], np.cumsum(counts)]),
            np.concatenate([facts.indices for facts in several]),
            np.concatenate([facts.strengths for facts in several]),
        )
