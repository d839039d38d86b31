"""The head of an HTTP request, read in a time that grows no faster than its length.

The acceptor reads it, too, so only the standard library is imported.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

END = b"\r\n\r\n"
_TOKEN = rb"[-!#$%&'*+.^_`|~0-9A-Za-z]++"
# Nothing that was matched is given back, so that no head takes long, whatever it holds.
_HEAD = re.compile(
    rb"(%(token)b) ([!-~]++) HTTP/1\.[01]\r\n((?:%(token)b:[^\0\n\r\v\f]*+\r\n){0,100}+)\r\n"
    % {b"token": _TOKEN}
)
_LENGTH_DIGITS = 20
_SHORT = 256
"""Longest body of a sentence that may be a stop [bytes]."""
_FRAMING = ("content-length", "transfer-encoding")


@dataclass(frozen=True, slots=True)
class Head:
    """The head of a request.

    Attributes:
        method: In the letters that were sent.
        path: What is asked for, without the query.
        headers: By their names in lower case; of several the last.
    """

    method: str
    path: str
    headers: dict[str, str]


def read_head(received: bytes) -> Head | None:
    """The head that `received` begins with; None where it is none by RFC 9112, or not whole.

    It has at most 100 lines, one `Host`, and at most one way to say where the body ends. Folded
    lines and ends of lines other than CR LF are refused, so that all who read it read the same.
    """
    matched = _HEAD.match(received)
    if matched is None:
        return None
    method, target, lines = (part.decode("latin-1") for part in matched.groups())
    fields = [line.partition(":") for line in lines.split("\r\n")[:-1]]
    names = [name.lower() for name, _, _ in fields]
    headers = dict(zip(names, (value.strip(" \t") for _, _, value in fields), strict=True))
    length = headers.get("content-length", "0")
    if (
        names.count("host") != 1
        or sum(map(names.count, _FRAMING)) > 1
        or not (length.isascii() and length.isdecimal() and len(length) <= _LENGTH_DIGITS)
        or headers.get("transfer-encoding", "chunked").lower() != "chunked"
    ):
        return None
    return Head(method, target.partition("?")[0], headers)


def may_be_typed_stop(method: str, path: str, headers: Mapping[str, str]) -> bool:
    """Whether a request with this head may be a sentence that stops: one with a short body.

    Such are counted by themselves, so that no flood of long ones keeps a stop waiting.
    """
    length = headers.get("content-length", "")
    short = length.isdecimal() and len(length) <= len(str(_SHORT)) and int(length) <= _SHORT
    return short and (method, path) == ("POST", "/said")
