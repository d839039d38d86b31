"""The one reader of numbers in what people write: all spellings become digits with a point.

It comes before everything else that changes a line: later steps drop signs and points that they do
not know, and would make 5 m of ".5 m".
"""

from __future__ import annotations

import re
import unicodedata
from fractions import Fraction

from vizbot.core.normal_text import decimal, with_decimals

_MINUS = "-\N{MINUS SIGN}\N{EN DASH}\N{EM DASH}\N{HYPHEN}\N{NON-BREAKING HYPHEN}\N{FIGURE DASH}" \
         "\N{SMALL HYPHEN-MINUS}\N{FULLWIDTH HYPHEN-MINUS}\N{SUPERSCRIPT MINUS}"  # fmt: skip
_PLUS = "+\N{FULLWIDTH PLUS SIGN}\N{SMALL PLUS SIGN}\N{SUPERSCRIPT PLUS SIGN}"
_SLASH = "/\N{FRACTION SLASH}\N{DIVISION SLASH}\N{FULLWIDTH SOLIDUS}"
_SIGNS = {**dict.fromkeys(_MINUS, "-"), **dict.fromkeys(_PLUS, "+"), **dict.fromkeys(_SLASH, "/")}
_UNKNOWN = "\N{REPLACEMENT CHARACTER}"
_CHUNK = re.compile(r"\S+")
_NUMBER = re.compile(
    r"(?P<sign>[+-]?)"
    r"(?:(?:(?P<whole>[0-9]+) )?(?P<over>[0-9]+)/(?P<under>[0-9]+)"
    r"|(?P<digits>[0-9]+(?:[.,][0-9]+)?|[.,][0-9]+)(?P<power>[eE][+-]?[0-9]{1,2})?)"
    r"(?P<unit>\N{DEGREE SIGN}|[^\W\d_]*)"
)
_GROUPED = re.compile(r"[1-9][0-9]{0,2},[0-9]{3}")
"""A thousand to some people, and one to others."""
_NAME = re.compile(r"[^\W\d_][\w'-]*")
_ALONE = re.compile(r"[^\w\s\"'()\[\]{}.,;:!?\N{HORIZONTAL ELLIPSIS}]+")
_AHEAD = re.compile(r"[^\w\s]*[0-9]")
_BEFORE, _AFTER = "([{'", ",;:!?\N{HORIZONTAL ELLIPSIS})]}."


def digits_of(line: str) -> tuple[str, bool]:
    """A line with every number in digits, and whether a number in it cannot be read.

    ".5", "0,5", "\N{VULGAR FRACTION ONE HALF}", "1 1/2", "1.5e0", digits of any script, and signs
    of any kind are read, also with a unit behind them. A number that touches anything else is left
    as it is, as are names with digits in them ("usb3"). A sign that stands alone before a number
    may belong to it or be a dash: such a number is left as it is and cannot be read, either.
    """
    line = with_decimals(line)
    pieces, end, unread = list[str](), 0, False
    chunks = list(_CHUNK.finditer(line))
    place = 0
    while place < len(chunks):
        first, count = chunks[place], 1
        plain = _plain_chunk(first[0])
        if place + 1 < len(chunks):
            following = _plain_chunk(chunks[place + 1][0])
            if _ALONE.fullmatch(plain) and _AHEAD.match(following):
                unread = True
            elif re.fullmatch(r"[+-]?[0-9]+", plain) and re.match(r"[0-9]+/[0-9]", following):
                plain, count = f"{plain} {following}", 2
        if any(map(str.isdigit, plain)) or _UNKNOWN in plain:
            read = _digits(plain)
            unread = unread or read is None
            if read not in (None, first[0]):
                pieces += [line[end : first.start()], str(read)]
                end = chunks[place + count - 1].end()
        place += count
    return "".join([*pieces, line[end:]]), unread


def _digits(chunk: str) -> str | None:
    """What stands between two blanks with its number in digits; None where that cannot be read."""
    inner = chunk.lstrip(_BEFORE)
    before, inner = chunk[: len(chunk) - len(inner)], inner.rstrip(_AFTER)
    after = chunk[len(before) + len(inner) :]
    if _NAME.fullmatch(inner):
        return chunk
    if (found := _NUMBER.fullmatch(inner)) is None or _GROUPED.fullmatch(found["digits"] or ""):
        return None
    unit = "" if found["unit"] == "\N{DEGREE SIGN}" else found["unit"]
    sign = found["sign"].replace("+", "")
    if found["over"] is None:
        number = found["digits"]
        if found["power"] is not None or not number[0].isdigit():
            number = decimal(Fraction(number.replace(",", ".") + (found["power"] or "")))
    elif (under := int(found["under"])) == 0:
        return None
    else:
        number = decimal(int(found["whole"] or 0) + Fraction(int(found["over"]), under))
    return f"{before}{sign}{number}{unit}{after}"


def _plain_chunk(chunk: str) -> str:
    return "".join(map(_plain, chunk)).strip()


def _plain(character: str) -> str:
    """A character as the pattern of numbers has it."""
    if character.isdecimal():
        return str(unicodedata.decimal(character))
    if character in _SIGNS:
        return _SIGNS[character]
    if unicodedata.category(character) == "No":
        return _UNKNOWN
    return unicodedata.normalize("NFKC", character)
