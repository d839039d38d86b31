"""Connections of those who ask for nothing keep nobody from stopping the robot."""

import asyncio
import socket
from contextlib import closing

import httpx
import pytest

from tests.helpers.clients import client_of, is_closed, open_client
from tests.helpers.served import served
from vizbot.operator.api import auth
from vizbot.operator.api.connections import connection_limits
from vizbot.operator.api.connections.connection_limits import MOST, MOST_OF_ONE, BoundedListener

UNFINISHED = b"POST /doubt HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n"


class Clocked:
    """A listener whose time is set by hand, and its clients."""

    def __init__(self, opened):
        self.time = 0.0
        ours, channel = socket.socketpair()
        self.listener = opened.enter_context(BoundedListener(ours, lambda: self.time))
        self._channel = opened.enter_context(closing(channel))
        self._port = opened.enter_context(closing(socket.create_server(("127.0.0.1", 0))))
        self._opened = opened

    def connect(self, host="127.0.0.1"):
        """A client that is accepted."""
        port = self._port.getsockname()[1]
        client = self._opened.enter_context(closing(open_client(port, host)))
        with self._port.accept()[0] as accepted:
            socket.send_fds(self._channel, [b"\0"], [accepted.fileno()])
        self._opened.enter_context(closing(self.listener.accept()[0]))
        return client

    def answer(self, client, app):
        """What the client has asked for, by an ASGI application."""
        scope = {"type": "http", "client": client.getsockname()}
        asyncio.run(self.listener.watching(app)(scope, None, None))

    def sweep(self):
        asyncio.run(self.listener.close_silent())


def stop(url, host="127.0.0.1"):
    with httpx.Client(transport=httpx.HTTPTransport(local_address=host), timeout=5.0) as http:
        return http.post(f"{url}/stop").status_code


def ask_without_end(server, opened):
    """Something that is being answered, for what is sent along does not come."""
    client = client_of(server, opened)
    client.sendall(UNFINISHED + b"Expect: 100-continue\r\n\r\n")
    assert client.recv(4096).startswith(b"HTTP/1.1 100")


def test_idle_connections_do_not_delay_a_stop_from_their_own_address(server, session, opened):
    idle = [client_of(server, opened) for _ in range(2 * MOST)]
    assert stop(server.url) == 200
    assert session.stops == 1
    assert not any(is_closed(each) for each in idle)  # they wait where nobody waits for them


def test_unfinished_requests_give_way_to_a_stop_and_to_new_requests(server, session, opened):
    for _ in range(MOST_OF_ONE + 1):
        ask_without_end(server, opened)
    assert stop(server.url) == 200
    assert httpx.get(f"{server.url}/state").status_code == 200
    assert stop(server.url, host="127.0.0.2") == 200
    assert session.stops == 2


def test_who_sends_no_whole_body_is_hung_up_on(session, opened, monkeypatch):
    monkeypatch.setattr(auth, "_BODY_TIMEOUT", 0.2)
    with served(session) as server:
        clients = []
        for sent in (
            UNFINISHED + b"\r\n",
            b"GET /state HTTP/1.1\r\nHost: localhost\r\n\r\nG",  # and the begin of another one
        ):
            clients.append(client_of(server, opened))
            clients[-1].sendall(sent)
        for client in clients:
            while client.recv(4096):  # until it is closed
                pass


def test_a_connection_may_be_silent_while_it_is_answered_and_not_for_long_after(opened):
    clocked = Clocked(opened)
    client, silent = clocked.connect(), clocked.connect()

    async def slow(scope, receive, send):
        clocked.time = 60.0
        await clocked.listener.close_silent()

    clocked.answer(client, slow)
    assert is_closed(silent) and not is_closed(client)
    clocked.time += 7.9
    clocked.sweep()
    assert not is_closed(client)
    clocked.time += 0.2
    clocked.sweep()
    assert is_closed(client)


def test_who_has_waited_longest_gives_way_first(opened):
    clocked = Clocked(opened)
    clients = [clocked.connect() for _ in range(MOST_OF_ONE)]
    clocked.time = 1.0

    async def at_once(scope, receive, send):
        pass

    clocked.answer(clients[0], at_once)
    clocked.connect()
    assert [is_closed(each) for each in clients[:3]] == [False, True, False]


def test_where_all_are_answered_the_oldest_request_and_then_the_newest_websocket_gives_way(opened):
    clocked = Clocked(opened)
    clients = []
    for n in range(MOST):
        clocked.time += 1.0
        clients.append(clocked.connect(f"127.0.0.{2 + n % 2}"))

    async def answered():
        ends = asyncio.Event()

        async def slow(scope, receive, send):
            await ends.wait()

        app = clocked.listener.watching(slow)
        answers = []
        for n, client in enumerate(clients):
            scope = {"type": "http" if n in (7, 8) else "websocket", "client": client.getsockname()}
            answers.append(asyncio.ensure_future(app(scope, None, None)))
        await asyncio.sleep(0)
        closed = []
        for _ in range(3):
            clocked.time += 1.0
            newest = clocked.connect("127.0.0.4")
            scope = {"type": "websocket", "client": newest.getsockname()}
            answers.append(asyncio.ensure_future(app(scope, None, None)))
            await asyncio.sleep(0)
            closed.append([n for n, client in enumerate(clients) if is_closed(client)])
        ends.set()
        await asyncio.gather(*answers)
        return closed

    assert asyncio.run(answered()) == [[7], [7, 8], [7, 8]]


@pytest.mark.parametrize(
    ("length", "closed"),
    [(b"9", [True, True, True, False, False]), (b"0", [True, False, False, True, True])],
)
def test_bodies_that_trickle_give_way_before_who_has_just_come(opened, length, closed):
    """Whoever has just come is not answered yet; a request without a body is whole."""
    clocked = Clocked(opened)
    clients = [clocked.connect() for _ in range(MOST_OF_ONE)]
    clocked.time = 1.0

    async def answered():
        ends = asyncio.Event()

        async def trickle():
            await ends.wait()
            return {"type": "http.request", "more_body": False}

        async def read(scope, receive, send):
            await receive()

        app = clocked.listener.watching(read)
        answers = []
        for client in clients:
            headers = [(b"content-length", length)]
            scope = {"type": "http", "client": client.getsockname(), "headers": headers}
            answers.append(asyncio.ensure_future(app(scope, trickle, None)))
        await asyncio.sleep(0)
        come = [clocked.connect() for _ in range(3)]
        ends.set()
        await asyncio.gather(*answers)
        return [is_closed(each) for each in (*clients[:3], *come[:2])]

    assert asyncio.run(answered()) == closed


def test_who_does_not_read_an_answer_is_hung_up_on(opened, monkeypatch):
    monkeypatch.setattr(connection_limits, "_SEND_TIMEOUT", 0.1)
    clocked = Clocked(opened)
    client = clocked.connect()

    async def answer(scope, receive, send):
        await send({"type": "http.response.body"})

    async def never(message):
        await asyncio.Event().wait()

    scope = {"type": "http", "client": client.getsockname()}
    asyncio.run(clocked.listener.watching(answer)(scope, None, never))
    assert is_closed(client)
