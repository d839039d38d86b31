"""Connections of those who ask for nothing keep nobody from stopping the robot."""

import asyncio
import socket
from contextlib import ExitStack, closing

import httpx
import pytest

from tests.helpers.served import served, wait_for
from vizbot.operator.api import auth, connection_limits
from vizbot.operator.api.connection_limits import MOST, MOST_OF_ONE, BoundedListener

UNFINISHED = b"POST /doubt HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n"


@pytest.fixture
def opened():
    with ExitStack() as opened:
        yield opened


class Clocked:
    """A listener whose time is set by hand, and its clients."""

    def __init__(self, opened):
        self.time = 0.0
        bound = socket.create_server(("127.0.0.1", 0))
        self.listener = opened.enter_context(BoundedListener(bound, lambda: self.time))
        self._opened = opened

    def connect(self, host="127.0.0.1"):
        """A client that is accepted."""
        port = self.listener.getsockname()[1]
        client = self._opened.enter_context(closing(connect(port, host)))
        self._opened.enter_context(closing(self.listener.accept()[0]))
        return client

    def answer(self, client, app):
        """What the client has asked for, by an ASGI application."""
        scope = {"type": "http", "client": client.getsockname()}
        asyncio.run(self.listener.watching(app)(scope, None, None))

    def sweep(self):
        asyncio.run(self.listener.close_silent())


def connect(port, host="127.0.0.1"):
    return socket.create_connection(("127.0.0.1", port), timeout=5.0, source_address=(host, 0))


def is_closed(client):
    client.setblocking(False)
    try:
        return client.recv(1) == b""
    except BlockingIOError:
        return False
    except ConnectionResetError:
        return True


def port_of(server):
    return int(server.url.rsplit(":", 1)[1])


def stop(url, host="127.0.0.1"):
    with httpx.Client(transport=httpx.HTTPTransport(local_address=host), timeout=5.0) as http:
        return http.post(f"{url}/stop").status_code


def ask_without_end(server, opened):
    """Something that is being answered, for what is sent along does not come."""
    client = opened.enter_context(closing(connect(port_of(server))))
    client.sendall(UNFINISHED + b"Expect: 100-continue\r\n\r\n")
    assert client.recv(4096).startswith(b"HTTP/1.1 100")


def test_idle_connections_give_way_to_a_stop_from_their_own_address(server, session, opened):
    idle = [opened.enter_context(closing(connect(port_of(server)))) for _ in range(2 * MOST)]
    assert stop(server.url) == 200
    assert session.stops == 1
    wait_for(lambda: sum(not is_closed(each) for each in idle) <= MOST_OF_ONE)


def test_while_one_address_has_all_it_may_others_and_its_own_connections_stop(
    server, session, opened
):
    held = opened.enter_context(httpx.Client(base_url=server.url))
    assert held.get("/state").status_code == 200
    for _ in range(MOST_OF_ONE - 1):
        ask_without_end(server, opened)
    assert held.post("/stop").status_code == 200
    ask_without_end(server, opened)
    with pytest.raises(httpx.TransportError):
        stop(server.url)
    assert stop(server.url, host="127.0.0.2") == 200
    assert session.stops == 2


def test_who_sends_no_whole_request_is_hung_up_on(session, opened, monkeypatch):
    monkeypatch.setattr(connection_limits, "_REQUEST_TIMEOUT", 0.2)
    monkeypatch.setattr(auth, "_BODY_TIMEOUT", 0.2)
    with served(session) as server:
        clients = []
        for sent in (
            b"",
            UNFINISHED,
            UNFINISHED + b"\r\n",
            b"GET /state HTTP/1.1\r\nHost: localhost\r\n\r\nG",  # and the begin of another one
        ):
            clients.append(opened.enter_context(closing(connect(port_of(server)))))
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


def test_who_is_answered_does_not_give_way(opened):
    clocked = Clocked(opened)
    clients = [clocked.connect(f"127.0.0.{2 + n % 2}") for n in range(MOST)]

    async def answered():
        ends = asyncio.Event()

        async def slow(scope, receive, send):
            await ends.wait()

        app = clocked.listener.watching(slow)
        scopes = [{"client": client.getsockname()} for client in clients]
        answers = [asyncio.ensure_future(app(scope, None, None)) for scope in scopes]
        await asyncio.sleep(0)
        with pytest.raises(ConnectionAbortedError):
            clocked.connect("127.0.0.4")
        ends.set()
        await asyncio.gather(*answers)

    asyncio.run(answered())
    assert not any(is_closed(each) for each in clients)
    clocked.connect("127.0.0.4")
    assert sum(is_closed(each) for each in clients) == 1
