"""Common English words that have nothing to do with homes, so that no picture of a home shows them.

The words are in `plain_words.txt`. Most are in captions that match nothing. The rest are in no
caption, to find out whether the encoder takes an unknown word for something that it knows.
"""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

UNSEEN = 200
"""Number of words that are in no caption."""


def _split() -> tuple[tuple[str, ...], tuple[str, ...]]:
    words = Path(__file__).with_suffix(".txt").read_text().split()
    by_hash = sorted(words, key=lambda word: sha256(word.encode()).digest())
    return tuple(sorted(by_hash[UNSEEN:])), tuple(sorted(by_hash[:UNSEEN]))


CAPTION_WORDS, HELD_OUT_WORDS = _split()
"""Words that captions may use, and words that are in no caption, both alphabetically."""
