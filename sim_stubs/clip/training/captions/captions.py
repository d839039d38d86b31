"""Captions: texts whose truth on any patch can be computed, so that none is a wrong negative.

A caption is drawn for what a patch shows, above all for the thing, in one of many phrasings. No
text tells a withheld combination, `is_withheld` is asked about each; withheld phrasings are in a
list that is not drawn from.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sim_stubs.clip.training.captions import phrasing
from sim_stubs.clip.training.captions.facts import ATOM_INDEX, ATOMS, COUNTED, COUNTS, Fact, Facts
from sim_stubs.clip.training.captions.held_out_pairs import is_withheld
from sim_stubs.clip.training.captions.phrasing import NounPhrase, phrased, plural
from sim_stubs.clip.training.captions.unrelated_words import TOLD_WORDS
from sim_stubs.homes.vocabulary import COLOURS, MATERIALS, ROOMS, SYNONYMS, THINGS

FAMILIES: Mapping[str, float] = {
    "thing": 0.48, "colour": 0.45, "material": 0.04, "count": 0.04, "relation": 0.2, "room": 0.3,
}  # fmt: skip
"""How often a caption is about each sort of fact, where a patch shows such."""
OWN_NAME = 0.65
"""Part of captions that call a thing by the name of its class; the others take a synonym."""
TWO_FACTS = 0.15
"""Part of captions that tell something more."""
TRIES = 8
"""Draws until a caption is not withheld."""

Random = np.random.Generator
_STUFF = {adjective: stuff for stuff, adjective in MATERIALS.items()}


@dataclass(frozen=True, slots=True)
class Caption:
    """A text and what it says.

    Attributes:
        text: As a person may put it.
        atoms: Keys of the atoms that must all be shown; empty where no picture shows what it says.
    """

    text: str
    atoms: tuple[str, ...]


def draw_captions(atoms: Facts, patch: int, rng: Random, n: int) -> list[Caption]:
    """`n` captions that are true for a patch; fewer where it shows little that can be told."""
    shown = _Shown.of(atoms, patch)
    captions = (_tried(lambda: _caption(shown, rng)) for _ in range(n if shown.families else 0))
    return [caption for caption in captions if caption is not None]


def draw_contrasts(atoms: Facts, patch: int, rng: Random, n: int) -> list[Caption]:
    """Like `draw_captions`, then one word is changed: most are wrong for the patch."""
    shown = _Shown.of(atoms, patch)
    captions = (_tried(lambda: _contrast(shown, rng)) for _ in range(n if shown.families else 0))
    return [caption for caption in captions if caption is not None]


def draw_colours(atoms: Facts, patch: int, rng: Random) -> list[Caption]:
    """A thing of sure colour that a patch shows, in every colour, mostly wrong ones.

    Empty where it shows none; what is withheld is left out, be it right or wrong.
    """
    span = slice(atoms.starts[patch], atoms.starts[patch + 1])
    sure = atoms.indices[span][atoms.strengths[span] > 0]
    things = [ATOMS[i].thing for i in sure if ATOMS[i].family == "colour"]
    if not things:
        return []
    thing = _any(things, rng)
    texts = [Caption(f"{colour} {thing}", (f"{colour} {thing}",)) for colour in COLOURS]
    known = (text for text in texts if text.text in ATOM_INDEX)
    return [text for text in known if not is_withheld(text.text, text.atoms)]


def draw_negatives(rng: Random, n: int) -> list[Caption]:
    """`n` texts that no patch shows."""
    return [Caption(_nonsense(rng), ()) for _ in range(n)]


def target(captions: Sequence[Caption], atoms: Facts) -> NDArray[np.float32]:
    """How true (P, M) each caption is for each patch, 0 to 1; NaN: open to dispute.

    It is as true as the least shown of its atoms: 0 if one is not shown, else NaN if one is open.
    """
    named = [[ATOM_INDEX[key] for key in caption.atoms] for caption in captions]
    used = np.array(sorted({index for indices in named for index in indices}), np.int64)
    most = max((len(indices) for indices in named), default=0)
    column_of = {int(index): column for column, index in enumerate(used)}
    # Two more columns: what is always true fills captions up, what never is stands for nothing.
    columns = np.full((max(most, 1), len(captions)), len(used))
    for m, indices in enumerate(named):
        columns[: len(indices), m] = [column_of[index] for index in indices]
        if not indices:
            columns[0, m] = len(used) + 1
    strengths = np.ones((len(atoms), len(used) + 2), np.float32)
    strengths[:, :-2], strengths[:, -1] = atoms.columns(used), 0.0
    least = strengths[:, columns[0]]
    for other in columns[1:]:
        more = strengths[:, other]
        least = np.where((least == 0) | (more == 0), np.float32(0), np.minimum(least, more))
    return np.asarray(least, np.float32)


def caption_of(keys: Iterable[str], sentence: str, noun: NounPhrase) -> Caption:
    """That `keys` are shown, in the words of a phrasing about a noun."""
    return Caption(phrased(sentence, noun), tuple(keys))


def plain_noun(atom: Fact) -> NounPhrase:
    """The atom in the most common words: "red sofa", "plant next to a sofa", "two chairs"."""
    return _noun(atom, lambda ways: ways[0], lambda thing: thing)


@dataclass(frozen=True, slots=True)
class _Shown:
    """What a patch shows beyond dispute, by sort of fact: atoms and cumulative weights."""

    families: dict[str, tuple[list[Fact], NDArray[np.float64]]]
    whole_room: bool

    @staticmethod
    def of(atoms: Facts, patch: int) -> _Shown:
        span = slice(atoms.starts[patch], atoms.starts[patch + 1])
        strengths = atoms.strengths[span]
        sure = strengths > 0
        families: dict[str, tuple[list[Fact], list[float]]] = {}
        whole_room = False
        for index, strength in zip(atoms.indices[span][sure], strengths[sure], strict=True):
            atom = ATOMS[index]
            if atom.thing == "room":
                whole_room = True
                continue
            those, weights = families.setdefault(atom.family, ([], []))
            those.append(atom)
            weights.append(float(strength) ** 2)
        return _Shown(
            {name: (those, np.cumsum(weights)) for name, (those, weights) in families.items()},
            whole_room,
        )

    def draw(self, rng: Random, family: str = "") -> Fact:
        """An atom, of a sort where given; the clearer it is shown, the more often."""
        if not family:
            names = list(self.families)
            family = names[_index(np.cumsum([FAMILIES[name] for name in names]), rng)]
        atoms, cumulative = self.families[family]
        return atoms[_index(cumulative, rng)]


def _index(cumulative: NDArray[np.float64], rng: Random) -> int:
    return int(np.searchsorted(cumulative, rng.random() * cumulative[-1], side="right"))


def _any(choices: Sequence[str], rng: Random) -> str:
    return choices[int(rng.random() * len(choices))]


def _tried(draw: Callable[[], Caption | None]) -> Caption | None:
    """A caption that is not withheld; None if none comes."""
    for _ in range(TRIES):
        caption = draw()
        if caption is not None and not is_withheld(caption.text, caption.atoms):
            return caption
    return None


def _caption(shown: _Shown, rng: Random) -> Caption | None:
    atom = shown.draw(rng)
    if rng.random() < TWO_FACTS:
        return _caption_of_two(shown, atom, rng)
    return _sentence(atom, rng)


def _sentence(atom: Fact, rng: Random) -> Caption:
    ways: Sequence[str] = phrasing.PHRASINGS[_index(np.cumsum(phrasing.PHRASING_WEIGHTS), rng)]
    if atom.family == "room" and rng.random() < 0.25:
        ways = phrasing.ROOM
    noun = _noun(atom, lambda these: _any(these, rng), lambda thing: _name(thing, rng))
    return caption_of((atom.key,), _any(ways, rng), noun)


def _caption_of_two(shown: _Shown, atom: Fact, rng: Random) -> Caption | None:
    """One thing and where it is, or another: "a room with two beds", "a sofa and a table"."""
    if atom.family in ("relation", "room") or "thing" not in shown.families:
        return None
    noun = _noun(atom, lambda ways: _any(ways, rng), lambda thing: _name(thing, rng))
    a = noun.with_article
    if "room" in shown.families and rng.random() < 0.5:
        room = shown.draw(rng, "room").key
        ways = ("{} in the {}", "{} in a {}", "the {1} with {0}", "a {1} with {0}")
        return Caption(_any(ways, rng).format(a, _name(room, rng)), (atom.key, room))
    if shown.whole_room and rng.random() < 0.7:
        ways = ("a room with {}", "a room with {} in it", "the room with {}", "a room that has {}")
        return Caption(_any(ways, rng).format(a), ("room", atom.key))
    other = shown.draw(rng, "thing")
    if other.thing == atom.thing:
        return None
    b = NounPhrase.of(other.thing, _name(other.thing, rng)).with_article
    return Caption(_any(("{} and {}", "{} with {}"), rng).format(a, b), (atom.key, other.key))


def _contrast(shown: _Shown, rng: Random) -> Caption | None:
    atom = shown.draw(rng)
    match atom.family:
        case "room":
            changed = replace(atom, thing=_any(tuple(ROOMS), rng))
        case "count" if rng.random() < 0.5:
            changed = replace(atom, count=_any(COUNTS, rng))
        case "count":
            changed = replace(atom, thing=_any(COUNTED, rng))
        case "colour" if rng.random() < 0.7:
            changed = replace(atom, colour=_any(tuple(COLOURS), rng))
        case "material" if rng.random() < 0.5:
            changed = replace(atom, material=_any(tuple(MATERIALS.values()), rng))
        case "relation" if rng.random() < 0.5:
            changed = replace(atom, other=_any(THINGS, rng))
        case _:
            changed = replace(atom, thing=_any(THINGS, rng))
    return _sentence(changed, rng) if changed.key in ATOM_INDEX else None


def _name(thing: str, rng: Random) -> str:
    others = ROOMS.get(thing) or SYNONYMS.get(thing)
    return thing if not others or rng.random() < OWN_NAME else _any(others, rng)


def _noun(
    atom: Fact, choose: Callable[[Sequence[str]], str], name: Callable[[str], str]
) -> NounPhrase:
    """An atom as a noun phrase; `choose` picks the way to put it, `name` the words for a thing."""
    thing = name(atom.thing)
    if atom.colour:
        way = choose(phrasing.WITH_COLOUR)
        return NounPhrase.of(thing, way.format(noun=thing, colour=atom.colour))
    if atom.material:
        way = choose(phrasing.WITH_MATERIAL)
        stuff = _STUFF[atom.material]
        return NounPhrase.of(thing, way.format(noun=thing, material=atom.material, stuff=stuff))
    if atom.count:
        way = choose(phrasing.COUNTED[atom.count])
        return NounPhrase(way.format(plural(thing)), counted=False)
    if not atom.relation:
        return NounPhrase.of(thing)
    other = name(atom.other)
    way = choose(phrasing.RELATED[atom.relation])
    first = thing if way.startswith("{a}") else other
    a, b = NounPhrase.of(thing).with_article, NounPhrase.of(other).with_article
    words = way.replace("{a}", first, 1) if first == thing else way.replace("{b}", first, 1)
    return NounPhrase.of(first, words.format(a=a, b=b))


def _nonsense(rng: Random) -> str:
    """A word that has nothing to do with homes, two, or none, in any phrasing."""
    kind = rng.random()
    ways = phrasing.PHRASINGS[_index(np.cumsum(phrasing.PHRASING_WEIGHTS), rng)]
    word = _any(TOLD_WORDS, rng)
    if kind < 0.15:
        word = "".join(_any(_SYLLABLES, rng) for _ in range(int(rng.integers(2, 4))))
    elif kind < 0.27:
        word = f"{word} {_any(TOLD_WORDS, rng)}"
    elif kind < 0.35:
        a, b = NounPhrase(word).with_article, NounPhrase.of(_any(THINGS, rng)).with_article
        return f"{a} {_any(('on', 'next to', 'under', 'and'), rng)} {b}"
    return phrased(_any(ways, rng), NounPhrase(word))


_SYLLABLES = ("ba", "blor", "cen", "dra", "do", "fi", "frim", "gan", "glu", "ha", "ji", "kel",
              "kro", "lun", "mip", "mor", "na", "nex", "ol", "pa", "plin", "qua", "ra", "sni",
              "sor", "ta", "tib", "ul", "vex", "wam", "yor", "zan")  # fmt: skip
"""What words that do not exist are made of."""
