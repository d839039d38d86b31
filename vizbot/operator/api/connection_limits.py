"""How many connections the server holds at once, and how long one may keep it waiting."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from vizbot.operator.api.auth import App, Receive, Scope, Send

MOST, MOST_OF_ONE = 128, 64
"""Connections that are held at once, and of these from one address."""
_REQUEST_WITHIN = 8.0
"""Who has not sent a request so long after the connection or the last answer is hung up on [s].

Longer than uvicorn keeps an idle connection, which lets an answer that is on its way arrive."""


@dataclass(slots=True, eq=False)
class _Connection:
    """One that is held.

    Attributes:
        socket: Of the server; asyncio closes it.
        address: Of the client.
        since: When it was opened, or was answered last [s].
        requests: That are being answered; an open WebSocket is one.
    """

    socket: socket.socket
    address: str
    since: float
    requests: int = 0


class BoundedListener(socket.socket):
    """A listening TCP socket that lets nobody use up the program's file descriptors.

    Where too many connections are held, the one that has waited longest without a request gives
    way to a new one; where all are being answered, the new one is closed. It counts at `accept`,
    before TLS: a client that never ends its handshake counts, too. Used by one thread.
    """

    def __init__(self, bound: socket.socket, now: Callable[[], float] = time.monotonic) -> None:
        """Take over a socket that listens.

        Args:
            bound: Not to be used any more.
            now: Time [s].
        """
        super().__init__(fileno=bound.detach())
        self._now = now
        self._held: dict[tuple[str, int], _Connection] = {}

    def listen(self, backlog: int = 0, /) -> None:
        """It does: asyncio would shorten the kernel's queue to what it accepts at once."""

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection and its address.

        Raises:
            ConnectionAbortedError: it was closed, for too many are being answered.
        """
        accepted, client = super().accept()
        address, port = client[:2]
        self._held = {key: held for key, held in self._held.items() if held.socket.fileno() != -1}
        everybody = list(self._held.values())
        same = [held for held in everybody if held.address == address]
        crowd = same if len(same) >= MOST_OF_ONE else everybody if len(everybody) >= MOST else []
        if crowd:
            idle = [held for held in crowd if not held.requests]
            if not idle:
                accepted.close()
                raise ConnectionAbortedError
            self._hang_up(min(idle, key=lambda held: held.since))
        self._held[address, port] = _Connection(accepted, address, self._now())
        return accepted, client

    def watching(self, app: App) -> App:
        """The same ASGI application; which connections it answers is seen here."""

        async def watched(scope: Scope, receive: Receive, send: Send) -> None:
            connection = self._held.get(scope.get("client") or ("", 0))
            if connection is not None:
                connection.requests += 1
            try:
                await app(scope, receive, send)
            finally:
                if connection is not None:
                    connection.requests -= 1
                    connection.since = self._now()

        return watched

    async def hang_up_on_silent(self) -> None:
        """Close the connections on which no request has come for too long."""
        latest = self._now() - _REQUEST_WITHIN
        for held in list(self._held.values()):
            if not held.requests and held.since < latest:
                self._hang_up(held)

    def _hang_up(self, connection: _Connection) -> None:
        """Have asyncio find the end of the connection and close it."""
        self._held = {key: held for key, held in self._held.items() if held is not connection}
        with suppress(OSError):  # it is gone already
            connection.socket.shutdown(socket.SHUT_RDWR)
