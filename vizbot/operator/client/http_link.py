"""HTTP requests to the address of a robot, whatever answers there, and what authorises them."""

from __future__ import annotations

import hmac
import json
import secrets
import ssl
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass

import httpx
from pydantic import ValidationError

from vizbot.core.errors import ConfigError, DeviceError
from vizbot.operator.api.answers import TokenProof
from vizbot.operator.api.auth import token_path
from vizbot.operator.api.proof import PROOF_PATH, prove, run_token
from vizbot.operator.client.stop import unreached

_TIMEOUT = 12.0
"""[s]"""

_MAX_ANSWER = 32 * 1024 * 1024
"""What answers with more than this is no robot [bytes]."""


@dataclass(frozen=True, slots=True)
class HttpAnswer:
    """What came back.

    Attributes:
        content: The JSON that was answered; None where it was none.
        address: Host and port of the server's end of the connection; empty where it is not known.
    """

    status: int
    content: object
    address: tuple[object, ...]


class HttpLink:
    """Requests to one address, each on a connection of its own, as the robot has it.

    Attributes:
        trusted: The certificates that are trusted; None for http.
    """

    def __init__(self, url: str, transport: httpx.BaseTransport | None = None) -> None:
        """Create it without sending anything; in tests `transport` stands in for the network.

        Raises:
            ConfigError: the URL is not valid.
        """
        if not url.startswith(("http://", "https://")):
            raise ConfigError(f"--url {url!r} is no address; give one like http://robot:8787")
        self.url = url.rstrip("/")
        # As everywhere on this machine: SSL_CERT_FILE names a certificate that is not public.
        self.trusted = ssl.create_default_context() if self.url.startswith("https:") else None
        try:
            self._http = httpx.Client(
                base_url=self.url,
                headers={"Accept-Encoding": "identity"},
                limits=httpx.Limits(max_keepalive_connections=0),
                transport=transport,
                trust_env=False,  # a robot at home is not behind the office's proxy
                verify=self.trusted or False,  # http needs no certificates, which take time to load
            )
        except (httpx.InvalidURL, ValueError) as error:
            raise ConfigError(f"--url {url}: {error}; give one like http://robot:8787") from error

    def exchange(
        self,
        method: str,
        path: str,
        content: Mapping[str, object] | None,
        headers: Mapping[str, str],
        timeout: float,
    ) -> HttpAnswer:
        """Send a request, with JSON or None as its content, and return the answer.

        Raises:
            DeviceError: nothing answers there within `timeout` [s], or no HTTP, or too much.
        """
        until = time.monotonic() + timeout
        try:
            with self._http.stream(
                method, path, json=content, headers=dict(headers), timeout=timeout
            ) as answer:
                stream = answer.extensions.get("network_stream")
                address = () if stream is None else stream.get_extra_info("server_addr")
                body = _body(answer, until)
        except (httpx.HTTPError, httpx.InvalidURL, OSError, ValueError) as error:
            raise unreached(self.url, error) from error
        return HttpAnswer(answer.status_code, _json(body), tuple(address))

    def close(self) -> None:
        """Close the connection."""
        self._http.close()


def _body(answer: httpx.Response, until: float) -> bytes:
    """The body of an answer.

    Raises:
        ValueError: it is packed or too large, or does not end in time.
    """
    if answer.headers.get("Content-Encoding", "identity") != "identity":
        raise ValueError("a packed answer, which was not asked for")
    body = bytearray()
    for part in answer.iter_bytes():
        body += part
        if len(body) > _MAX_ANSWER:
            raise ValueError(f"an answer of more than {_MAX_ANSWER} bytes")
        if time.monotonic() > until:
            raise ValueError("an answer that does not end")
    return bytes(body)


def _json(body: bytes) -> object:
    try:
        return json.loads(body)
    except (ValueError, RecursionError):
        return None


class Authorization:
    """The token that a person gives, or what stands for the one kept on this machine.

    A kept token is never sent. Once for each client the server proves that it knows it; then what
    stands for it in that run is given.
    """

    def __init__(self, link: HttpLink, given: str | None, kept: str | None) -> None:
        """Create it, sending nothing; a `given` token is sent as it is, else `kept` counts."""
        self._link = link
        self._given = given
        self._kept = kept if given is None else None
        self._proved = False
        self._lock = threading.Lock()

    @property
    def is_kept(self) -> bool:
        """Whether the server must prove itself."""
        return self._kept is not None

    @property
    def is_none(self) -> bool:
        """Whether there is no token to send."""
        return self._given is None and self._kept is None

    def headers(self, *, anew: bool = False) -> dict[str, str]:
        """The headers of a request; `anew` has a server that was launched again prove itself again.

        Raises:
            ConfigError: the token is none that a robot may have.
            DeviceError: nothing answers, or not the robot whose token is kept.
        """
        if self._given is not None and not (self._given.isascii() and self._given.isprintable()):
            raise ConfigError("--token: it holds what no token does; give it as launch shows it")
        with self._lock:
            if self._kept is not None and (anew or not self._proved):
                self._given = self._stand_in(self._kept)
                self._proved = True
            return {} if self._given is None else {"Authorization": f"Bearer {self._given}"}

    def _stand_in(self, kept: str) -> str | None:
        """What to give in place of the kept token; None where the robot wants none."""
        challenge = secrets.token_urlsafe(16)
        path = f"{PROOF_PATH}?challenge={challenge}"
        answer = self._link.exchange("GET", path, None, {}, _TIMEOUT)
        if answer.status == 429:
            raise DeviceError(f"the robot at {self._link.url} has too many requests; ask later")
        shown = _proof(answer)
        if shown is not None and shown.proof is None:
            return None
        if shown is None or not hmac.compare_digest(
            (shown.proof or "").encode("utf-8", "replace"),
            prove(kept, challenge, shown.run, answer.address).encode(),
        ):
            raise DeviceError(
                f"what answers at {self._link.url} is not the vizbot whose token is kept in"
                f" {token_path()}; nothing was sent; give another --url, or that robot's --token"
            )
        return run_token(kept, shown.run)


def _proof(answer: HttpAnswer) -> TokenProof | None:
    """The answer to a challenge; None where it is none."""
    try:
        return TokenProof.model_validate(answer.content) if answer.status == 200 else None
    except ValidationError:
        return None
