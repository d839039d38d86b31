"""Every command for a running robot ends in one line where something else answers at its port."""

import gzip
import itertools
import os
from types import SimpleNamespace

import pytest

from tests.helpers.impostor import Impostor, http_answer
from vizbot.commands import teleop, voice
from vizbot.operator.api.auth import store_token
from vizbot.operator.client import http_link, robot_client
from vizbot.operator.language.command import GoTo
from vizbot.operator.voice.intent import Utterance

COMMANDS = {
    "goal": ["goal", "sofa", "--wait"],
    "goal that stops": ["goal", "stop"],
    "explore": ["explore", "--now"],
    "stop": ["stop"],
    "status": ["status"],
    "status as JSON": ["status", "--json"],
    "teleop": ["teleop"],
    "voice": ["voice", "--wav", "said.wav"],
}
STRANGERS = {
    "a page": http_answer(b"<html>\n<p>\n", kind="text/html"),
    "another API": http_answer(b'{"status": "up", "detail": ["a\\nb"]}'),
    "a refusal with lines": http_answer(b'{"detail": "one\\ntwo \\u001b[2J"}', 403),
    "no HTTP": b"SSH-2.0-OpenSSH_9.2\r\n",
    "nothing": b"",
    "half an answer": b"HTTP/1.1 200 OK\r\nContent-Length: 1000\r\n\r\n{",
    "a packed answer": b"HTTP/1.1 200 OK\r\nContent-Encoding: gzip\r\n\r\n" + gzip.compress(b"{}"),
    "an upgrade": (
        b"HTTP/1.1 101 X\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        b"Sec-WebSocket-Accept: none\r\n\r\n"
    ),
    "a redirection to itself": (b"HTTP/1.1 302 X\r\nLocation: /state\r\nContent-Length: 0\r\n\r\n"),
    "an answer without end": lambda: itertools.chain(
        [b"HTTP/1.1 200 OK\r\n\r\n"], itertools.repeat(b" " * 65536)
    ),
    "a head without end": lambda: itertools.chain(
        [b"HTTP/1.1 200 OK\r\n"], itertools.repeat(b"X-More: yes\r\n" * 1000)
    ),
}


@pytest.fixture
def run(command_line, monkeypatch, tmp_path):
    """Run a command line at a terminal; return exit code, standard output, error output."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(http_link, "_MAX_ANSWER", 1024 * 1024)
    monkeypatch.setattr(robot_client, "_OPEN_TIMEOUT", 0.5)
    utterance = Utterance("go to the sofa", GoTo(("sofa",)), ())
    deaf = SimpleNamespace(learn=lambda words: None)
    monkeypatch.setattr(voice, "Recogniser", lambda *_, **__: deaf)
    monkeypatch.setattr(voice, "transcribe", lambda *_: utterance)
    (tmp_path / "said.wav").touch()
    terminal = os.openpty()
    monkeypatch.setattr(teleop, "_STANDARD_INPUT", terminal[1])
    yield command_line
    for each in terminal:
        os.close(each)


@pytest.mark.sampled
@pytest.mark.parametrize("kept", [False, True], ids=["no token", "a kept token"])
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("stranger", STRANGERS)
def test_a_server_that_is_no_vizbot_is_one_line_for(command, stranger, kept, run):
    if kept:
        store_token("kept" * 8)
    answer = STRANGERS[stranger]
    with Impostor(lambda _: answer if isinstance(answer, bytes) else answer()) as impostor:
        code, _, shown = run(*COMMANDS[command], "--url", impostor.url)
    assert code == 1
    assert len(shown.splitlines()) == 1
    assert "Traceback" not in shown and "\x1b" not in shown
    assert impostor.url in shown
    assert b"kept" not in b"".join(impostor.requests)
