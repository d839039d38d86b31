"""The names of things and rooms that the robot knows, and what it makes of other words.

It knows the names that its encoder of rehearsals was trained on, other words for them, and the
nouns of the table `mapping/clip/embedded/words.tsv`. How near a text lies to these in the
encoder's own space says nothing about that: there "asdf" is nearer to a radio than most things are
to each other.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from jellyfish import damerau_levenshtein_distance

from mapping.clip.embedded.word_table import table
from vizbot.core.home_vocabulary import COLOURS, GROUPS, MATERIALS, ROOMS, SYNONYMS, THINGS
from vizbot.operator.session.vocabulary import HOUSEHOLD

NEAR = 0.72
"""Likeness of letters from which a name is offered for a word that is none."""
_MOST_SLIPS = 8
"""A goal with more unknown words is no known one with slips."""
_LONGEST = 5
"""Words of the longest name."""
_WORD = re.compile(r"[^\W_]+(?:['.-][^\W_]+)*")
_PLURALS = (
    ("people", "person"), ("shelves", "shelf"), ("ies", "y"), ("ches", "ch"), ("xes", "x"),
    ("shes", "sh"), ("sses", "ss"), ("s", ""),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a goal means.

    Attributes:
        words: What the encoder is asked for.
        notes: What was heard and what is meant, where these are different words.
        unread: Words left out since the robot cannot tell one thing from another by them.
        known: Whether the robot knows every word of it, and one of them is a name.
        near: A goal that it knows and that is written alike; None where it knows the goal, or none.
    """

    words: str
    notes: tuple[tuple[str, str], ...] = ()
    unread: tuple[str, ...] = ()
    known: bool = True
    near: str | None = None


class Lexicon:
    """Reads the names of things and rooms in one language.

    Attributes:
        names: What each name is to the encoder; keys are in small letters.
        offered: Names as they are written, by their small letters: these are offered for what is
            written alike.
    """

    def __init__(
        self,
        names: Mapping[str, str],
        small: Mapping[str, str],
        unread: Iterable[str],
        offered: Iterable[str],
    ) -> None:
        """Take over a language.

        Args:
            names: What each name is to the encoder; keys are in small letters.
            small: The same of words that may stand beside a name; empty for those that are left
                out.
            unread: Words that are left out beside a name, which is said.
            offered: Names as they are written, the usual one for a thing before others: these
                are offered for what is written alike.
        """
        self.names = names
        self.offered = {name.casefold(): name for name in offered}
        self._unread = frozenset(unread)
        self._small = {**small, **dict.fromkeys(self._unread, "")}
        self._own: dict[str, str] = {}
        for plain, name in self.offered.items():
            self._own.setdefault(names[plain], name)
        self._longest: dict[str, int] = {}  # words of the longest name that begins with a word
        for name in names:
            first, *others = name.split() or [""]
            self._longest[first] = max(self._longest.get(first, 0), 1 + len(others))
        words = {word for name in self.offered for word in name.split()}
        self._words = sorted({*words, *self._small})

    def read(self, goal: str, *, alone: bool = False) -> Meaning:
        """What a goal means.

        Args:
            goal: As it was said or typed, without a command around it.
            alone: Nothing but the goal was typed. Then all of its words must be known: "smash
                chair" is no chair of some kind, as in "go to the ikea chair".
        """
        meaning, unknown, beside = self._read(goal)
        strange = [*unknown, *beside]
        near = self._near(goal, strange) if strange else None
        if near is not None or (alone and beside):
            return replace(meaning, known=False, near=near)
        return meaning

    def is_name(self, words: str) -> bool:
        """Whether these words are the name of a thing or room, and nothing besides."""
        return _known_form(words.casefold(), self.names) is not None

    def knows(self, goal: str) -> bool:
        """Whether every word of a goal is known, and one of them is a name."""
        words = [found[0].casefold() for found in _WORD.finditer(_plain(goal))]
        named, i = False, 0
        while i < len(words):
            count, meant = self._name_at(words, i)
            if meant is None and self._beside(words[i]) is None:
                return False
            named = named or meant is not None or words[i] in self.names
            i += count
        return named

    def own(self, words: str) -> str:
        """What people call a thing or room that the encoder has another word for."""
        return self._own.get(words, words)

    def parts(self, goal: str, joint: str) -> tuple[str, ...]:
        """The goals in "sofa and bed", where each part of it has a name; else the goal alone."""
        parts = tuple(re.split(rf" {re.escape(joint)} ", goal))
        return parts if all(map(self.knows, parts)) else (goal,)

    def _read(self, goal: str) -> tuple[Meaning, list[str], list[str]]:
        """The meaning, without what may be meant instead; unknown words; those beside a name."""
        text = _plain(goal)
        tokens = list(_WORD.finditer(text))
        words = [token[0].casefold() for token in tokens]
        pieces, notes, named, end, i = [], [], False, 0, 0
        unknown, beside = list[str](), list[str]()
        strange = list[str]()  # unknown words that may belong to the next name
        unread = list[str]()
        while i < len(words):
            count, meant = self._name_at(words, i)
            start, stop = tokens[i].start(), tokens[i + count - 1].end()
            heard = text[start:stop]
            if meant is not None:
                named, beside, strange = True, [*beside, *strange], []
                singular = meant == _known_form(" ".join(words[i : i + count]), self.names)
                pieces += [text[end:start], heard if singular else meant]
                notes += [] if singular or meant == heard.casefold() else [(heard, meant)]
            elif (small := self._beside(words[i])) is not None:
                named = named or words[i] in self.names
                unknown, strange = [*unknown, *strange], []
                unread += [words[i]] if words[i] in self._unread else []
                pieces += [text[end:start], heard if small == words[i] else small]
            else:
                strange.append(words[i])
                pieces += [text[end:start], heard]
            end, i = stop, i + count
        read = " ".join("".join([*pieces, text[end:]]).split())
        unknown += strange
        meaning = Meaning(read or goal, tuple(notes), tuple(unread), named and not unknown)
        return meaning, unknown, beside

    def _beside(self, word: str) -> str | None:
        """What a word is that may stand beside a name: "granny's", too."""
        return word if word.endswith("'s") else self._small.get(word)

    def _name_at(self, words: Sequence[str], i: int) -> tuple[int, str | None]:
        """Words of the longest name that begins there, and what it is to the encoder."""
        longest = max(self._longest.get(form, 0) for form in singulars(words[i]))
        for count in range(min(longest, _LONGEST, len(words) - i), 0, -1):
            last = i + count == len(words)
            if count == 1 and words[i] in self._small and not last:
                break  # "light blue chair" is about no lamp
            form = _known_form(" ".join(words[i : i + count]), self.names)
            if form is not None:
                return count, self.names[form]
        return 1, None

    def _near(self, goal: str, unknown: Sequence[str]) -> str | None:
        """A goal that is known and written alike; None without one."""
        plain = " ".join(goal.casefold().split())
        if (whole := _nearest(plain, self.offered)) is not None:
            return self.offered[whole]
        if len(unknown) > _MOST_SLIPS:
            return None
        for word in unknown:
            if (better := _nearest(word, self._words)) is None:
                return None
            plain = re.sub(rf"\b{re.escape(word)}\b", better, plain, count=1)
        meaning, _, beside = self._read(plain)
        return plain if meaning.known and not beside else None


def english_lexicon(
    names: Mapping[str, str], small: Mapping[str, Sequence[str]], unread: Sequence[str]
) -> Lexicon:
    """The names of the encoder's own language.

    Args:
        names: For each name of the encoder's, more words for it, between bars.
        small: `keep` lists words that may stand beside a name, `dropped` those of these that are
            left out, `things` what names any thing, and `untrained` what only other encoders know.
        unread: As for `Lexicon`.
    """
    others = {word: name for group in (SYNONYMS, ROOMS) for name, them in group.items()
              for word in them}  # fmt: skip
    more = {word: name for name, words in names.items() for word in words.split("|")}
    known = {name: name for name in (*THINGS, *GROUPS, *ROOMS, *HOUSEHOLD)}
    wider = {noun: noun if steps else name for noun, (name, steps) in table().items()}
    kept = [*small["keep"], *COLOURS, *MATERIALS, *MATERIALS.values()]
    things = {name: name for name in (*small["things"], *small["untrained"])}
    return Lexicon(
        {**things, **wider, **others, **more, **known},
        {word: word for word in kept} | dict.fromkeys(small["dropped"], ""),
        unread,
        [*known, *others, *more, *small["untrained"]],
    )


def translating_lexicon(
    names: Mapping[str, str], small: Mapping[str, str], unread: Sequence[str]
) -> Lexicon:
    """The names of another language.

    Args:
        names: For each name of the encoder's, the words for it, the usual one first, between bars.
        small: For each word that may stand beside a name, in all its forms between bars, the
            encoder's; empty for those that are left out.
        unread: Words that are left out beside a name, which is said.
    """
    written = {word: name for name, words in names.items() for word in words.split("|")}
    translated = {word.casefold(): name for word, name in written.items()}
    beside = {word.casefold(): name for words, name in small.items() for word in words.split("|")}
    return Lexicon(translated, beside, unread, written)


def _plain(goal: str) -> str:
    return goal.replace("\N{RIGHT SINGLE QUOTATION MARK}", "'")


def _nearest(word: str, names: Iterable[str]) -> str | None:
    """The name that is written most alike; None where none is enough."""
    ranked = (
        (_likeness(form, name), name)
        for form in singulars(word)
        for name in names
        if abs(len(form) - len(name)) <= (1.0 - NEAR) * max(len(form), len(name))
    )
    likeness, name = max(ranked, default=(0.0, ""))
    return name if likeness >= NEAR else None


def _likeness(a: str, b: str) -> float:
    """How alike two names are written, 1 or less.

    Few slips are at the first letter. Letters in another order are one slip.
    """
    mixed = a != b and sorted(a) == sorted(b)
    edits = (1 if mixed else damerau_levenshtein_distance(a, b)) + (0.5 if a[:1] != b[:1] else 0.0)
    return 1.0 - edits / max(len(a), len(b), 1)


def _known_form(phrase: str, names: Mapping[str, str]) -> str | None:
    """The phrase, or what it may be the plural of, as a name; None if it is none."""
    return next((form for form in singulars(phrase) if form in names), None)


def singulars(phrase: str) -> tuple[str, ...]:
    """An English phrase, and what it may be the plural of, for example of "chests of drawers"."""
    first, of, rest = phrase.partition(" of ")
    ones = (first.removesuffix(end) + new + of + rest for end, new in _PLURALS
            if first.endswith(end))  # fmt: skip
    return (phrase, *ones)
