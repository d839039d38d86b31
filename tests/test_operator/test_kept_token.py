"""The token that is kept on this machine opens the robot's door, and no stranger learns it."""

import json

import httpx
import pytest

from tests.helpers.impostor import Impostor, http_answer
from tests.helpers.roomba_rig import wait_for
from tests.helpers.served import served
from vizbot.core.errors import DeviceError
from vizbot.operator.api.auth import store_token, token_path
from vizbot.operator.api.proof import Credentials, prove, run_token
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service
from vizbot.operator.client.remote_drive import RemoteDrive
from vizbot.operator.client.robot_client import RobotClient
from vizbot.operator.session.session import OperatorSession

TOKEN = "kept" * 8
RUN = "r" * 22


@pytest.fixture(autouse=True)
def kept(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    store_token(TOKEN)


@pytest.fixture
def challenges(monkeypatch):
    """All challenges that servers of this process answer, as they come."""
    came, answer = [], Credentials.answer

    def answer_and_count(credentials, challenge, address):
        came.append(challenge)
        return answer(credentials, challenge, address)

    monkeypatch.setattr(Credentials, "answer", answer_and_count)
    return came


def challenge_of(request):
    path = request.split(b" ", 2)[1].decode()
    return httpx.URL(path).params.get("challenge", "")


def shown(proof, run=RUN):
    return http_answer(json.dumps({"run": run, "proof": proof}).encode())


def signed_with(token):
    return lambda request, port: shown(
        prove(token, challenge_of(request), RUN, ("127.0.0.1", port))
    )


IMPOSTORS = {
    "a page": lambda request, port: http_answer(b"<html>", kind="text/html"),
    "nothing at all": lambda request, port: b"",
    "no HTTP": lambda request, port: b"SSH-2.0-OpenSSH_9.2\r\n",
    "an older robot": lambda request, port: http_answer(b'{"detail": "Not Found"}', 404),
    "the token is wanted": lambda request, port: http_answer(b'{"detail": "give it"}', 401),
    "look elsewhere": lambda request, port: (
        b"HTTP/1.1 307 X\r\nLocation: /state\r\nContent-Length: 0\r\n\r\n"
    ),
    "a made-up proof": lambda request, port: shown("0" * 64),
    "a proof that is no text": lambda request, port: shown([]),
    "an empty proof": lambda request, port: shown(""),
    "a proof that no encoding has": lambda request, port: shown("\udcff"),
    "the challenge itself": lambda request, port: shown(challenge_of(request)),
    "the proof of another token": signed_with("else" * 8),
    "the proof of an empty token": signed_with(""),
    "the proof of another port": lambda request, port: shown(
        prove(TOKEN, challenge_of(request), RUN, ("127.0.0.1", port + 1))
    ),
    "the proof of another address": lambda request, port: shown(
        prove(TOKEN, challenge_of(request), RUN, ("127.0.0.2", port))
    ),
    "the proof of another challenge": lambda request, port: shown(
        prove(TOKEN, "c" * 22, RUN, ("127.0.0.1", port))
    ),
    "what stands for the token": lambda request, port: shown(run_token(TOKEN, RUN)),
    "no token is wanted": lambda request, port: (
        shown(None) if b"/proof" in request else http_answer(b'{"detail": "give it"}', 401)
    ),
}
ASKED = {
    "state": lambda client: client.state(),
    "say": lambda client: client.say("sofa", "ann"),
    "drive": lambda client: RemoteDrive(client, "ann"),
}


@pytest.mark.sampled
@pytest.mark.parametrize("asked", ASKED)
@pytest.mark.parametrize("kind", IMPOSTORS)
def test_a_stranger_at_the_port_is_refused_in_one_line_and_learns_no_token(kind, asked):
    def answer(request):
        return IMPOSTORS[kind](request, int(impostor.url.rsplit(":", 1)[1]))

    with (
        Impostor(answer) as impostor,
        RobotClient(impostor.url, None) as client,
        pytest.raises(DeviceError) as refusal,
    ):
        ASKED[asked](client)
    assert len(str(refusal.value).splitlines()) == 1
    assert impostor.url in str(refusal.value)
    if kind not in ("nothing at all", "no HTTP", "no token is wanted"):
        assert f"is not the vizbot whose token is kept in {token_path()}" in str(refusal.value)
        assert len(impostor.requests) == 1  # the challenge, and nothing else
    everything = b"".join(impostor.requests)
    assert everything.startswith(b"GET /proof?challenge=")
    assert TOKEN.encode() not in everything and b"authorization" not in everything.lower()


def test_a_stranger_who_passes_the_challenge_on_to_the_robot_is_refused(challenges):
    with served(host="0.0.0.0") as server:

        def relay(request):
            return httpx.get(f"{server.url}/proof?challenge={challenge_of(request)}").content

        with (
            Impostor(lambda request: http_answer(relay(request))) as impostor,
            RobotClient(impostor.url, None) as client,
            pytest.raises(DeviceError, match="is not the vizbot"),
        ):
            client.state()
    assert len(challenges) == len(impostor.requests) == 1


@pytest.mark.slow
def test_a_robot_with_another_token_is_refused():
    with served(host="0.0.0.0") as server:
        token_path().unlink()
        store_token("else" * 8)
        with (
            RobotClient(server.url, None) as client,
            pytest.raises(DeviceError, match=r"is not the vizbot .*; nothing was sent; give"),
        ):
            client.state()
        with RobotClient(server.url, TOKEN) as client:
            client.state()


@pytest.mark.parametrize("host", ["0.0.0.0", "127.0.0.1", "localhost"])
def test_the_robot_itself_proves_to_know_the_token_once_for_all_requests(challenges, session, host):
    with (
        served(session, host="0.0.0.0") as server,
        RobotClient(server.url.replace("0.0.0.0", host), None) as client,
    ):
        client.ask(["sofa"])
        client.state()
        with RemoteDrive(client, "ann") as drive:
            wait_for(lambda: session.lease.holder == "ann" and drive._state is not None)
    assert len(challenges) == len(set(challenges)) == 1


def test_what_the_robot_is_given_is_of_no_use_after_its_end(challenges):
    with served(host="0.0.0.0") as server, RobotClient(server.url, None) as client:
        client.state()
        port = int(server.url.rsplit(":", 1)[1])
        server.close()
        with (
            Impostor(lambda request: http_answer(b"{}"), port) as impostor,
            pytest.raises(DeviceError, match="no vizbot"),
        ):
            client.state()
        [request] = impostor.requests
        [line] = [line for line in request.split(b"\r\n") if b"uthorization" in line]
        given = line.split(b"Bearer ")[1].decode()
        with Server(OperatorSession(), Service("0.0.0.0", port)) as again:
            assert again.token == TOKEN
            stolen = {"Authorization": f"Bearer {given}"}
            assert httpx.get(f"{again.url}/state", headers=stolen).status_code == 401
            client.state()  # which proves itself anew
    assert len(challenges) == 2


@pytest.mark.slow
def test_a_robot_that_wants_no_token_is_sent_none(challenges, monkeypatch):
    with served() as server, RobotClient(server.url, None) as client:
        client.state()
        client.state()
        assert client._authorization.headers() == {}
    assert len(challenges) == 1


def test_a_stop_takes_no_token_and_no_challenge():
    with (
        Impostor(lambda request: http_answer(b'{"stopped": true}')) as impostor,
        RobotClient(impostor.url, None) as client,
    ):
        client.stop("ann")
    [request] = impostor.requests
    assert request.startswith(b"POST /stop ") and b"authorization" not in request.lower()


@pytest.mark.parametrize("challenge", ["", "short", "a" * 65])
def test_a_challenge_of_another_length_is_refused(challenge):
    with served(host="0.0.0.0") as server:
        answer = httpx.get(f"{server.url}/proof", params={"challenge": challenge})
    assert answer.status_code == 422 and TOKEN not in answer.text
