"""How alike two phrases are, by their letters and by their sounds.

The sounds are those of metaphone: consonants by how they are spoken, vowels left out.
"""

from __future__ import annotations

from jellyfish import jaro_winkler_similarity, levenshtein_distance, metaphone

NEAR = 0.66
"""Likeness from which the robot asks back."""
_SOUND = 0.6
"""Weight of the sounds, beside that of the letters."""


def similarity(a: str, b: str) -> float:
    """How alike two phrases are by letters and sounds, 0 to 1."""
    letters = (jaro_winkler_similarity(a, b) + nearness(a, b)) / 2
    return _SOUND * nearness(sounds(a), sounds(b)) + (1.0 - _SOUND) * letters


def nearness(a: str, b: str) -> float:
    """Share of letters that need no change to make one of the other, 0 to 1."""
    return 1.0 - levenshtein_distance(a, b) / max(len(a), len(b), 1)


def sounds(words: str) -> str:
    """The sounds of words, without the gaps: "book shelf" sounds like "bookshelf"."""
    return metaphone(words.replace("'", "")).replace(" ", "")


def plain_words(words: str) -> str:
    """Words in small letters, without hyphens and more than one blank between them."""
    return " ".join(words.casefold().replace("-", " ").split())
