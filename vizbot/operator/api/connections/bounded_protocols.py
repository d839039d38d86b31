"""HTTP requests and WebSockets that no stranger can make take long to read."""

from __future__ import annotations

import time
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from vizbot.operator.api.connections.head import END, read_head
from vizbot.operator.api.connections.token_bucket import TokenBucket

_LONGEST_HEAD = 16 * 1024
"""[bytes]"""
LONGEST_LINE = 256
"""What is kept of the lines between the chunks of a body, and what is read at once [bytes]."""
_REASON = b'{"detail":"this is no HTTP request, or its head is too long"}'
_REFUSAL = (
    b"HTTP/1.1 400 Bad Request\r\nContent-Type: application/json\r\nContent-Length: %d\r\n"
    b"Connection: close\r\n\r\n%b" % (len(_REASON), _REASON)
)
RATE, BURST = 8 * 1024, 6 * 1024
"""Bytes a second that a client may send in the long run, and at once; who drives sends 3 KB/s."""


class BoundedHttp(H11Protocol):
    """The protocol of a request, which passes on to h11 only what that reads in a short time.

    To refuse a line, h11 may need a time that grows with the square of its length, for seconds, in
    which no other thread of the process runs, not even one that stops the robot. It gets no head
    that it would refuse, and of the lines of a body little at once.
    """

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self._head: bytes | None = b""  # what has come of it; None once it is whole
        self._at_once: int | None = None  # of a body; None for all that has come

    def data_received(self, data: bytes) -> None:
        """Read what was received, or refuse it."""
        if self._head is not None:
            data = self._head + data
            end = data.find(END) + len(END)
            if end < len(END) and len(data) < _LONGEST_HEAD:
                self._head = data
                return
            head = read_head(data[:_LONGEST_HEAD])
            if head is None:
                self.transport.write(_REFUSAL)
                self.transport.close()
                return
            self._head = None
            self._at_once = LONGEST_LINE if "transfer-encoding" in head.headers else None
            super().data_received(data[:end])
            data = data[end:]
        size = self._at_once or len(data)
        # An error has closed it, and a WebSocket has a protocol of its own.
        while data and not self.transport.is_closing() and self.transport.get_protocol() is self:
            super().data_received(data[:size])
            data = data[size:]


class BoundedWebSocket(WebSocketsSansIOProtocol):
    """The protocol of a WebSocket, which is cut off before a flood is even read as messages.

    Thousands of tiny frames fit into what is received at once, and to read them takes the
    interpreter from all other threads.
    """

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self._bucket = TokenBucket(RATE, BURST, time.monotonic())

    def data_received(self, data: bytes) -> None:
        """Read what was received, unless it is too much."""
        if self._bucket.take(time.monotonic(), len(data)):
            super().data_received(data)
        else:
            self.transport.abort()
