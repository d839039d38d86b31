"""The head of a request is read as the HTTP library reads it, and at once whatever it holds."""

import h11
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vizbot.operator.api.connections.head import Head, read_head

LINES = (
    b"Host: localhost", b"host:robot", b"Origin: http://localhost\xa0", b"Cookie: a=\x01",
    b"Content-Length: 9", b"content-length: \t9 ", b"Content-Length: 9, 9", b"Content-Length:",
    b"Content-Length: +9", b"Content-Length: \xb2", b"Content-Length: %d" % 10**19,
    b"Content-Length: %d" % 10**20, b"Transfer-Encoding: chunked", b"Transfer-Encoding: Chunked",
    b"Transfer-Encoding: gzip, chunked", b"Upgrade: websocket", b"Who : ann", b"Who:\t", b" folded",
    b": nameless", b"no field", b"Who: a\nHost: elsewhere", b"Who: a\rb", b"Who: \0", b"Who: \x0b",
    b"W\xe9: a", b"",
)  # fmt: skip
REQUESTS = (
    b"POST /stop HTTP/1.1", b"POST /stop?who=ann HTTP/1.0", b"GET / HTTP/1.1", b"G?T / HTTP/1.1",
    b"POST /stop", b"POST  /stop HTTP/1.1", b"POST /st\xf6p HTTP/1.1", b"POST /stop HTTP/2.0",
    b"POST /stop http/1.1", b"POST /stop HTTP/1.1 ", b"",
)  # fmt: skip


def lines(*several):
    return b"\r\n".join(several) + b"\r\n\r\n"


def test_a_head_is_read_without_what_follows():
    sent = lines(b"POST /stop?x HTTP/1.1", b"Host: robot:8787", b"WHO:\t ann  b ", b"Empty:")
    headers = {"host": "robot:8787", "who": "ann  b", "empty": ""}
    assert read_head(sent + b"\0\r\n\r\n") == Head("POST", "/stop", headers)


@pytest.mark.parametrize("sent", [b"", b"POST /stop HTTP/1.1\r\nHost: localhost\r\n"])
def test_what_is_not_whole_is_no_head(sent):
    assert read_head(sent) is None


def test_a_head_has_at_most_a_hundred_lines():
    full = [b"GET / HTTP/1.1", b"Host: localhost", *99 * [b"A:"]]
    assert read_head(lines(*full)) is not None
    assert read_head(lines(*full, b"A:")) is None


@given(
    st.sampled_from(REQUESTS),
    st.lists(st.sampled_from(LINES), max_size=4),
    st.lists(st.binary(max_size=4), max_size=1),
)
def test_whatever_is_a_head_is_read_alike_by_the_library(request, fields, more):
    sent = lines(request, b"Host: localhost", *fields, *more)
    head = read_head(sent)
    if head is None:
        return
    connection = h11.Connection(h11.SERVER)
    connection.receive_data(sent)
    read = connection.next_event()
    assert isinstance(read, h11.Request)
    assert read.method.decode() == head.method
    assert read.target.decode().split("?")[0] == head.path
    headers = {name.decode(): value.decode("latin-1") for name, value in read.headers}
    assert headers | {"transfer-encoding": ""} == head.headers | {"transfer-encoding": ""}


@pytest.mark.parametrize("begin", [b"A:", b"A: b", b" ", b"A"])
def test_a_line_of_a_megabyte_is_refused_at_once(begin):
    spaces = begin + (1 << 20) * b"\t" + b"\0"  # hours, where each one is matched in every way
    assert read_head(lines(b"GET / HTTP/1.1", b"Host: localhost", spaces)) is None
