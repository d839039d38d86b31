"""Words that the embedded CLIP was not trained on, and what it knows for them.

The table `words.tsv` is made from WordNet (`training.wordnet`): a noun, the class
that it is a synonym or a kind of, and the number of hypernyms between them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from mapping.clip.reading import Reading
from vizbot.core.home_vocabulary import COLOURS, MATERIALS, class_of

TABLE = Path(__file__).with_name("words.tsv")
"""The table; lines that begin with # are comments."""
HEADING = """\
# Derived from WordNet 3.0, Copyright 2006 by Princeton University. All rights reserved.
# The licence is in words.LICENSE.txt. Made by python -m training.wordnet
# noun, class, hypernyms from the noun up to the class (0: a synonym)
"""
LONGEST = 4
"""Words of the longest name that is looked for."""
DETERMINERS = frozenset(
    {"a", "an", "the", "my", "our", "your", "his", "her", "their", "some", "any", "this", "that"}
)
BEHIND_A_NOUN = frozenset(
    {"in", "on", "near", "beside", "next", "by", "with", "under", "behind", "above", "below", "and"}
)
WORD = re.compile(r"[^\W_]+(?:['.-][^\W_]+)*")


@cache
def table() -> Mapping[str, tuple[str, int]]:
    """Class of each noun of the table, and the hypernyms up to it."""
    rows = (line.split("\t") for line in TABLE.read_text(encoding="utf-8").splitlines()
            if not line.startswith("#"))  # fmt: skip
    return {word: (name, int(steps)) for word, name, steps in rows}


def looked_up(noun: str) -> tuple[str, str] | None:
    """The class for a noun, singular or plural, and how they are related; None if none is known.

    The relation is a line like "loveseat: a kind of sofa".
    """
    entry = next((table()[form] for form in singulars(noun) if form in table()), None)
    if entry is None:
        return None
    name, steps = entry
    return name, f"{noun}: {'another word for' if steps == 0 else 'a kind of'} {name}"


def read_goal(text: str, trained: frozenset[str]) -> Reading:
    """A goal with each noun that was not trained put in words that were.

    `trained` are words of the phrasings that the encoder was trained on, without names of things.
    """
    parts = list(_parts(text, trained))
    notes, pieces, end = [], [], 0
    for i, part in enumerate(parts):
        if part.found is None or (i + 1 < len(parts) and parts[i + 1].unknown):
            continue
        pieces += [text[end : part.start], part.found[0]]
        notes.append(part.found[1])
        end = part.end
    unknown = _unknown_noun(parts)
    if unknown:
        notes.append(f"the rehearsal encoder was not trained on '{unknown}'")
    return Reading("".join([*pieces, text[end:]]), "; ".join(notes) or None)


@dataclass(frozen=True, slots=True)
class _Part:
    """A word, or a name of several.

    Attributes:
        words: In lower case.
        named: Whether it names a class of the vocabulary.
        found: What the table has for it.
        unknown: Whether it was not trained and the table does not have it.
    """

    words: str
    start: int
    end: int
    named: bool = False
    found: tuple[str, str] | None = None
    unknown: bool = False


def _parts(text: str, trained: frozenset[str]) -> Iterator[_Part]:
    """The text's words, the longest names first."""
    tokens = list(WORD.finditer(text.casefold().replace("\N{RIGHT SINGLE QUOTATION MARK}", "'")))
    words = [token[0] for token in tokens]
    i = 0
    while i < len(tokens):
        count, named, found = _name_at(words[i : i + LONGEST], trained)
        name = " ".join(words[i : i + count])
        known = named or found is not None or _is_trained(name, trained)
        yield _Part(
            name, tokens[i].start(), tokens[i + count - 1].end(), named, found, not known
        )  # fmt: skip
        i += count


def _name_at(
    words: Sequence[str], trained: frozenset[str]
) -> tuple[int, bool, tuple[str, str] | None]:
    """Words of the longest name at the beginning, whether it is a class, and its entry if not."""
    for count in range(len(words), 0, -1):
        name = " ".join(words[:count])
        if any(class_of(form) for form in singulars(name)):
            return count, True, None
        # "red carpet" is a carpet that is red; "can" in "can you see it" is no toilet.
        plain = words[0] not in COLOURS and not (count == 1 and _is_trained(name, trained))
        if plain and (found := looked_up(name)):
            return count, False, found
    return 1, False, None


def _is_trained(word: str, trained: frozenset[str]) -> bool:
    return word in (trained | DETERMINERS | {*COLOURS, *MATERIALS, *MATERIALS.values()})


def _unknown_noun(parts: Sequence[_Part]) -> str:
    """Words that are not trained where a thing's name is due; empty if there are none.

    "the walrus in the kitchen" has one, "locate the sofa" has none.
    """
    named = any(part.named or part.found for part in parts)
    for i, part in enumerate(parts):
        last = i
        while last + 1 < len(parts) and parts[last + 1].unknown:
            last += 1
        if not part.unknown:
            continue
        before = parts[i - 1].words if i else "the"
        behind = parts[last + 1] if last + 1 < len(parts) else None
        due = before in DETERMINERS or before in COLOURS or before in MATERIALS.values()
        is_noun = behind is None or behind.words in BEHIND_A_NOUN
        if not named or (due and is_noun):
            return " ".join(it.words for it in parts[i : last + 1])
    return ""


def singulars(noun: str) -> tuple[str, ...]:
    """A noun as it is, and what it may be the plural of."""
    endings = (("ies", "y"), ("ves", "f"), ("es", ""), ("s", ""))
    return (noun, *(noun[: -len(end)] + new for end, new in endings if noun.endswith(end)))
