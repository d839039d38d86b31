"""Where a request comes from: our own page or program, or a page of another site.

The acceptor asks this, too, so only the standard library is imported.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Mapping


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
