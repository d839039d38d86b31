"""The acceptor passes requests on once their head is whole, and a stop at once."""

import socket
from contextlib import closing

import pytest

from tests.helpers.clients import is_closed, open_client
from vizbot.operator.api.connections import acceptor
from vizbot.operator.api.connections.acceptor import Acceptor

ASK = b"GET /state HTTP/1.1\r\nHost: localhost\r\n\r\n"
STOP = b"POST /stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n"

SAY = b"POST /said HTTP/1.1\r\nHost: localhost\r\nContent-Length: %s\r\n\r\n"


class Accepting:
    """An acceptor whose turns are asked for, and the ends of its channels."""

    def __init__(self, opened, **settings):
        self._opened = opened
        self.listener = self._keep(socket.create_server(("127.0.0.1", 0), backlog=512))
        self.stops, stops = map(self._keep, socket.socketpair())
        self.others, others = map(self._keep, socket.socketpair())
        self.acceptor = Acceptor(self.listener, stops, others, **settings)
        opened.callback(self.acceptor.close)

    def connect(self, sent=b"", host="127.0.0.1"):
        """A client that has sent something, and is accepted."""
        client = self._keep(open_client(self.listener.getsockname()[1], host))
        client.sendall(sent)
        self.acceptor.turn()
        return client

    def passed_on(self, channel):
        """Ports of the clients that came over a channel, in order."""
        channel.setblocking(False)
        ports = []
        while True:
            try:
                _, descriptors, _, _ = socket.recv_fds(channel, 1, 1)
            except BlockingIOError:
                return ports
            with socket.socket(fileno=descriptors[0]) as passed:
                ports.append(passed.getpeername()[1])

    def _keep(self, opened):
        return self._opened.enter_context(closing(opened))


def port_of(client):
    return client.getsockname()[1]


@pytest.fixture
def accepting(opened):
    return Accepting(opened)


@pytest.mark.parametrize(
    "parts",
    [
        [STOP],
        [STOP[:7], STOP[7:-1], STOP[-1:]],
        # Whatever the head promises.
        [b"POST /stop HTTP/1.1\r\nHost: localhost\r\n\r\n"],
        [b"POST /stop?now HTTP/1.0\r\nhost:localhost\r\n\r\n"],
        [STOP.replace(b"Content-Length: 9", b"Transfer-Encoding: chunked")],
        [STOP.replace(b"9", b"60000")],
        [STOP.replace(b"Host", b"Cookie: a=\x01\xe9\r\nHost")],
    ],
)
def test_a_stop_has_a_way_of_its_own_even_before_its_body(accepting, parts):
    client = accepting.connect()
    for part in parts:
        assert accepting.passed_on(accepting.stops) == []
        client.sendall(part)
        accepting.acceptor.turn()
    assert accepting.passed_on(accepting.stops) == [port_of(client)]
    assert accepting.passed_on(accepting.others) == []


@pytest.mark.parametrize(
    "head",
    [
        STOP.replace(b"9", b"many"),
        STOP.replace(b"9", b"-1"),
        STOP.replace(b"9", b"9\r\nContent-Length: 9"),
        STOP.replace(b"9", b"9\r\nTransfer-Encoding: chunked"),
        STOP.replace(b"Content-Length: 9", b"Transfer-Encoding: gzip"),
        STOP.replace(b"9", b"9\r\nHost: localhost"),
        STOP.replace(b"Host: localhost\r\n", b""),
        STOP.replace(b"Host", b"no field\r\nHost"),
        STOP.replace(b"Host", b"Who: \0\r\nHost"),
        STOP.replace(b"Host", b"Who: \n\r\nHost"),
        STOP.replace(b"Host", b"Who: a\r\n b\r\nHost"),
        STOP.replace(b"Host", b"Connection: Upgrade\r\nUpgrade: websocket\r\nHost"),
        STOP.replace(b"Host", b"Origin: http://localhost\xa0\r\nHost"),
        STOP.replace(b"/stop", b"/stop?\xff"),
        STOP.replace(b"1.1", b"2.0"),
        STOP.replace(b"POST", b"post"),
        STOP[:-4] + b"\r\nA: " + 9000 * b"a",
        b"GET /" + b"a" * 20_000,
        # Other requests.
        STOP.replace(b"/stop", b"/stopped"),
        STOP.replace(b"/stop", b"/state"),
        STOP.replace(b"/stop", b"/"),
        STOP.replace(b"/stop", b"stop"),
        # Stops of another site.
        STOP.replace(b"Host", b"Origin: http://elsewhere\r\nHost"),
        STOP.replace(b"Host", b"Sec-Fetch-Site: cross-site\r\nHost"),
        STOP.replace(b"Host", b"sec-fetch-site:same-site\r\nHost"),
    ],
)
def test_what_is_no_stop_or_only_looks_like_one_goes_the_other_way(accepting, head):
    client = accepting.connect(head)
    assert accepting.passed_on(accepting.stops) == []
    assert accepting.passed_on(accepting.others) == [port_of(client)]


@pytest.mark.parametrize(("host", "passes"), [(b"127.0.0.1:8787", True), (b"elsewhere", False)])
def test_where_only_this_machine_may_ask_a_stop_names_it(opened, host, passes):
    accepting = Accepting(opened, here_alone=True)
    client = accepting.connect(STOP.replace(b"localhost", host))
    assert accepting.passed_on(accepting.stops) == ([port_of(client)] if passes else [])


def test_a_request_is_left_on_the_socket(accepting):
    accepting.connect(STOP)
    _, descriptors, _, _ = socket.recv_fds(accepting.stops, 1, 1)
    with socket.socket(fileno=descriptors[0]) as passed:
        assert passed.recv(4096) == STOP


@pytest.fixture
def three_at_most(monkeypatch):
    """Of one address, but for stops."""
    monkeypatch.setattr(acceptor, "_BURST", 3.0)
    monkeypatch.setattr(acceptor, "_RATE", 0.0)


def test_a_stop_passes_where_nothing_else_does(three_at_most, accepting):
    for _ in range(5):
        accepting.connect(ASK)
    stop = accepting.connect(STOP)
    other = accepting.connect(ASK, host="127.0.0.2")
    assert accepting.passed_on(accepting.stops) == [port_of(stop)]
    passed = accepting.passed_on(accepting.others)
    assert len(passed) == 4 and passed[-1] == port_of(other)


@pytest.mark.parametrize(
    ("length", "passes"), [(b"40", True), (b"257", False), (b"", False), (b"9" * 5000, False)]
)
def test_what_may_be_a_typed_stop_waits_for_no_other_request(
    three_at_most, accepting, length, passes
):
    for _ in range(5):
        accepting.connect(SAY % b"600")
    said = accepting.connect(SAY % length)
    assert (port_of(said) in accepting.passed_on(accepting.others)) == passes


def test_addresses_take_turns(opened, monkeypatch):
    monkeypatch.setattr(acceptor, "_BURST_OF_ALL", 4.0)
    monkeypatch.setattr(acceptor, "_RATE_OF_ALL", 0.0)
    accepting = Accepting(opened)
    turn = accepting.acceptor.turn
    accepting.acceptor.turn = lambda: None
    many = [accepting.connect(ASK) for _ in range(5)]
    single = accepting.connect(ASK, host="127.0.0.2")
    turn()
    passed = [many[0], single, many[1], many[2]]
    assert accepting.passed_on(accepting.others) == [port_of(each) for each in passed]


def test_the_oldest_one_of_the_address_that_has_most_gives_way(opened):
    accepting = Accepting(opened, most=5)
    single = accepting.connect(host="127.0.0.2")
    many = [accepting.connect() for _ in range(6)]
    assert [is_closed(each) for each in many] == [True, True, False, False, False, False]
    assert not is_closed(single)


def test_who_sends_no_whole_head_in_time_is_hung_up_on_even_if_it_trickles(opened):
    time = 0.0
    accepting = Accepting(opened, now=lambda: time)
    silent, slow = accepting.connect(), accepting.connect()
    for letter in ASK[:8]:
        assert not is_closed(silent) and not is_closed(slow)
        slow.setblocking(True)
        slow.sendall(bytes([letter]))
        time += 1.0
        accepting.acceptor.turn()
    assert is_closed(silent) and is_closed(slow)


def test_over_tls_the_first_bytes_are_enough(opened):
    accepting = Accepting(opened, encrypted=True)
    client = accepting.connect(b"\x16\x03\x01")
    assert accepting.passed_on(accepting.others) == [port_of(client)]


def test_it_ends_with_the_program_that_serves(accepting):
    accepting.connect(ASK)
    accepting.stops.close()
    assert not accepting.acceptor.turn()
