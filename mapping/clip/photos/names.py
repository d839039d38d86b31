"""The names that the classes of photographs go by, and the classes that a text names.

The table `names.tsv` is made from WordNet (`training.photo_names`). Kinds and synonyms of things of
a home that it does not have are looked up among the words of the embedded CLIP.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from jellyfish import damerau_levenshtein_distance
from numpy.typing import NDArray

from mapping.clip.embedded.word_table import (
    BEHIND_A_NOUN,
    DETERMINERS,
    LONGEST,
    WORD,
    looked_up,
    singulars,
)
from mapping.clip.reading import Reading
from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import class_of, kinds

CLASSES = 1000
"""Classes of the classifier, those of ImageNet (ILSVRC 2012), in its order."""
TABLE = Path(__file__).with_name("names.tsv")
"""The table; lines that begin with # are comments."""
HEADING = """\
# Derived from WordNet 3.0, Copyright 2006 by Princeton University. All rights reserved.
# The licence is in ../embedded/words.LICENSE.txt. Made by python -m training.photo_names
# names, their classes (numbers and ranges), what they are looked for by if not by themselves;
# names without classes are not looked for: behind them are those to offer in their place
"""
_OFFERED = 3
"""Names that are offered in place of one that is not known, where none is near it in meaning."""
_BEHIND_A_NOUN = BEHIND_A_NOUN | {"at", "for", "of", "or", "that", "without"}


@dataclass(frozen=True, slots=True)
class Name:
    """What a name stands for.

    Attributes:
        classes: Their numbers, in order; empty for one that is not looked for.
        remark: What it is looked for by, as "loveseat: a kind of sofa"; None if by itself.
        near: Names of a near meaning, for one that is not looked for.
    """

    classes: tuple[int, ...]
    remark: str | None = None
    near: tuple[str, ...] = ()


@cache
def table() -> Mapping[str, Name]:
    """Every name of the table."""
    found = {}
    for line in TABLE.read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            continue
        names, numbers, *behind = line.split("\t")
        for name in names.split(", "):
            if not numbers:
                found[name] = Name((), near=tuple(behind[0].split(", ")))
            else:
                by = f"{name}: looked for by {behind[0]}" if behind else None
                found[name] = Name(_numbers(numbers), by)
    return found


def read_name(text: str) -> Reading:
    """A text as the name that it ends with, before any preposition: "sofa" of "the red sofa".

    Raises:
        ConfigError: it has no name; the line offers three that have one.
    """
    words = _named_part(text)
    found = _found(words)
    if found is None or not found[1].classes:
        near = found[1].near if found else ()
        alike = "nearest in meaning" if near else "most alike in spelling"
        *others, last = (repr(name) for name in near or _spelt_alike(words))
        raise ConfigError(
            f"photos has no name for {words or text!r}; {alike} are {', '.join(others)} and {last}:"
            " ask for what it has a name for, or take an encoder of open words, as --clip ViT-B/32"
        )
    name, it = found
    alone = None if words == name else f"{words}: looked for as {name}, photos knows names alone"
    return Reading(name, "; ".join(filter(None, (alone, it.remark))) or None)


def distribution(text: str) -> NDArray[np.float32] | None:
    """Probabilities (1000,) of the classes of a picture that shows what a text names.

    They are even over the classes of its name; None for a text without one.
    """
    found = _found(_named_part(text))
    if found is None or not found[1].classes:
        return None
    shares = np.zeros(CLASSES, np.float32)
    shares[list(found[1].classes)] = 1.0 / len(found[1].classes)
    return shares


def _spelt_alike(words: str) -> list[str]:
    """Three names: spelt almost alike, then with a word in common, then those of a home."""
    said = set(words.split())

    def rank(name: str) -> tuple[bool, bool, bool, int, str]:
        distance = damerau_levenshtein_distance(words, name)
        misspelt, related = distance <= len(words) // 4, not said.isdisjoint(name.split())
        return not misspelt, not related, class_of(name) != name, distance, name

    return sorted((name for name, it in table().items() if it.classes), key=rank)[:_OFFERED]


def _named_part(text: str) -> str:
    """The words before any preposition, in lower case, without an article.

    That of a name, as of "chest of drawers", is none.
    """
    said = WORD.findall(text.casefold().replace("\N{RIGHT SINGLE QUOTATION MARK}", "'"))
    while said and said[0] in DETERMINERS:
        said = said[1:]
    for at in range(1, len(said)):
        if said[at] in _BEHIND_A_NOUN and not _is_within_name(said, at):
            return " ".join(said[:at])
    return " ".join(said)


def _is_within_name(said: Sequence[str], at: int) -> bool:
    """Whether a word is neither the first nor the last of a name."""
    spans = (
        " ".join(said[start:end])
        for start in range(max(0, at - LONGEST), at)
        for end in range(at + 2, start + LONGEST + 1)
    )
    return any(span in table() or class_of(span) for span in spans)


def _found(words: str) -> tuple[str, Name] | None:
    """The longest name that some words end with, and what it stands for."""
    said = words.split()
    for start in range(max(0, len(said) - LONGEST), len(said)):
        noun = " ".join(said[start:])
        if (it := _entry(noun)) is not None:
            return noun, it
    return None


def _entry(noun: str) -> Name | None:
    """What a noun stands for, singular or plural; None for one that is not known."""
    known = table()
    for form in singulars(noun):
        own = class_of(form)
        for kind in (form,) if own is None else kinds(own):
            if kind in known:
                wider = f"{form}: a kind of {kind}" if own not in (None, kind) else None
                return replace(known[kind], remark=wider or known[kind].remark)
    alike, relation = looked_up(noun) or ("", "")
    return replace(known[alike], remark=relation) if alike in known else None


def _numbers(text: str) -> tuple[int, ...]:
    """Numbers of a text like "3,7-9"."""
    ranges = (part.partition("-") for part in text.split(","))
    return tuple(
        number for low, _, high in ranges for number in range(int(low), int(high or low) + 1)
    )
