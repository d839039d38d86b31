"""Whom the robot answers to, and the token that others must know."""

import asyncio
import socket
import stat

import httpx
import pytest

from tests.helpers.failing import raising
from tests.helpers.served import served
from vizbot.core.errors import ConfigError
from vizbot.operator.api.auth import Guard, store_token, stored_token, token_path
from vizbot.operator.api.listener import reached_host
from vizbot.operator.api.proof import Credentials
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service
from vizbot.operator.session.session import OperatorSession


@pytest.fixture(autouse=True)
def settings_folder(tmp_path, monkeypatch):
    """Where tokens are kept."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))


class Guarded:
    """A guard whose time is set by hand, before an application that answers 200."""

    def __init__(self, token="secret"):
        self.time = 0.0
        self.guard = Guard(self.answer, Credentials(token), lambda: self.time)
        self.answered = []

    async def answer(self, scope, receive, send):
        self.answered.append(200)

    async def send(self, message):
        if "status" in message:
            self.answered.append(message["status"])

    def __call__(self, headers, path="/state", query=b"", client="10.0.0.9"):
        """The status with which a request is answered."""
        scope = {
            "type": "http", "method": "POST", "path": path, "query_string": query,
            "client": (client, 1),
            "headers": [(key.encode(), value.encode()) for key, value in headers.items()],
        }  # fmt: skip
        asyncio.run(self.guard(scope, None, self.send))
        return self.answered.pop()


def test_who_asks_too_often_is_refused_until_later_and_others_and_stop_are_not():
    guarded, host = Guarded(token=None), {"host": "localhost:8787"}
    codes = [guarded(host) for _ in range(200)]
    assert codes.index(429) == 150 and set(codes[150:]) == {429}
    assert guarded(host, path="/stop") == 200
    short, long = host | {"content-length": "40"}, host | {"content-length": "600"}
    assert guarded(short, path="/said") == 200 and guarded(long, path="/said") == 429
    endless = host | {"content-length": "9" * 5000}
    assert guarded(endless, path="/said") == 429
    assert guarded(host, client="10.0.0.10") == 200
    guarded.time = 1.0
    assert [guarded(host) for _ in range(60)].count(200) == 50


def test_beyond_this_machine_the_token_is_asked_for_but_not_to_stop():
    guarded, host = Guarded(), {"host": "robot:8787"}
    assert guarded(host) == 401
    assert guarded(host | {"authorization": "Bearer wrong"}) == 401
    assert guarded(host | {"authorization": "Bearer secret"}) == 200
    assert guarded(host | {"cookie": "token=secret"}) == 200
    assert guarded(host, query=b"token=secret") == 200
    assert guarded(host, path="/stop") == 200
    assert guarded(host | {"origin": "http://evil.example"}, path="/stop") == 403
    assert Guarded(token=None)(host) == 403


def test_the_token_is_made_once_and_is_for_its_owner_alone(tmp_path):
    with served(host="0.0.0.0") as first:
        assert token_path().read_text().strip() == first.token
    with served(host="0.0.0.0") as again:
        assert again.token == first.token
    mode = (tmp_path / "vizbot/token").stat().st_mode
    assert stat.S_IMODE(mode) == 0o600


def test_a_launch_that_fails_on_its_port_or_certificate_leaves_no_token_unseen(tmp_path):
    broken = tmp_path / "broken.pem"
    broken.write_text("no certificate")
    with socket.create_server(("0.0.0.0", 0)) as taken:
        failing = {"port": taken.getsockname()[1]}, {"certificate": broken, "key": broken}
        for service in failing:
            with pytest.raises(ConfigError):
                Server(OperatorSession(), Service(**({"host": "0.0.0.0", "port": 0} | service)))
    assert not token_path().exists()


def test_the_address_that_is_shown_opens_with_the_token_in_it():
    with served(host="0.0.0.0") as server:
        shown = httpx.URL(server.console_url)
        assert shown.params["token"] == server.token and shown.host != "0.0.0.0"
        assert httpx.get(shown).headers["content-type"].startswith("text/html")
        assert httpx.get(shown.copy_with(path="/state")).status_code == 200
        wrong = httpx.get(shown.copy_with(path="/state"), params={"token": "wrong"})
        assert wrong.json()["detail"].startswith("that is not this robot's token")
        none = httpx.get(shown.copy_with(path="/state", query=None))
        assert none.json()["detail"].startswith("give the robot's token")
    with served() as here:
        assert here.console_url == here.url


@pytest.mark.parametrize("host", ["0.0.0.0", "::"])
def test_all_addresses_are_reached_at_one_of_this_computers(host):
    reached = reached_host(host)
    if reached != socket.gethostname():
        with socket.socket(socket.AF_INET6 if ":" in reached else socket.AF_INET) as own:
            own.bind((reached, 0))  # no other address can be bound
    assert reached_host("192.0.2.7") == "192.0.2.7" and reached_host("robot") == "robot"


def test_a_computer_without_a_network_is_reached_by_its_name(monkeypatch):
    monkeypatch.setattr(socket.socket, "connect", raising(OSError("Network is unreachable")))
    assert reached_host("0.0.0.0") == socket.gethostname()


def test_a_token_that_cannot_be_kept_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "file"))
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="check that folder"):
        Server(OperatorSession(), Service(host="0.0.0.0", port=0))


HERE = ("127.0.0.1", "[::1]", "localhost", "0.0.0.0", socket.gethostname())
ELSEWHERE = ("robot", "203.0.113.9", "[2001:db8::9]", "localhost.example", "127.0.0.1.example")


@pytest.mark.parametrize("host", [*HERE, *ELSEWHERE])
def test_the_kept_token_is_for_this_machine_alone(host):
    store_token("a" * 32)
    kept = "a" * 32 if host in HERE else None
    assert stored_token(f"http://{host}:8787") == kept
    assert stored_token(f"https://{host}") == kept


@pytest.mark.parametrize(
    "url", ["", "robot", "127.0.0.1:8787", "http://", "http://[::1", "http://é" + "a" * 99]
)
def test_no_token_goes_to_what_is_no_address(url):
    assert stored_token(url) is None


@pytest.mark.parametrize("content", ["", "short\n", b"\xff\xfe" * 20])
def test_a_token_that_is_none_is_one_line(tmp_path, content):
    path = tmp_path / "vizbot/token"
    path.parent.mkdir()
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(ConfigError, match=r"vizbot/token .* delete it"):
        Server(OperatorSession(), Service(host="0.0.0.0", port=0))


def test_who_gives_no_token_is_not_let_in_by_an_empty_one():
    assert Guarded("")({"host": "robot:8787", "authorization": "Bearer "}) == 401


def test_a_flood_of_messages_ends_the_link():
    sent = iter([{"type": "websocket.receive", "text": str(n)} for n in range(1000)])
    came = []

    async def receive():
        return next(sent)

    async def listen(scope, receive, send):
        while not came or came[-1]["type"] == "websocket.receive":
            came.append(await receive())

    guard = Guard(listen, Credentials(None), lambda: 0.0)
    scope = {"type": "websocket", "path": "/drive", "headers": [(b"host", b"localhost")]}
    asyncio.run(guard(scope, receive, None))
    assert came.pop() == {"type": "websocket.disconnect", "code": 1008}
    assert [message["text"] for message in came] == [str(n) for n in range(200)]
