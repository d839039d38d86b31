"""Limits on open connections: how many there are, and how long one may wait."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from vizbot.operator.api.auth import App, Receive, Scope, Send

MOST, MOST_OF_ONE = 128, 64
"""Open connections altogether, and from one address."""
_REQUEST_TIMEOUT = 8.0
"""A connection without a request for so long since its opening or its last answer is closed [s].

Longer than uvicorn keeps an idle connection, which lets an answer that is on its way arrive."""


@dataclass(slots=True, eq=False)
class _Connection:
    """An open connection.

    Attributes:
        socket: The server's end; asyncio closes it.
        address: The client's address.
        since: Time of its opening or its last answer [s].
        requests: How many are being answered; an open WebSocket is one.
    """

    socket: socket.socket
    address: str
    since: float
    requests: int = 0


class BoundedListener(socket.socket):
    """A listening TCP socket with a limit, so that no client uses up the file descriptors.

    Where too many connections are open, the one that has waited longest without a request gives
    way to a new one; where all are being answered, the new one is closed. Connections count from
    `accept` on, before TLS: a client that never ends its handshake counts, too. Used by one thread.
    """

    def __init__(self, bound: socket.socket, now: Callable[[], float] = time.monotonic) -> None:
        """Take over a socket that listens.

        Args:
            bound: The socket; it must not be used any more.
            now: Reads the time [s].
        """
        super().__init__(fileno=bound.detach())
        self._now = now
        self._open: dict[tuple[str, int], _Connection] = {}

    def listen(self, backlog: int = 0, /) -> None:
        """Do nothing: asyncio would shorten the kernel's queue to what it accepts at once."""

    def accept(self) -> tuple[socket.socket, Any]:
        """Accept the next connection; returns it and its address.

        Raises:
            ConnectionAbortedError: it was closed, because too many are being answered.
        """
        accepted, client = super().accept()
        address, port = client[:2]
        self._open = {
            key: connection
            for key, connection in self._open.items()
            if connection.socket.fileno() != -1
        }
        everybody = list(self._open.values())
        same = [connection for connection in everybody if connection.address == address]
        crowd = same if len(same) >= MOST_OF_ONE else everybody if len(everybody) >= MOST else []
        if crowd:
            idle = [connection for connection in crowd if not connection.requests]
            if not idle:
                accepted.close()
                raise ConnectionAbortedError
            self._shut_down(min(idle, key=lambda connection: connection.since))
        self._open[address, port] = _Connection(accepted, address, self._now())
        return accepted, client

    def watching(self, app: App) -> App:
        """Wrap an ASGI application to know which connections it is answering."""

        async def watched(scope: Scope, receive: Receive, send: Send) -> None:
            connection = self._open.get(scope.get("client") or ("", 0))
            if connection is not None:
                connection.requests += 1
            try:
                await app(scope, receive, send)
            finally:
                if connection is not None:
                    connection.requests -= 1
                    connection.since = self._now()

        return watched

    async def close_silent(self) -> None:
        """Close the connections that have brought no request for too long."""
        latest = self._now() - _REQUEST_TIMEOUT
        for connection in list(self._open.values()):
            if not connection.requests and connection.since < latest:
                self._shut_down(connection)

    def _shut_down(self, connection: _Connection) -> None:
        """Shut a connection down, so that asyncio closes it."""
        self._open = {key: other for key, other in self._open.items() if other is not connection}
        with suppress(OSError):  # it is gone already
            connection.socket.shutdown(socket.SHUT_RDWR)
