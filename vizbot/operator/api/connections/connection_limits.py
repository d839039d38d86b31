"""Limits on open connections: how many there are, and how long one may wait."""

from __future__ import annotations

import asyncio
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from vizbot.operator.api.auth import App, Message, Receive, Scope, Send

MOST, MOST_OF_ONE = 128, 64
"""Open connections altogether, and from one address."""
_REQUEST_TIMEOUT = 8.0
"""A connection without a request for so long since its opening or its answer is closed [s].

That lets an answer that is on its way arrive."""
_SEND_TIMEOUT = 5.0
"""A client that does not read a part of its answer for so long is hung up on [s]."""

_OF_BODIES = (b"content-length", b"transfer-encoding")
"""Headers of requests that have a body, unless its length is 0."""


@dataclass(slots=True, eq=False)
class _Connection:
    """An open connection.

    Attributes:
        socket: The server's end; asyncio closes it.
        since: Time of its opening or of its answer [s].
        answered: Whether a request of it is being answered; an open WebSocket is one.
        trickles: Whether the body of that request is not whole yet.
        is_websocket: Whether it is one.
    """

    socket: socket.socket
    address: str
    since: float
    answered: bool = False
    trickles: bool = False
    is_websocket: bool = False


class BoundedListener(socket.socket):
    """Takes the connections that the acceptor passes on, and limits how many are open.

    To asyncio it is a listening socket. A new connection is always taken. Where too many are open,
    one gives way to it: the oldest without a whole request, else the oldest request, else the
    newest WebSocket, so that a flood of these does not cut off who watched or drove before, and one
    of bodies that trickle not who has just come.
    Used by one thread.
    """

    def __init__(self, channel: socket.socket, now: Callable[[], float] = time.monotonic) -> None:
        """Take over this process's end of the channel to the acceptor, a Unix stream socket."""
        super().__init__(fileno=channel.detach())
        self._now = now
        self._open: dict[tuple[str, int], _Connection] = {}

    def listen(self, backlog: int = 0, /) -> None:
        """Do nothing: the acceptor listens."""

    def accept(self) -> tuple[socket.socket, Any]:
        """Take the next connection; returns it and its address.

        Raises:
            BlockingIOError: there is none.
            ConnectionAbortedError: its client is gone.
        """
        _, descriptors, _, _ = socket.recv_fds(self, 1, 1)
        if not descriptors:
            raise ConnectionAbortedError
        accepted = socket.socket(fileno=descriptors[0])
        try:
            client = accepted.getpeername()
        except OSError as error:
            accepted.close()
            raise ConnectionAbortedError from error
        address, port = client[:2]
        self._open = {
            key: connection
            for key, connection in self._open.items()
            if connection.socket.fileno() != -1
        }
        everybody = list(self._open.values())
        same = [connection for connection in everybody if connection.address == address]
        if len(same) >= MOST_OF_ONE:
            self._shut_down(_least_needed(same))
        elif len(everybody) >= MOST:
            self._shut_down(_least_needed(everybody))
        self._open[address, port] = _Connection(accepted, address, self._now())
        return accepted, client

    def watching(self, app: App) -> App:
        """Wrap an ASGI application: know what it answers, and hang up on who does not read."""

        async def watched(scope: Scope, receive: Receive, send: Send) -> None:
            connection = self._open.get(tuple(scope.get("client") or ("", 0)))
            if connection is None:
                await app(scope, receive, send)
                return

            async def send_in_time(message: Message) -> None:
                try:
                    async with asyncio.timeout(_SEND_TIMEOUT):
                        await send(message)
                except TimeoutError:
                    self._shut_down(connection)

            async def receive_part() -> Message:
                message = await receive()
                connection.trickles = bool(message.get("more_body", False))
                return message

            connection.answered = True
            connection.trickles = any(
                name in _OF_BODIES and value != b"0" for name, value in scope.get("headers", ())
            )
            connection.is_websocket = scope["type"] == "websocket"
            try:
                await app(scope, receive_part, send_in_time)
            finally:
                connection.answered = connection.trickles = False
                connection.since = self._now()

        return watched

    async def close_silent(self) -> None:
        """Close the connections that have brought no request for too long."""
        latest = self._now() - _REQUEST_TIMEOUT
        for connection in list(self._open.values()):
            if not connection.answered and connection.since < latest:
                self._shut_down(connection)

    def _shut_down(self, connection: _Connection) -> None:
        """Shut a connection down, so that asyncio closes it."""
        self._open = {key: other for key, other in self._open.items() if other is not connection}
        with suppress(OSError):  # it is gone already
            connection.socket.shutdown(socket.SHUT_RDWR)


def _least_needed(crowd: list[_Connection]) -> _Connection:
    """The connection that gives way first."""
    return min(
        crowd,
        key=lambda each: (
            each.answered and not each.trickles,
            each.is_websocket,
            -each.since if each.is_websocket else each.since,
        ),
    )
