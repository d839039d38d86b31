"""The connection between the program and the process of the base: neither waits for the other."""

from __future__ import annotations

import logging
import pickle
import socket
import time
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import wait

from drivers.roomba.service import Report
from drivers.roomba.state import with_contacts
from vizbot.core.types import BaseState

_UNREAD = 200
"""Number of reports stored at most for a reader that does not read."""
_LONGEST_MESSAGE = 65536
"""Size of a message at most [bytes]; a report takes 1 kB."""
_LONGEST_LINE = 4000
"""Characters of a log record at most."""


class Channel:
    """An end of a connection that carries whole messages and never waits for the other end.

    A process that is killed while it sends or receives leaves no part of a message behind, so that
    another one can go on with its end.
    """

    def __init__(self, end: socket.socket) -> None:
        self._socket = end

    def send(self, message: object) -> None:
        """Send a message.

        Raises:
            BlockingIOError: the other end does not read.
            OSError: the other end is gone.
        """
        self._socket.send(pickle.dumps(message), socket.MSG_DONTWAIT)

    def poll(self, timeout: float = 0.0) -> bool:
        """Whether `recv` returns or raises at once, within `timeout` [s]."""
        return bool(wait([self._socket], timeout))

    def recv(self) -> object:
        """Wait for a message.

        Raises:
            EOFError: the other end is closed.
            OSError: this end is closed.
        """
        message = self._socket.recv(_LONGEST_MESSAGE)
        if not message:
            raise EOFError
        return pickle.loads(message)

    def finish(self, timeout: float) -> None:
        """Send no more, wait up to `timeout` [s] until all have left the other end, and close."""
        end = time.monotonic() + timeout
        with suppress(EOFError, OSError):
            self._socket.shutdown(socket.SHUT_WR)
            while self.poll(max(0.0, end - time.monotonic())):
                self.recv()
        self.close()

    def close(self) -> None:
        """Close this end."""
        self._socket.close()


def open_channel() -> tuple[Channel, Channel]:
    """Both ends of a new connection."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    return Channel(ours), Channel(theirs)


class Outbox(logging.Handler):
    """Sends reports and log records without ever waiting for the reader."""

    def __init__(self, channel: Channel) -> None:
        super().__init__()
        self._channel = channel
        self._unsent: list[object] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Send a log record, its message formatted."""
        record.msg, record.args = record.getMessage()[:_LONGEST_LINE], None
        record.exc_info = record.exc_text = record.stack_info = None
        self._unsent.append(record)

    def send(self, reports: Sequence[object]) -> None:
        """Send what fits; the rest is shortened such that no trouble and no contact is lost.

        Raises:
            OSError: the reader is gone.
        """
        self._unsent += reports
        while len(self._unsent) > _UNREAD:
            self._shorten()
        while self._unsent:
            try:
                self._channel.send(self._unsent[0])
            except BlockingIOError:
                return
            del self._unsent[0]

    def _shorten(self) -> None:
        """Merge the two oldest states; without two, drop the oldest log record."""
        places = [n for n, kept in enumerate(self._unsent) if isinstance(kept, BaseState)]
        if len(places) < 2:
            others = (n for n, kept in enumerate(self._unsent) if not isinstance(kept, Report))
            del self._unsent[next(others, 0)]
            return
        older, newer = (self._unsent[place] for place in places[:2])
        assert isinstance(older, BaseState) and isinstance(newer, BaseState)
        self._unsent[places[1]] = with_contacts(newer, older)
        del self._unsent[places[0]]
