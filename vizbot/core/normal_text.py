"""Text as it is compared: one way to write what Unicode can write in several ways."""

from __future__ import annotations

import re
import unicodedata
from fractions import Fraction

_UNSEEN = dict.fromkeys(
    map(ord, "\N{SOFT HYPHEN}\N{ZERO WIDTH SPACE}\N{ZERO WIDTH NON-JOINER}\N{ZERO WIDTH JOINER}"
             "\N{WORD JOINER}\N{ZERO WIDTH NO-BREAK SPACE}")
)  # fmt: skip
"""Characters without a width, which nobody sees and some keyboards and pages put into words."""

_VULGAR = re.compile(
    r"(?:(\d+) ?)?([\N{VULGAR FRACTION ONE QUARTER}-\N{VULGAR FRACTION THREE QUARTERS}"
    r"\N{VULGAR FRACTION ONE SEVENTH}-\N{VULGAR FRACTION SEVEN EIGHTHS}"
    r"\N{VULGAR FRACTION ZERO THIRDS}])"
)


def normal_text(text: str) -> str:
    """The text in NFKC, with decimals for fractions, without characters that have no width.

    "hör auf" with a combining mark and with an umlaut become the same, and so do full-width and
    other letters: "\N{FULLWIDTH LATIN SMALL LETTER S}top" becomes "stop".
    """
    return unicodedata.normalize("NFKC", with_decimals(seen_text(text)))


def with_decimals(text: str) -> str:
    """The text with 1.5 for "1\N{VULGAR FRACTION ONE HALF}", which NFKC would make "11/2"."""
    return _VULGAR.sub(
        lambda found: decimal(int(found[1] or 0) + Fraction(unicodedata.numeric(found[2]))), text
    )


def decimal(number: Fraction) -> str:
    """A number in digits with a point, to six places."""
    return f"{float(number):.6f}".rstrip("0").rstrip(".")


def seen_text(text: str) -> str:
    """The text without characters that have no width."""
    return text.translate(_UNSEEN)
