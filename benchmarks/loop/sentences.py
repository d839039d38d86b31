"""The worst processor time that a sentence takes: its words are those of the grammar, repeated."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from itertools import cycle, islice
from typing import Any

from vizbot.operator.language.command_grammar import MOST_LETTERS, MOST_WORDS
from vizbot.operator.language.language import languages, load_language
from vizbot.operator.language.understanding import read_typed

_BESIDE = {"answers", "doing", "names", "small", "spoken"}
"""Tables of a language whose words are in no pattern."""
_NOTATION = re.compile(r"[()\[\]|]|\{\w+\}|<\w+>")
_TRIES = 3


def worst_sentence() -> tuple[float, str]:
    """The processor time of the slowest sentence of all languages [s], and the words repeated.

    Of several readings of a sentence the median counts.
    """
    worst = (0.0, "")
    for code in languages():
        language = load_language(code)
        for words in rows_of_words(code):
            line = " ".join(islice(cycle(words.split()), MOST_WORDS))[:MOST_LETTERS]
            read_typed(line, language)  # makes its patterns
            worst = max(worst, (_reading(code, line), words))
    return worst


def rows_of_words(code: str) -> list[str]:
    """Rows of words, each once, that the patterns and lists of a language are made of."""
    return sorted(set(_words(load_language(code).entries)))


def _reading(code: str, line: str) -> float:
    language, times = load_language(code), list[float]()
    for _ in range(_TRIES):
        language.grammar.forget()
        began = time.thread_time()
        read_typed(line, language)
        times.append(time.thread_time() - began)
    return sorted(times)[_TRIES // 2]


def _words(entries: Any) -> Iterator[str]:
    """Rows of words without a choice in what a language's file holds."""
    if isinstance(entries, str):
        yield from (" ".join(row.split()) for row in _NOTATION.split(entries) if row.strip())
    elif isinstance(entries, dict):
        for key, value in entries.items():
            if key not in _BESIDE:
                yield from _words([key, value])
    elif isinstance(entries, list):
        for each in entries:
            yield from _words(each)
