"""Requests that are malformed, endless or costly to read are refused, and all others answered."""

import json
import socket

import pytest

from tests.helpers.clients import client_of
from tests.helpers.roomba_rig import wait_for
from tests.helpers.served import served
from vizbot.operator.api.connections import connection_limits

STOP = b"POST /stop HTTP/1.1\r\nHost: localhost\r\n"
CHUNKED = STOP + b"Transfer-Encoding: chunked\r\n\r\n"
JSON = b"Content-Type: application/json\r\n"
WHO = b'{"who": "ann"}'


def answered(client):
    """The status and the body of the answer."""
    answer = b"".join(iter(lambda: client.recv(4096), b""))
    head, body = answer.split(b"\r\n\r\n", 1)
    return int(head.split()[1]), json.loads(body)


def stopped_by(session):
    return [line.text for line in session.log.lines() if line.text.startswith("stopped by")]


@pytest.mark.parametrize(
    "parts",
    [
        [STOP + b"Content-Length: 14\r\n\r\n" + WHO],
        [STOP + b"Content-Length: 14\r\n\r\n", WHO[:5], WHO[5:]],
        [CHUNKED + b"e\r\n" + WHO + b"\r\n0\r\n\r\n"],
        [CHUNKED, b"e;x=y\r\n", WHO + b"\r\n", b"0\r\nDone: yes\r\n\r\n"],
        [STOP + b"A: " + 9000 * b"a", b"\r\nContent-Length: 14\r\n", b"\r\n" + WHO],
    ],
)
def test_a_request_is_read_however_it_comes(server, session, opened, parts):
    client = client_of(server, opened)
    client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    for part in parts:
        client.sendall(part)
    assert answered(client) == (200, {"stopped": True})
    assert stopped_by(session) == ["stopped by ann"]


@pytest.mark.slow
def test_a_large_body_in_chunks_is_read(server, opened):
    client = client_of(server, opened)
    head = CHUNKED.replace(b"/stop", b"/doubt").replace(b"Host", JSON + b"Host")
    body = b'{"question": "what?"}'.ljust(40_000)
    client.sendall(head + b"%x\r\n%b\r\n" % (len(body), body))
    client.sendall(b"0\r\n\r\n")
    assert answered(client) == (200, {"shown": True})


def test_what_is_no_head_is_refused_and_stops_nothing(server, session, opened):
    for head in (
        STOP + b"Content-Length: many\r\n\r\n",
        STOP + b"no field\r\n\r\n",
        STOP + b"A:" + 7900 * b"\t" + b"\0\r\n\r\n",
        (STOP + b"A: ").ljust(16 * 1024, b"a"),
    ):
        client = client_of(server, opened)
        client.sendall(head)
        refused = {"detail": "this is no HTTP request, or its head is too long"}
        assert answered(client) == (400, refused), head
        assert session.stops == 0, head


@pytest.mark.parametrize(
    "line", [b"1;" + 7900 * b"\t" + b"\n\r\n", b"0\r\nA:" + 7900 * b"\t" + b"\0"]
)
def test_long_lines_between_chunks_are_refused(server, opened, line):
    client = client_of(server, opened)
    client.sendall(CHUNKED.replace(b"/stop", b"/doubt") + line)
    assert client.recv(4096).startswith(b"HTTP/1.1 400 ")


def test_who_trickles_a_head_is_hung_up_on_in_the_time_of_a_silent_one(
    session, opened, monkeypatch
):
    monkeypatch.setattr(connection_limits, "_REQUEST_TIMEOUT", 0.3)
    with served(session) as server:
        client = client_of(server, opened)
        client.sendall(STOP + b"A: " + 9000 * b"a")
        client.settimeout(0.05)
        wait_for(lambda: _is_cut_off(client))
    assert session.stops == 0


def _is_cut_off(client):
    """Whether a connection is closed, once one more letter was sent."""
    try:
        client.sendall(b"a")
        return client.recv(1) == b""
    except TimeoutError:
        return False
    except (BrokenPipeError, ConnectionResetError):
        return True
