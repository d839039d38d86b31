"""The acceptor: takes the connections of the API, in a small process of its own.

It waits for the head of each request before it passes the connection on: a request to stop at once
and on a way of its own, all others no faster than the API can answer them. It imports hardly more
than the standard library, so that it starts within milliseconds, and waits for no other work.
"""

from __future__ import annotations

import resource
import select
import socket
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from vizbot.operator.api.connections.head import END, foreign_reason, may_be_typed_stop, read_head
from vizbot.operator.api.connections.token_bucket import TokenBucket

QUEUE = 4096
"""Connections that may wait in the kernel; the system may allow fewer."""
_MOST_WAITING = 2048
"""Connections whose request is not whole or not passed on yet."""
_RESERVED_FILES = 64
_HEAD_TIMEOUT = 8.0
"""A connection that was not passed on so long after its opening is closed [s]."""
_LONGEST_HEAD = 8 * 1024
"""A head that is longer goes with the rest, whatever it asks for [bytes]."""
_ACCEPTED_AT_ONCE = 256
_RATE, _BURST = 60.0, 180.0
"""Requests a second of one address that are passed on in the long run, and at once."""
_RATE_OF_ALL, _BURST_OF_ALL = 60.0, 200.0
_ADDRESSES = 1000
"""Addresses whose requests are counted."""
_Who: TypeAlias = tuple[str, bool]
"""An address, and whether its requests may be typed stops, which are counted by themselves."""
_TURN, _IDLE = 0.005, 1.0
"""Longest wait for news, while a connection waits to be passed on, and otherwise [s]."""


@dataclass(slots=True, eq=False)
class _Waiting:
    """A connection that was not passed on yet.

    Attributes:
        socket: The server's end.
        since: Time of its opening [s].
        ready: Whether it is known where to pass it on to.
        short: Whether it asks for what may be a typed stop.
    """

    socket: socket.socket
    address: str
    since: float
    ready: bool = False
    short: bool = False

    @property
    def who(self) -> _Who:
        """Whose requests it is counted with."""
        return self.address, self.short


class Acceptor:
    """Accepts connections and passes them on; used by one thread.

    Where too many wait, the oldest one of the address that has most gives way.
    """

    def __init__(
        self,
        listener: socket.socket,
        stops: socket.socket,
        others: socket.socket,
        *,
        encrypted: bool = False,
        here_alone: bool = False,
        most: int = _MOST_WAITING,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """Take over sockets.

        Args:
            listener: The listening TCP socket.
            stops: Unix socket that takes the connections with a request to stop.
            others: Unix socket that takes all others.
            encrypted: Whether requests come over TLS: then a stop is not recognised here, and a
                connection is passed on with its first bytes.
            here_alone: Whether only this machine may ask. A stop that will be refused, this way or
                as one of another site, goes with the rest.
            most: Connections that may wait here.
            now: Reads the time [s].
        """
        self._listener, self._stops, self._others = listener, stops, others
        self._encrypted, self._here_alone = encrypted, here_alone
        self._most, self._now = most, now
        self._waiting: dict[int, _Waiting] = {}
        self._of_address: dict[str, dict[int, _Waiting]] = {}
        self._ready_stops: dict[int, _Waiting] = {}
        self._ready: dict[_Who, dict[int, _Waiting]] = {}
        self._buckets: OrderedDict[_Who, TokenBucket] = OrderedDict()
        self._bucket = TokenBucket(_RATE_OF_ALL, _BURST_OF_ALL, now())
        self._poll = select.epoll()
        for each in (listener, stops, others):
            each.setblocking(False)
        self._poll.register(listener, select.EPOLLIN)
        self._poll.register(stops, 0)  # tells of its end all the same

    def turn(self) -> bool:
        """Do what there is, or wait a second; whether anybody is left to pass connections on to."""
        pending = bool(self._ready_stops or self._ready)
        for descriptor, event in self._poll.poll(_TURN if pending else _IDLE):
            if descriptor == self._stops.fileno():
                return False
            if descriptor == self._listener.fileno():
                self._accept()
            elif (connection := self._waiting.get(descriptor)) is not None:
                self._look_at(descriptor, connection, event)
        now = self._now()
        self._drop_late(now)
        for descriptor, connection in list(self._ready_stops.items()):
            if not self._pass_on(descriptor, connection, self._stops):
                break
        self._pass_on_others(now)
        return True

    def close(self) -> None:
        """Close this process's ends of all that waits; what was taken over stays open."""
        for descriptor, connection in list(self._waiting.items()):
            self._drop(descriptor, connection)
        self._poll.close()

    def _accept(self) -> None:
        now = self._now()
        for _ in range(_ACCEPTED_AT_ONCE):
            try:
                accepted, client = self._listener.accept()
            except OSError:  # none is left, or this one has gone
                return
            accepted.setblocking(False)
            if len(self._waiting) >= self._most:
                crowd = max(self._of_address.values(), key=len)
                self._drop(*next(iter(crowd.items())))
            connection = _Waiting(accepted, client[0], now)
            descriptor = accepted.fileno()
            self._waiting[descriptor] = connection
            self._of_address.setdefault(connection.address, {})[descriptor] = connection
            self._poll.register(descriptor, select.EPOLLIN | select.EPOLLRDHUP | select.EPOLLET)
            self._look_at(descriptor, connection, select.EPOLLIN)

    def _look_at(self, descriptor: int, connection: _Waiting, event: int) -> None:
        """See whether the head of a request has come, without taking it off the socket."""
        if connection.ready:  # a body that trickles costs nothing here
            return
        try:
            head = connection.socket.recv(_LONGEST_HEAD, socket.MSG_PEEK)
        except BlockingIOError:
            return
        except OSError:
            head = b""
        whole = END in head or len(head) == _LONGEST_HEAD or self._encrypted
        if not head or (event & select.EPOLLRDHUP and not whole):
            self._drop(descriptor, connection)
            return
        connection.ready = whole
        if whole and _asks_to_stop(head, here_alone=self._here_alone):
            self._ready_stops[descriptor] = connection
        elif whole:
            connection.short = _may_be_typed_stop(head)
            self._ready.setdefault(connection.who, {})[descriptor] = connection

    def _drop_late(self, now: float) -> None:
        while self._waiting:
            descriptor, oldest = next(iter(self._waiting.items()))
            if now - oldest.since < _HEAD_TIMEOUT:
                return
            self._drop(descriptor, oldest)

    def _pass_on_others(self, now: float) -> None:
        """Pass on as many as each address, and all together, are allowed to, by turns."""
        some = True
        while some:
            some = False
            for who in list(self._ready):
                own = self._buckets.pop(who, None) or TokenBucket(_RATE, _BURST, now)
                self._buckets[who] = own
                if not (own.has(now) and self._bucket.has(now)):
                    continue
                queue = self._ready[who] = self._ready.pop(who)  # now behind the others
                if not self._pass_on(*next(iter(queue.items())), self._others):
                    return
                some = own.take(now) and self._bucket.take(now)
        while len(self._buckets) > _ADDRESSES:
            self._buckets.popitem(last=False)

    def _pass_on(self, descriptor: int, connection: _Waiting, receiver: socket.socket) -> bool:
        """Pass a connection on; False where the receiver takes none now."""
        try:
            socket.send_fds(receiver, [b"\0"], [descriptor])
        except OSError:
            return False
        self._drop(descriptor, connection)
        return True

    def _drop(self, descriptor: int, connection: _Waiting) -> None:
        """Close this process's end of a connection."""
        self._poll.unregister(descriptor)  # who has it now would keep it registered
        connection.socket.close()
        del self._waiting[descriptor]
        self._ready_stops.pop(descriptor, None)
        _remove(self._of_address, connection.address, descriptor)
        _remove(self._ready, connection.who, descriptor)


def _asks_to_stop(received: bytes, *, here_alone: bool) -> bool:
    """Whether the head of a request is here, and is that of a stop which will be obeyed."""
    head = read_head(received) if received.startswith(b"POST /stop") else None
    return (
        head is not None
        and head.path == "/stop"
        and "upgrade" not in head.headers  # a WebSocket stops nothing
        and foreign_reason(head.headers, here_alone=here_alone) is None
    )


def _may_be_typed_stop(received: bytes) -> bool:
    head = read_head(received) if received.startswith(b"POST /said") else None
    return head is not None and may_be_typed_stop(head.method, head.path, head.headers)


def _remove(kept: dict[Any, dict[int, _Waiting]], key: Any, descriptor: int) -> None:
    """Remove a connection from those kept under a key, and the key after the last one."""
    if (same := kept.get(key)) is not None:
        same.pop(descriptor, None)
        if not same:
            del kept[key]


def main(listener: str, stops: str, others: str, *flags: str) -> None:
    """Accept until the process that serves has ended.

    Args:
        listener: Number of the inherited descriptor of the listening socket.
        stops: Likewise, of the Unix socket for requests to stop.
        others: Likewise, for all other requests.
        flags: `encrypted` and `here-alone`, where they hold; see `Acceptor`.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = _MOST_WAITING + _RESERVED_FILES
    if soft < wanted:
        soft = min(wanted, hard)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    acceptor = Acceptor(
        *(socket.socket(fileno=int(number)) for number in (listener, stops, others)),
        encrypted="encrypted" in flags,
        here_alone="here-alone" in flags,
        most=min(_MOST_WAITING, soft - _RESERVED_FILES),
    )
    while acceptor.turn():
        pass
