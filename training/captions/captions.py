"""Captions: texts whose truth on any patch can be computed, so that none is a wrong negative.

A caption is drawn for what a patch shows, above all for the thing, in one of many phrasings. No
text has a withheld combination, which `is_withheld` checks for each. Withheld phrasings are in a
list that is not drawn from.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from training.captions import phrasing
from training.captions.facts import COUNTED, COUNTS, FACT_INDEX, FACTS, Fact, Facts
from training.captions.held_out_pairs import is_withheld, withheld_columns
from training.captions.phrasing import NounPhrase, phrased, plural_noun
from training.captions.unrelated_words import CAPTION_WORDS
from vizbot.core.home_vocabulary import COLOURS, GROUPS, MATERIALS, ROOMS, SYNONYMS, THINGS

FAMILIES: Mapping[str, float] = {
    "thing": 0.48, "colour": 0.45, "material": 0.04, "count": 0.04, "relation": 0.2, "room": 0.3,
}  # fmt: skip
"""Weight of each kind of fact, where a patch shows one."""
OWN_NAME = 0.65
"""Share of captions that call a thing by the name of its class; the others use a synonym."""
TWO_FACTS = 0.15
"""Share of captions with a second fact."""
NAMES = (*THINGS, *GROUPS, *ROOMS)
"""Bare names, by which most goals are given; they are in every step."""
TRIES = 8
"""Draws until a caption is not withheld."""

Random = np.random.Generator
_STUFF = {adjective: stuff for stuff, adjective in MATERIALS.items()}


@dataclass(frozen=True, slots=True)
class Caption:
    """A text and the facts that make it true.

    Attributes:
        text: The text, as a person may write it.
        facts: Keys of the facts that must all be shown; empty for a text that no picture shows.
    """

    text: str
    facts: tuple[str, ...]


def draw_captions(facts: Facts, patch: int, rng: Random, n: int) -> list[Caption]:
    """`n` captions that are true for a patch; fewer where it shows few facts."""
    shown = _Shown.from_facts(facts, patch)
    captions = (_tried(lambda: _caption(shown, rng)) for _ in range(n if shown.families else 0))
    return [caption for caption in captions if caption is not None]


def draw_contrasts(facts: Facts, patch: int, rng: Random, n: int) -> list[Caption]:
    """Like `draw_captions`, then one word is changed: most are wrong for the patch."""
    shown = _Shown.from_facts(facts, patch)
    captions = (_tried(lambda: _contrast(shown, rng)) for _ in range(n if shown.families else 0))
    return [caption for caption in captions if caption is not None]


def draw_colours(facts: Facts, patch: int, rng: Random) -> list[Caption]:
    """Captions of a thing of certain colour in a patch, in every colour, most of them wrong.

    Empty where the patch shows no such thing. Withheld captions are left out, right or wrong.
    """
    span = slice(facts.starts[patch], facts.starts[patch + 1])
    sure = facts.indices[span][facts.strengths[span] > 0]
    things = [FACTS[i].thing for i in sure if FACTS[i].family == "colour"]
    if not things:
        return []
    thing = _any(things, rng)
    texts = [Caption(f"{colour} {thing}", (f"{colour} {thing}",)) for colour in COLOURS]
    known = (text for text in texts if text.text in FACT_INDEX)
    return [text for text in known if not is_withheld(text.text, text.facts)]


def draw_negatives(rng: Random, n: int) -> list[Caption]:
    """`n` texts that are true for no patch."""
    return [Caption(_nonsense(rng), ()) for _ in range(n)]


def target(captions: Sequence[Caption], facts: Facts) -> NDArray[np.float32]:
    """How true (P, M) each caption is for each patch, 0 to 1; NaN where it is disputable.

    A caption is as true as the least shown of its facts: 0 if one is not shown, else NaN if one is
    disputable.
    """
    named = [[FACT_INDEX[key] for key in caption.facts] for caption in captions]
    used = np.array(sorted({index for indices in named for index in indices}), np.int64)
    most = max((len(indices) for indices in named), default=0)
    column_of = {int(index): column for column, index in enumerate(used)}
    # Two more columns: what is always true fills captions up, what never is stands for nothing.
    columns = np.full((max(most, 1), len(captions)), len(used))
    for m, indices in enumerate(named):
        columns[: len(indices), m] = [column_of[index] for index in indices]
        if not indices:
            columns[0, m] = len(used) + 1
    strengths = np.ones((len(facts), len(used) + 2), np.float32)
    strengths[:, :-2], strengths[:, -1] = facts.columns(used), 0.0
    least = strengths[:, columns[0]]
    for other in columns[1:]:
        more = strengths[:, other]
        least = np.where((least == 0) | (more == 0), np.float32(0), np.minimum(least, more))
    return np.asarray(least, np.float32)


def caption_of(keys: Iterable[str], sentence: str, noun: NounPhrase) -> Caption:
    """A caption that the facts `keys` are shown, in a phrasing about a noun."""
    return Caption(phrased(sentence, noun), tuple(keys))


def plain_noun(fact: Fact) -> NounPhrase:
    """The fact in the most common words: "red sofa", "plant next to a sofa", "two chairs"."""
    return _noun(fact, lambda ways: ways[0], lambda thing: thing)


def draw_texts(facts: Facts, rng: np.random.Generator) -> list[Caption]:
    """A caption for each patch, contrasts and all colours for some, bare names, and negatives."""
    count = len(facts)
    captions = [caption for i in range(count) for caption in draw_captions(facts, i, rng, 1)]
    for i in rng.choice(count, count // 2, replace=False):
        captions += draw_contrasts(facts, int(i), rng, 1)
    for i in rng.choice(count, count // 8, replace=False):
        captions += draw_colours(facts, int(i), rng)
    captions += draw_negatives(rng, count // 4)
    return captions + [Caption(name, (name,)) for name in NAMES]


def truth_of(
    captions: Sequence[Caption], facts: Facts, changed: NDArray[np.bool_]
) -> NDArray[np.float32]:
    """`target` (P, M), NaN for captions with colours where patches are `changed` (P,).

    A caption with a colour is also NaN for a patch that shows a withheld thing of this colour.
    "purple sofa" is in no caption; if "purple chair" and all else that is purple were wrong for a
    purple sofa, the encoder would learn that it is not purple.
    """
    truth = target(captions, facts)
    colours_of = [{FACTS[FACT_INDEX[key]].colour for key in it.facts} - {""} for it in captions]
    truth[np.ix_(changed, np.array([bool(colours) for colours in colours_of]))] = np.nan
    for colour, (of_it, bare) in withheld_columns().items():
        strengths = facts.columns(of_it)
        shown = (strengths > 0) | (np.isnan(strengths) & (facts.columns(bare) > 0))
        of_colour = np.array([colour in colours for colours in colours_of])
        rows = np.ix_(shown.any(axis=1), of_colour)
        truth[rows] = np.where(truth[rows] == 0, np.nan, truth[rows])
    return truth


@dataclass(frozen=True, slots=True)
class _Shown:
    """Certain facts of a patch, by kind: facts and cumulative weights."""

    families: dict[str, tuple[list[Fact], NDArray[np.float64]]]
    whole_room: bool

    @staticmethod
    def from_facts(facts: Facts, patch: int) -> _Shown:
        span = slice(facts.starts[patch], facts.starts[patch + 1])
        strengths = facts.strengths[span]
        sure = strengths > 0
        families: dict[str, tuple[list[Fact], list[float]]] = {}
        whole_room = False
        for index, strength in zip(facts.indices[span][sure], strengths[sure], strict=True):
            fact = FACTS[index]
            if fact.thing == "room":
                whole_room = True
                continue
            those, weights = families.setdefault(fact.family, ([], []))
            those.append(fact)
            weights.append(float(strength) ** 2)
        return _Shown(
            {name: (those, np.cumsum(weights)) for name, (those, weights) in families.items()},
            whole_room,
        )

    def draw(self, rng: Random, family: str = "") -> Fact:
        """Draw a fact, of one kind where given; clearly shown facts come more often."""
        if not family:
            names = list(self.families)
            family = names[_index(np.cumsum([FAMILIES[name] for name in names]), rng)]
        facts, cumulative = self.families[family]
        return facts[_index(cumulative, rng)]


def _index(cumulative: NDArray[np.float64], rng: Random) -> int:
    return int(np.searchsorted(cumulative, rng.random() * cumulative[-1], side="right"))


def _any(choices: Sequence[str], rng: Random) -> str:
    return choices[int(rng.random() * len(choices))]


def _tried(draw: Callable[[], Caption | None]) -> Caption | None:
    """A drawn caption that is not withheld; None after TRIES draws."""
    for _ in range(TRIES):
        caption = draw()
        if caption is not None and not is_withheld(caption.text, caption.facts):
            return caption
    return None


def _caption(shown: _Shown, rng: Random) -> Caption | None:
    fact = shown.draw(rng)
    if rng.random() < TWO_FACTS:
        return _caption_of_two(shown, fact, rng)
    return _sentence(fact, rng)


def _sentence(fact: Fact, rng: Random) -> Caption:
    ways: Sequence[str] = phrasing.PHRASINGS[_index(np.cumsum(phrasing.PHRASING_WEIGHTS), rng)]
    if fact.family == "room" and rng.random() < 0.25:
        ways = phrasing.ROOM
    noun = _noun(fact, lambda these: _any(these, rng), lambda thing: _name(thing, rng))
    return caption_of((fact.key,), _any(ways, rng), noun)


def _caption_of_two(shown: _Shown, fact: Fact, rng: Random) -> Caption | None:
    """A caption of two facts: "a room with two beds", "a sofa and a table"."""
    if fact.family in ("relation", "room") or "thing" not in shown.families:
        return None
    noun = _noun(fact, lambda ways: _any(ways, rng), lambda thing: _name(thing, rng))
    a = noun.with_article
    if "room" in shown.families and rng.random() < 0.5:
        room = shown.draw(rng, "room").key
        ways = ("{} in the {}", "{} in a {}", "the {1} with {0}", "a {1} with {0}")
        return Caption(_any(ways, rng).format(a, _name(room, rng)), (fact.key, room))
    if shown.whole_room and rng.random() < 0.7:
        ways = ("a room with {}", "a room with {} in it", "the room with {}", "a room that has {}")
        return Caption(_any(ways, rng).format(a), ("room", fact.key))
    other = shown.draw(rng, "thing")
    if other.thing == fact.thing:
        return None
    b = NounPhrase.from_name(other.thing, _name(other.thing, rng)).with_article
    return Caption(_any(("{} and {}", "{} with {}"), rng).format(a, b), (fact.key, other.key))


def _contrast(shown: _Shown, rng: Random) -> Caption | None:
    fact = shown.draw(rng)
    match fact.family:
        case "room":
            changed = replace(fact, thing=_any(tuple(ROOMS), rng))
        case "count" if rng.random() < 0.5:
            changed = replace(fact, count=_any(COUNTS, rng))
        case "count":
            changed = replace(fact, thing=_any(COUNTED, rng))
        case "colour" if rng.random() < 0.7:
            changed = replace(fact, colour=_any(tuple(COLOURS), rng))
        case "material" if rng.random() < 0.5:
            changed = replace(fact, material=_any(tuple(MATERIALS.values()), rng))
        case "relation" if rng.random() < 0.5:
            changed = replace(fact, other=_any(THINGS, rng))
        case _:
            changed = replace(fact, thing=_any(THINGS, rng))
    return _sentence(changed, rng) if changed.key in FACT_INDEX else None


def _name(thing: str, rng: Random) -> str:
    others = ROOMS.get(thing) or SYNONYMS.get(thing)
    return thing if not others or rng.random() < OWN_NAME else _any(others, rng)


def _noun(
    fact: Fact, choose: Callable[[Sequence[str]], str], name: Callable[[str], str]
) -> NounPhrase:
    """A fact as a noun phrase; `choose` picks the way to put it, `name` the words for a thing."""
    thing = name(fact.thing)
    if fact.colour:
        way = choose(phrasing.WITH_COLOUR)
        return NounPhrase.from_name(thing, way.format(noun=thing, colour=fact.colour))
    if fact.material:
        way = choose(phrasing.WITH_MATERIAL)
        stuff = _STUFF[fact.material]
        return NounPhrase.from_name(
            thing, way.format(noun=thing, material=fact.material, stuff=stuff)
        )
    if fact.count:
        way = choose(phrasing.COUNTED[fact.count])
        return NounPhrase(way.format(plural_noun(thing)), counted=False)
    if not fact.relation:
        return NounPhrase.from_name(thing)
    other = name(fact.other)
    way = choose(phrasing.RELATED[fact.relation])
    first = thing if way.startswith("{a}") else other
    a, b = NounPhrase.from_name(thing).with_article, NounPhrase.from_name(other).with_article
    words = way.replace("{a}", first, 1) if first == thing else way.replace("{b}", first, 1)
    return NounPhrase.from_name(first, words.format(a=a, b=b))


def _nonsense(rng: Random) -> str:
    """A text of unrelated or invented words, in any phrasing."""
    kind = rng.random()
    ways = phrasing.PHRASINGS[_index(np.cumsum(phrasing.PHRASING_WEIGHTS), rng)]
    word = _any(CAPTION_WORDS, rng)
    if kind < 0.15:
        word = "".join(_any(_SYLLABLES, rng) for _ in range(int(rng.integers(2, 4))))
    elif kind < 0.27:
        word = f"{word} {_any(CAPTION_WORDS, rng)}"
    elif kind < 0.35:
        a, b = NounPhrase(word).with_article, NounPhrase.from_name(_any(THINGS, rng)).with_article
        return f"{a} {_any(('on', 'next to', 'under', 'and'), rng)} {b}"
    return phrased(_any(ways, rng), NounPhrase(word))


_SYLLABLES = ("ba", "blor", "cen", "dra", "do", "fi", "frim", "gan", "glu", "ha", "ji", "kel",
              "kro", "lun", "mip", "mor", "na", "nex", "ol", "pa", "plin", "qua", "ra", "sni",
              "sor", "ta", "tib", "ul", "vex", "wam", "yor", "zan")  # fmt: skip
"""Syllables of invented words."""
