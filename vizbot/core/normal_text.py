"""Text as it is compared: one way to write what Unicode can write in several ways."""

from __future__ import annotations

import unicodedata

_UNSEEN = dict.fromkeys(
    map(ord, "\N{SOFT HYPHEN}\N{ZERO WIDTH SPACE}\N{ZERO WIDTH NON-JOINER}\N{ZERO WIDTH JOINER}"
             "\N{WORD JOINER}\N{ZERO WIDTH NO-BREAK SPACE}")
)  # fmt: skip
"""Characters without a width, which nobody sees and some keyboards and pages put into words."""


def normal_text(text: str) -> str:
    """The text in NFKC, without characters that have no width.

    "hör auf" with a combining mark and with an umlaut become the same, and so do full-width and
    other letters: "\N{FULLWIDTH LATIN SMALL LETTER S}top" becomes "stop".
    """
    return unicodedata.normalize("NFKC", seen_text(text))


def seen_text(text: str) -> str:
    """The text without characters that have no width."""
    return text.translate(_UNSEEN)
