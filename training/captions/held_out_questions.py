"""Questions about held-out captions: which one of ten candidates does a patch show?

A question is put to the patches on which the right candidate is true and the nine others are not,
by `captions.target`. The candidates differ in one word (a thing's name counts as one).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from training.captions.captions import Caption, caption_of, plain_noun
from training.captions.facts import FACT_INDEX, Fact
from training.captions.held_out_pairs import WITHHELD_COLOURS, WITHHELD_RELATIONS, relation_key
from vizbot.core.home_vocabulary import COLOURS, THINGS, akin, kinds

CANDIDATES = 10
COMMON = (
    "bed", "chair", "sofa", "table", "carpet", "window", "toilet", "sink", "refrigerator", "tv",
    "bathtub", "wardrobe", "plant", "desk", "bookshelf", "lamp", "picture", "curtain", "door",
    "armchair", "oven", "mirror", "nightstand", "radiator",
)  # fmt: skip
"""Things that most homes have, for wrong candidates."""


@dataclass(frozen=True, slots=True)
class Question:
    """Ten captions of which the first is right.

    Attributes:
        candidates: The right caption, then nine wrong ones.
    """

    candidates: tuple[Caption, ...]

    @property
    def right(self) -> Caption:
        """The right caption, which is held out of training."""
        return self.candidates[0]


def _statement(fact: Fact) -> Caption:
    return caption_of((fact.key,), "{a}", plain_noun(fact))


def _others(thing: str, taken: tuple[str, ...] = ()) -> list[str]:
    """Things that cannot be mistaken for `thing`, common ones first."""
    alike = {*kinds(thing), *akin(thing), *taken}
    start = COMMON.index(thing) if thing in COMMON else 0
    turned = dict.fromkeys((*COMMON[start:], *COMMON[:start], *THINGS))
    return [
        other for other in turned if other not in alike and not {thing, *taken} & {*akin(other)}
    ]


def _of_colours() -> Iterator[Question]:
    for colour, thing in WITHHELD_COLOURS:
        right = Fact(thing, colour=colour)
        start = list(COLOURS).index(colour)
        turned = [*COLOURS][start:] + [*COLOURS][:start]
        colours = [other for other in turned if other not in (colour, *COLOURS[colour])]
        wrong = [replace(right, colour=other) for other in colours[:5]]
        wrong += [replace(right, thing=other) for other in _others(thing)]
        yield Question(tuple(_statement(fact) for fact in (right, *wrong)[:CANDIDATES]))


def _of_relations() -> Iterator[Question]:
    for thing, relation, other in WITHHELD_RELATIONS:
        right = Fact(thing, relation=relation, other=other)
        of_other = [replace(right, other=word) for word in _others(other, (thing,))]
        of_thing = [replace(right, thing=word) for word in _others(thing, (other,))]
        known = [[a for a in facts if _key(a) in FACT_INDEX] for facts in (of_other, of_thing)]
        wrong = [*known[0][:5], *known[1], *known[0][5:]]
        facts = (right, *wrong)[:CANDIDATES]
        yield Question(tuple(caption_of((_key(fact),), "{a}", plain_noun(fact)) for fact in facts))


def _key(fact: Fact) -> str:
    return relation_key(fact.thing, fact.relation, fact.other)


WITHHELD_COMBINATIONS: tuple[Question, ...] = (*_of_colours(), *_of_relations())
"""A question for each withheld colour of a thing and relation of two."""
