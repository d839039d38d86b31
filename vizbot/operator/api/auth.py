"""Access to the robot: this machine has it, and everybody who knows the token.

The console's own files are for everyone: the page asks a person for the token.
"""

from __future__ import annotations

import asyncio
import json
import os
import secrets
import socket
import time
from collections import OrderedDict
from collections.abc import Awaitable, Callable, MutableMapping
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit

from vizbot.core.errors import ConfigError
from vizbot.core.files import user_folder
from vizbot.operator.api.connections.head import foreign_reason, is_loopback, may_be_typed_stop
from vizbot.operator.api.connections.token_bucket import TokenBucket
from vizbot.operator.api.console_routes import FILES
from vizbot.operator.api.proof import PROOF_PATH, Credentials

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

MAX_BODY = 64 * 1024
"""Size of the body of a request [bytes]."""
_MAX_BODY_AT = {"/heard": 1024 * 1024, "/map/keep-out": 512 * 1024}
"""Recordings of speech and lists of corners are larger."""
_BODY_TIMEOUT = 10.0
"""A body that is not whole after this time ends there [s]."""
_MESSAGES = 200.0
"""Most messages a second over a WebSocket; a page that drives sends some 20."""
_RATE, _BURST = 50.0, 150.0
"""Requests a second that one address may make in the long run, and requests at once."""
_ADDRESSES = 1000
"""Addresses whose requests are counted."""
_MIN_TOKEN = 20
"""Length of a token in letters."""
FREE_PATH = "/stop"
"""This path needs no token, so that everybody can stop the robot."""


def token_path() -> Path:
    """The file that holds this user's token."""
    return user_folder("XDG_CONFIG_HOME", ".config") / "token"


def stored_token(url: str) -> str | None:
    """The token that is kept for the robot at `url`.

    Returns:
        The stored token of this user's robot; None where there is none, or where `url` is not
        plainly on this machine (a loopback address or another of its own, `localhost`, its name):
        the token is for no other machine.

    Raises:
        ConfigError: the file cannot be read, or holds no token.
    """
    try:
        host = urlsplit(url).hostname
    except ValueError:  # no address at all; the client reports it
        return None
    return _stored() if host is not None and _is_here(host) else None


def _is_here(host: str) -> bool:
    if is_loopback(host) or host == socket.gethostname().lower():
        return True
    try:
        [(family, kind, _, _, address), *_] = socket.getaddrinfo(
            host, 0, type=socket.SOCK_STREAM, flags=socket.AI_NUMERICHOST
        )
        with socket.socket(family, kind) as probe:
            probe.bind(address)  # no other address than our own can be bound
    except (OSError, UnicodeError):  # another name or address, or none
        return False
    return True


def _stored() -> str | None:
    """The stored token of this user's robot; None where there is none.

    Raises:
        ConfigError: the file cannot be read, or holds no token.
    """
    path = token_path()
    try:
        if not path.exists():
            return None
        token = path.read_text(encoding="utf-8-sig").strip()
        path.chmod(0o600)
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"the token {path} cannot be read ({error}); delete it") from error
    if len(token) < _MIN_TOKEN:
        raise ConfigError(f"the token {path} is too short to be one; delete it")
    return token


def own_token() -> tuple[str, bool]:
    """The token of this user's robot, and whether it is new and must still be stored.

    Raises:
        ConfigError: the file cannot be read, or holds no token.
    """
    stored = _stored()
    return (secrets.token_urlsafe(24), True) if stored is None else (stored, False)


def store_token(token: str) -> None:
    """Write the token of this user's robot to a file that only this user can read.

    Raises:
        ConfigError: the file cannot be written.
    """
    path = token_path()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        written = path.with_name(f"{path.name}.{os.getpid()}")
        with os.fdopen(os.open(written, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(token + "\n")
        written.replace(path)
    except OSError as error:
        raise ConfigError(f"the token {path}: {error.strerror}; check that folder") from error


class Guard:
    """ASGI middleware: refuses requests without the token, from other sites, and floods.

    Pages of other sites cannot talk to the robot through a visitor's browser: an `Origin` must be
    our own, a request that the browser marks as coming from another site is refused, and without
    a token the host must be a name of this machine.
    """

    def __init__(
        self, app: App, credentials: Credentials, now: Callable[[], float] = time.monotonic
    ) -> None:
        self._app = app
        self._credentials = credentials
        self._now = now
        self._buckets: OrderedDict[tuple[str, bool], TokenBucket] = OrderedDict()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it with the reason."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refused = self._refusal(scope)
        if refused is not None:
            await _refuse(scope, send, *refused)
            return
        is_socket = scope["type"] == "websocket"
        limited = _throttled(receive, self._now) if is_socket else _bounded(receive, _limit(scope))
        await self._app(scope, limited, send)

    def _refusal(self, scope: Scope) -> tuple[int, str] | None:
        headers = {
            key.decode("latin-1"): value.decode("latin-1") for key, value in scope["headers"]
        }
        page = scope["path"] in FILES
        foreign = foreign_reason(headers, here_alone=not self._credentials.demanded, is_page=page)
        if foreign is not None:
            return 403, foreign
        if scope["path"] == FREE_PATH:
            return None
        short = may_be_typed_stop(scope.get("method", ""), scope["path"], headers)
        if not self._count_request(scope, short):
            return 429, "too many requests; ask less often"
        if self._credentials.demanded and not page and scope["path"] != PROOF_PATH:
            given = _given(scope, headers)
            if not any(self._credentials.admit(token) for token in given):
                wrong = "that is not this robot's token; " if given else ""
                return 401, f"{wrong}give the robot's token, which launch shows"
        try:
            too_large = int(headers.get("content-length", "0")) > _limit(scope)
        except ValueError:
            too_large = True
        return (413, f"more than {_limit(scope)} bytes") if too_large else None

    def _count_request(self, scope: Scope, short: bool) -> bool:
        """Count a request; whether its address may make one more now.

        A typed stop, which a `short` request may be, is counted by itself.
        """
        who, now = (str((scope.get("client") or ("",))[0]), short), self._now()
        bucket = self._buckets.pop(who, None) or TokenBucket(_RATE, _BURST, now)
        self._buckets[who] = bucket
        while len(self._buckets) > _ADDRESSES:
            self._buckets.popitem(last=False)
        return bucket.take(now)


def _given(scope: Scope, headers: dict[str, str]) -> list[str]:
    """What a request gives as a token."""
    given = [headers.get("authorization", "").removeprefix("Bearer ")]
    given += parse_qs(scope["query_string"].decode("latin-1")).get("token", [])
    for cookie in headers.get("cookie", "").split(";"):
        name, _, value = cookie.strip().partition("=")
        given += [unquote(value)] if name == "token" else []
    return [each for each in given if each]


def _limit(scope: Scope) -> int:
    """Greatest size of the body of this request [bytes]."""
    return _MAX_BODY_AT.get(scope["path"], MAX_BODY)


def _bounded(receive: Receive, limit: int) -> Receive:
    """A `receive` that ends a body which is longer than `limit`, or does not come."""
    received, whole = 0, False
    until: float | None = None

    async def bounded() -> Message:
        nonlocal received, whole, until
        until = until or asyncio.get_running_loop().time() + _BODY_TIMEOUT
        try:
            async with asyncio.timeout_at(None if whole else until):
                message = await receive()
        except TimeoutError:
            return {"type": "http.disconnect"}
        received += len(message.get("body", b""))
        if received > limit:
            return {"type": "http.disconnect"}
        whole = not message.get("more_body", False)
        return message

    return bounded


def _throttled(receive: Receive, now: Callable[[], float]) -> Receive:
    """A `receive` that ends a WebSocket with a flood of messages."""
    bucket = TokenBucket(_MESSAGES, _MESSAGES, now())

    async def throttled() -> Message:
        message = await receive()
        return message if bucket.take(now()) else {"type": "websocket.disconnect", "code": 1008}

    return throttled


async def _refuse(scope: Scope, send: Send, status: int, reason: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": reason[:120]})
        return
    body = json.dumps({"detail": reason}).encode()
    headers = [(b"content-type", b"application/json"), (b"content-length", str(len(body)).encode())]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
