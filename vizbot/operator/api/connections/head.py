"""The head of an HTTP request: what it asks for, and whether our own page or program sends it.

It is read in a time that grows no faster than its length. The acceptor reads it, too, so only the
standard library is imported.
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Mapping
from dataclasses import dataclass

END = b"\r\n\r\n"
_TOKEN = rb"(?>[-!#$%&'*+.^_`|~0-9A-Za-z]+)"
# Nothing that was matched is given back, so that no head takes long, whatever it holds.
_HEAD = re.compile(
    rb"(%(token)b) ((?>[!-~]+)) HTTP/1\.[01]\r\n"
    rb"((?>(?:%(token)b:(?>[^\0\n\r\v\f]*)\r\n){0,100}))\r\n" % {b"token": _TOKEN}
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


def foreign_reason(
    headers: Mapping[str, str], *, here_alone: bool, is_page: bool = False
) -> str | None:
    """Why a request is none that our own page or a program sends; None where it may be.

    Args:
        headers: Of the request, their names in lower case.
        here_alone: Whether only this machine may ask: then the host must be a name of it.
        is_page: Whether it asks for a page, which may be opened by a link on another site.
    """
    host, origin = headers.get("host", ""), headers.get("origin")
    if headers.get("sec-fetch-site", "none") not in ("none", "same-origin") and not is_page:
        return "a page of another site may not talk to the robot"
    if origin is not None and origin.split("://", 1)[-1] != host:
        return f"a page of {origin} may not talk to the robot"
    if here_alone and not is_loopback(_without_port(host)):
        return f"{host} is not a name of this machine; launch with --host"
    return None


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches `host`, a name or an address."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host == "localhost"


def _without_port(host: str) -> str:
    if host.startswith("["):
        return host.split("]", 1)[0][1:]
    return host.rsplit(":", 1)[0] if ":" in host else host
