"""Common English words that have nothing to do with homes: what no picture of a home shows.

The words are in `plain_words.txt`. Most are told the encoder as texts that match nothing; the rest
are never told, to find out whether it takes an unknown word for something that it knows.
"""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

UNSEEN = 200
"""Words that are in no caption."""


def _split() -> tuple[tuple[str, ...], tuple[str, ...]]:
    words = Path(__file__).with_suffix(".txt").read_text().split()
    by_hash = sorted(words, key=lambda word: sha256(word.encode()).digest())
    return tuple(sorted(by_hash[UNSEEN:])), tuple(sorted(by_hash[:UNSEEN]))


TOLD_WORDS, UNSEEN_WORDS = _split()
"""Those that captions may use, and the 200 that are in no caption, both alphabetically."""
