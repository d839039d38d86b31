"""HTTP requests to the address of a robot, whatever it is that answers there."""

from __future__ import annotations

import json
import ssl
import time
from collections.abc import Mapping
from dataclasses import dataclass

import httpx

from vizbot.core.errors import ConfigError
from vizbot.operator.client.stop import unreached

_MAX_ANSWER = 32 * 1024 * 1024
"""What answers with more than this is no robot [bytes]."""


@dataclass(frozen=True, slots=True)
class HttpAnswer:
    """What came back.

    Attributes:
        status: HTTP status code.
        content: The JSON that was answered; None where it was none.
        address: Host and port of the server's end of the connection; empty where it is not known.
    """

    status: int
    content: object
    address: tuple[object, ...]


class HttpLink:
    """Requests to one address, each on a connection of its own, as the robot has it.

    Attributes:
        url: The address.
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
