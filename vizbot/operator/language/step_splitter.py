"""Cuts a line of text into the steps that it asks for, and these free of what asks for nothing.

"Hi, would you mind going to the sofa first, and then coming back?" has two steps, "go to the sofa"
and "come back": politeness and fillers are left out, other spellings and forms of words are
replaced, and what is to be done before something else comes first.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from jellyfish import damerau_levenshtein_distance

MOST_STEPS = 60
"""A line of more steps is not read."""
_MOST_COURTESIES = 12
"""Words of courtesy before an order."""
_MOST_OPENINGS = 10
"""Openings, and as many closings, that are taken from a step."""
_LONGEST_CLOSING = 40
"""Letters at the end of a step among which a closing is looked for."""
_KEPT = 1024
"""Lines and words that are kept with what is made of them."""
_LONG = 5
"""Letters of a word from which it is read also with one missing or too many."""
_APOSTROPHE = re.compile("[\N{LEFT SINGLE QUOTATION MARK}\N{RIGHT SINGLE QUOTATION MARK}]")
_WORD = re.compile(r"[^\W\d_]{3,}")


@dataclass(frozen=True, slots=True)
class SentenceStep:
    """One step of a line.

    Attributes:
        whole: Its words, with those that open and close it.
        words: Without these; may be empty.
        around: What opens and closes it.
        ways: The ways to read it, the best one first: with fewer and fewer of the openings, each
            with more and more of what closes it.
    """

    whole: str
    words: str
    around: str
    ways: tuple[str, ...]


class StepSplitter:
    """Cuts the lines of one language into steps.

    Attributes:
        polished: The line, as it was said or typed, in plain words, with a comma wherever a
            sentence has a pause; with `asking`, "please" before an order makes a pause, too.
        steps: The steps of a polished line; none where it has too many of them.
    """

    def __init__(self, language: Mapping[str, Any], part: Callable[[str], str]) -> None:
        """Take over a language; `part` makes the regular expression of a part of its patterns."""
        # A sentence's clauses are cut over and over, and it is polished for each way to read it.
        self.steps = lru_cache(_KEPT)(self._cut)
        self.polished = lru_cache(_KEPT)(self._polished)
        self._righted = lru_cache(_KEPT)(self._right)
        words = language["words"]
        self._and, self._then = words["and"][0], words["then"][0]
        spelt, verbal_forms = by_word(language["spellings"]), by_word(language["imperatives"])
        self._forms = {**spelt, **verbal_forms}
        spellings, imperatives = either(spelt), either(verbal_forms)
        self._function_words = tuple(words["function_words"])
        self._no_slips = {*self._function_words, *words["no_slips"]}
        self._misspelt = re.compile(rf"(?<![\w'-])(?:{spellings})(?![\w'-])")
        verbal = either(words["before_imperatives"])
        self._verbal = re.compile(rf"\b(?P<before>{verbal}) (?P<verb>{imperatives})\b")
        noun = rf"(?:(?:{either(words['articles'])}) )?(?:{words['no_plural']})"
        self._contracted = re.compile(
            rf"(?:(?P<noun>(?:^|, ){noun})s|(?<=\w)'s)(?= (?:{either(words['after_is'])})\b)"
        )
        units = either(by_word(language["units"]))
        self._glued_unit = re.compile(rf"\b(\d+(?:[.,]\d+)?)({units})\b")
        self._fillers = re.compile(rf"\b(?:{either(words['fillers'])})\b")
        verbs = either(language["imperatives"])
        within = "".join(rf"(?<!\b{re.escape(word)} )" for word in words["before_please"])
        please = either(words["please"])
        self._please = re.compile(rf"{within}\b(?:{please}) (?=(?:{verbs})\b)")
        self._arrived = re.compile(rf"^{part('arrived')}(?= |$)|{part('arrived')}$")
        self._courteous = re.compile(rf".+ (?:{please})")
        self._at_once = re.compile(rf"\b(?:{either(words['at_once'])})\b")
        twice = either([*words["articles"], *words["towards"], *words["courtesy"]])
        self._stutter = re.compile(rf"\b({verbs}|{twice}|[^\W\d_]{{5,}})(?>(?:,? \1\b)+)")
        self._reason = re.compile(rf"(?:^|,? )(?:{either(words['reasons'])})\b[^,]*")
        self._opening = re.compile(rf"^(?:{_courtesy(words)}|{part('openings')})(?= |$)")
        self._synonyms = by_word(language["synonyms"])
        self._synonym = re.compile(rf"^(?:{either(self._synonyms)})(?= |$)")
        subjects = either(language["remarks"]["subjects"])
        self._emphatic = re.compile(
            rf"^(?:{either(words['emphatic'])}) (?!(?:{subjects}|{words['not']})\b)"
        )
        towards = either(words["towards"])
        among = [*words["directions"], *words["before_place"]]
        self._adverb = re.compile(rf"\b{words['adverb']}\b")
        self._directions = re.compile(rf" (?:{either(among)}|{words['adverb']})(?= )")
        self._before_place = re.compile(rf" (?:{towards}) ")
        self._closing = re.compile(rf"{part('closings')}$")
        self._joining = re.compile(
            rf",\s*(?=(?:{either(words['subordinate'])})\b)"
            rf"(?!(?:{either(words['no_subordinate'])})\b)"
        )
        then, before, and_ = (either(words[name]) for name in ("then", "before_then", "and"))
        sooner = either(words["sooner"])
        self._orders = tuple(
            re.compile(order)
            for place in ("before", "after")
            for order in _orders(place, words, verbs)
        )
        self._happens = re.compile(
            rf"[^,]* (?<!that )(?<!which )(?<!who )(?:{either(language['remarks']['happening'])})\b"
        )
        self._sooner = re.compile(rf"(?:\s*,)?\s+(?:{before}) (?:{sooner})\b(?:\s*,)?\s*")
        self._step = re.compile(rf"(?:\s*,)?\s+(?:(?:{before}) )?(?:{then})\b(?:\s*,)?\s*")
        late = either(words["before_late_then"])
        self._late_then = re.compile(rf"(,|\b(?:{before})) ({late}) (?:{then})\b(?=[^,])")
        starters = either(words["list_starters"])
        apart = "".join(rf"(?<!\b{re.escape(word)})" for word in words["one_step_after"])
        self._list = re.compile(
            rf"\s*,\s*(?:{and_}) (?=\S)|\s*,\s*(?!\d)|{apart}\s+(?:{and_}) (?=(?:{starters})\b)"
        )

    def _polished(self, line: str, asking: bool = False) -> str:
        line = plain(re.sub(r"&|\+(?!\d)", f" {self._and} ", line))
        line = _WORD.sub(lambda found: self._righted(found[0]), line)
        spelt = self._misspelt.sub(lambda found: self._forms[found[0]], line)
        if asking:
            spelt = self._please.sub(", ", spelt)
        spelt = self._contracted.sub(lambda found: f"{found['noun'] or ''} is", spelt)
        spelt = self._glued_unit.sub(r"\1 \2", spelt)
        spelt = self._stutter.sub(r"\1", tidy(self._fillers.sub(" ", spelt)))
        polished = self._at_once.sub(" ", spelt)
        polished = tidy(self._joining.sub(" ", tidy(polished)))
        imperative = self._verbal.sub(
            lambda found: f"{found['before']} {self._forms[found['verb']]}", polished
        )
        told = tidy(self._reason.sub("", imperative))
        in_order = self._late_then.sub(rf"\1 {self._then} \2", told)
        for order in self._orders:
            found = order.fullmatch(in_order)
            if found is not None and not self._happens.match(found["sooner"]):
                head = found.groupdict().get("head") or ""
                in_order = f"{head}{found['sooner']}, {self._then} {found['later']}"
        return in_order

    def waits(self, step: SentenceStep) -> bool:
        """Whether a step is for where the order before it leads: "turn once you are there"."""
        return self._arrived.search(f" {step.whole}") is not None

    def is_polite(self, line: str) -> bool:
        """Whether a line says "please" behind its first words: "trash can please, it stinks"."""
        first = plain(line).partition(",")[0].strip()
        return any(map(self._courteous.fullmatch, self._closings(first)))

    def is_at_once(self, line: str) -> bool:
        """Whether words of a line say that something is to be done at once."""
        return self._at_once.search(plain(line)) is not None

    def forget(self) -> None:
        """Forget the lines and words that are kept, as where reading is timed."""
        self.steps.cache_clear()
        self.polished.cache_clear()
        self._righted.cache_clear()

    def _cut(self, polished: str) -> Sequence[SentenceStep]:
        in_order = reversed(self._sooner.split(polished))
        halves = (half for sooner in in_order for half in self._step.split(sooner))
        parts = [part for half in halves for part in self._list.split(half)]
        if len(parts) > MOST_STEPS:
            return ()
        return tuple(self._read(tidy(part).replace(", ", " ").strip(",")) for part in parts)

    def _read(self, whole: str) -> SentenceStep:
        whole = whole.removesuffix(f" {self._and}")
        left = [whole]
        while len(left) <= _MOST_OPENINGS and left[-1]:
            if (found := self._opening.match(f" {left[-1]}")) is None:
                break
            left.append(left[-1][max(found.end() - 1, 0) :].strip())
        words = self._closings(left[-1])[0]
        ways = dict.fromkeys(way for one in left for way in self._closings(one) if way)
        ways |= dict.fromkeys(self._emphatic.sub("", way) for way in ways)
        ways |= dict.fromkeys(map(self._in_usual_words, ways))
        around = whole.removesuffix(left[-1]) + left[-1].removeprefix(words)
        return SentenceStep(whole, words, around, tuple(ways))

    def _right(self, word: str) -> str:
        """The word, or the function word that it is written almost like."""
        right = (other for other in self._function_words if _is_slip(word, other))
        return word if word in self._no_slips else next(right, word)

    def _in_usual_words(self, way: str) -> str:
        """The same with the usual verb, and without directions before the words for a place."""
        usual = self._synonym.sub(lambda found: self._synonyms[found[0]], way, count=1)
        return tidy(self._adverb.sub("", self._without_directions(usual)))

    def _without_directions(self, way: str) -> str:
        """The words without each row of directions before the words for a place.

        A row is read to its end once; its last directions may be such words, too: "next to".
        """
        pieces, end, at = list[str](), 0, 0
        while (first := self._directions.search(way, at)) is not None:
            stops, at = [first.start()], first.end()
            while (found := self._directions.match(way, at)) is not None:
                stops.append(at)
                at = found.end()
            ends = reversed((*stops[1:], at))
            stop = next((each for each in ends if self._before_place.match(way, each)), None)
            if stop is not None:
                pieces.append(way[end : first.start()])
                end = stop
        return "".join([*pieces, way[end:]])

    def _closings(self, words: str) -> list[str]:
        """The words without all that closes them, then with more and more of it."""
        ways = [words]
        while len(ways) <= _MOST_OPENINGS:
            head, tail = words[:-_LONGEST_CLOSING], words[-_LONGEST_CLOSING:]
            padded = tail if head else f" {tail}"
            if (found := self._closing.search(padded)) is None:
                break
            words = f"{head}{padded[: found.start()]}".strip()
            ways.insert(0, words)
        return ways


def _courtesy(words: Mapping[str, Sequence[str]]) -> str:
    """What reads words of courtesy before an order: "would it be at all possible for you to"."""
    begin = rf"(?! (?:{either(words['no_courtesy'])}) )(?= .*\b(?:{either(words['addressed'])})\b)"
    end = either(words["after_courtesy"])
    return rf"{begin}(?: (?:{either(words['courtesy'])})){{1,{_MOST_COURTESIES}}} (?:{end})"


def _orders(place: str, words: Mapping[str, Sequence[str]], verbs: str) -> tuple[str, ...]:
    """What reads "before A, B", the same without a comma, and "B before A", or with "after".

    Args:
        place: "before" or "after", under which are the words that stand before what comes later, or
            sooner; under "not_before" or "not_after" what begins like these and says something
            else.
        words: Of the language.
        verbs: A regular expression of what B begins with where there is no comma.
    """
    named, other = ("later", "sooner") if place == "before" else ("sooner", "later")
    marker = rf"(?!(?:{either(words[f'not_{place}'])})\b)(?>(?:{either(words[place])})\b)"
    alone = rf"(?!(?:{either(words['one_step_after'])})\b)(?:{verbs})"
    others = (*words["before_then"], *(words["phrasal"] if place == "after" else ()))
    apart = "".join(rf"(?<!\b{re.escape(word)})" for word in others)
    head = r"(?P<head>(?:.*?, )?)"
    return (
        rf"{head}{marker} (?P<{named}>[^,]+), (?P<{other}>.+)",
        rf"{head}{marker} (?P<{named}>{alone}|[^, ]+ [^,]+?) (?P<{other}>(?:{verbs})\b.*)",
        rf"(?P<{other}>.+?){apart},? {marker} (?P<{named}>[^,]+)",
    )


def _is_slip(word: str, right: str) -> bool:
    """Whether a word is written like another one but for a slip of the fingers.

    One letter is missing or too many, or two have changed places. The first letter stays, and so
    does the last, unless it is missing or one of the two: other ways lead from one word to another
    that there is, as from "would" to "world", "mould" and "woulds".
    """
    if word[:1] != right[:1] or damerau_levenshtein_distance(word, right) != 1:
        return False
    if len(word) == len(right):
        return sorted(word) == sorted(right)
    return len(right) >= _LONG and (word[-1] == right[-1] or word == right[:-1])


def either(words: Iterable[str]) -> str:
    """A regular expression for one of these, the longest first; it reads nothing without any."""
    ordered = sorted((word.casefold() for word in words), key=len, reverse=True)
    return "|".join(map(re.escape, ordered)) or "(?!)"


def by_word(table: Mapping[str, str]) -> dict[str, str]:
    """What each word of a table stands for: `could = "cud|cld"` has two words for "could"."""
    return {word.casefold(): other for other, words in table.items() for word in words.split("|")}


def plain(line: str) -> str:
    """Small letters, digits, apostrophes and hyphens; commas where a sentence has a pause."""
    line = _APOSTROPHE.sub("'", line.casefold())
    line = re.sub(r"(?<!\w)'([^']*)'(?!\w)", r" \1 ", line)
    line = re.sub(r"\s[-\N{EN DASH}\N{EM DASH}]+\s|[-=]?>|[→\N{EM DASH}]", ", ", line)
    line = re.sub(r"(?<![,;:.!?…])(?>[,;:.!?…]+)(?=\s|$)", ",", line)
    line = re.sub(r"([^\W\d_])\1{2,}", r"\1", line)  # "stoooop"
    return re.sub(r"[^\w',.-]+|(?<!\d)\.|\.(?!\d)", " ", line)


def tidy(words: str) -> str:
    """Words with single blanks, and one comma at most between them."""
    return re.sub(r"\s*,[\s,]*(?!\d)", ", ", " ".join(words.split())).strip(", -")
