"""WebSockets whose clients send no more than a person's page does."""

from __future__ import annotations

import time
from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from vizbot.operator.api.connections.token_bucket import TokenBucket

RATE, BURST = 8 * 1024, 6 * 1024
"""Bytes a second that a client may send in the long run, and at once; who drives sends 3 KB/s."""


class BoundedWebSocket(WebSocketsSansIOProtocol):
    """The protocol of a WebSocket, which is cut off before a flood is even read as messages.

    Thousands of tiny frames fit into what is received at once, and to read them takes the
    interpreter from all other threads.
    """

    def __init__(self, *args: Any, **settings: Any) -> None:
        """Create it as uvicorn does."""
        super().__init__(*args, **settings)
        self._bucket = TokenBucket(RATE, BURST, time.monotonic())

    def data_received(self, data: bytes) -> None:
        """Read what was received, unless it is too much."""
        if self._bucket.take(time.monotonic(), len(data)):
            super().data_received(data)
        else:
            self.transport.abort()
