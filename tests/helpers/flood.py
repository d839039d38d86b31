"""A flood of the API by strangers: `python -m tests.helpers.flood KIND PORT`, until its input ends.

Four addresses hold 256 connections each, and open every one that is closed again. Every second
one asks for what needs no token: to stop, as a page of another site, which is refused. Stops that
look valid at first are refused as well: what is obeyed is no flood, but stops the robot.
"""

import base64
import os
import resource
import select
import socket
import sys
from contextlib import suppress

ADDRESSES = ("127.0.0.1", "127.0.0.2", "127.0.0.3", "127.0.0.4")
CONNECTIONS = 256
"""Of each address."""
_TURN = 0.05
"""Between two looks at what was closed [s]."""
_STOP = b"POST /stop HTTP/1.1\r\nHost: localhost\r\n"
_FOREIGN_STOP = _STOP + b"Origin: http://elsewhere\r\n"
_NO_STOPS = (
    _STOP + b"Content-Length: many\r\n\r\n",
    _STOP + b"Content-Length: 1\r\nContent-Length: 2\r\n\r\n",
    _STOP + b"Content-Length: %d\r\n\r\n" % 10**20,
    _STOP + b"Transfer-Encoding: gzip\r\n\r\n",
    _STOP + b"Host: localhost\r\n\r\n",
    _STOP + b"Origin: http://localhost\xa0\r\n\r\n",
    _STOP + b"no field\r\n\r\n",
    _STOP + b"Who: \0\r\n\r\n",
    _STOP.replace(b"/stop", b"/stop?\xff") + b"\r\n",
    _FOREIGN_STOP + 2000 * b"A:\r\n" + b"\r\n",
)
_PAGE = b"GET / HTTP/1.1\r\nHost: localhost\r\n"
_CHUNKS = _PAGE + b"Transfer-Encoding: chunked\r\n\r\n"
_COSTLY = (  # what matches spaces over and over, if it matches them so
    _STOP + b"A:" + 7900 * b"\t" + b"\0\r\n\r\n",
    _PAGE + b"A:" + 7900 * b"\t" + b"\0\r\n\r\n",
    _CHUNKS + b"1;" + 7900 * b"\t" + b"\n\r\n",
    _CHUNKS + b"0\r\nA:" + 7900 * b"\t" + b"\0\r\n\r\n",
)
_SENTENCE = b"POST /said HTTP/1.1\r\nHost: localhost\r\n"
_BODY = b"Content-Type: application/json\r\nContent-Length: 60000\r\n\r\n"
_WORDS = b'{"text": "%s"}' % (b"next " * 795)
_READ_WORDS = b'{"text": "%s"}' % (b"when you have time " * 30)
_SENTENCES = tuple(
    _SENTENCE + b"Content-Type: application/json\r\nContent-Length: %d\r\n\r\n" % len(body) + body
    for body in (_WORDS, _READ_WORDS)
)
_UPGRADE = (
    b"GET /live?images=colour,map&rate=10 HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
    b"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: %s\r\n\r\n"
)
_EMPTY_TEXT, _PING = b"\x81\x80abcd", b"\x89\x80abcd"
# What a connection sends at its opening, by its number, and in every turn after that.
KINDS = {
    "unread-answers": (
        lambda n: (
            100 * (_FOREIGN_STOP + b"Content-Length: 0\r\n\r\n")
            if n % 2
            else 100 * (_PAGE + b"\r\n")
        ),
        b"",
    ),
    "slow-bodies": (
        lambda n: (_FOREIGN_STOP if n % 2 else _SENTENCE) + _BODY,
        b" ",
    ),
    "slow-heads": (
        lambda n: _FOREIGN_STOP if n % 2 else _PAGE,
        b"X",
    ),
    "refused-stops": (lambda n: _NO_STOPS[n % len(_NO_STOPS)], b" "),
    "endless-stops": (lambda n: _STOP + b"A: " + 9000 * b"a", b"a"),
    "costly-lines": (lambda n: _COSTLY[n % len(_COSTLY)], b""),
    "sentences": (lambda n: _SENTENCES[n % len(_SENTENCES)], b""),
    "silence": (lambda n: b"", b""),
    "websockets": (
        lambda n: _UPGRADE % base64.b64encode(os.urandom(16)),
        200 * (_EMPTY_TEXT + _PING),
    ),
}


class Flood:
    """All connections of one kind to a port.

    Attributes:
        opened: How many connections were opened so far.
    """

    def __init__(self, kind, port):
        self._first, self._then = KINDS[kind]
        self._reads = kind != "unread-answers"
        self._port = port
        self._poll = select.epoll()
        self._open = {}
        self.opened = 0

    def turn(self):
        """Open what is not open, and go on sending."""
        for descriptor, event in self._poll.poll(0):
            if event & (select.EPOLLHUP | select.EPOLLERR | select.EPOLLRDHUP):
                self._close(descriptor)
            elif self._reads:
                with suppress(OSError):
                    self._open[descriptor][1].recv(65536)
        for connection in list(self._open.values()):
            with suppress(OSError):
                connection[1].send(self._then)
        missing = set(range(CONNECTIONS * len(ADDRESSES))) - {n for n, _ in self._open.values()}
        for number in missing:
            self._connect(number)

    def _connect(self, number):
        client = socket.socket()
        if not self._reads:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
        client.bind((ADDRESSES[number % len(ADDRESSES)], 0))
        client.settimeout(0.2)
        try:
            client.connect(("127.0.0.1", self._port))
            client.setblocking(False)
            client.send(self._first(number // len(ADDRESSES)))
        except OSError:
            client.close()
            return
        self._open[client.fileno()] = number, client
        self._poll.register(client, select.EPOLLIN * self._reads | select.EPOLLRDHUP)
        self.opened += 1

    def _close(self, descriptor):
        self._poll.unregister(descriptor)
        self._open.pop(descriptor)[1].close()


def main(kind, port):
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
    flood = Flood(kind, int(port))
    flood.turn()
    sys.stdout.write("flooding\n")
    sys.stdout.flush()
    while not select.select([sys.stdin], [], [], _TURN)[0]:
        flood.turn()
    sys.stdout.write(f"{flood.opened}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
