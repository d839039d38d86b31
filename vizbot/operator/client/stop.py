"""The stop of a running robot, by the standard library alone: nothing else is loaded before it."""

from __future__ import annotations

import getpass
import json
import socket
import time
from contextlib import ExitStack
from urllib.parse import urlsplit

from vizbot.core.errors import ConfigError, DeviceError

PORT = 8787
HERE = f"http://127.0.0.1:{PORT}"
"""Address of the robot that runs on this machine."""
_TIMEOUT = 12.0
"""Longest wait for the answer [s]."""
_MAX_ANSWER = 64 * 1024
"""What answers with more than this is no robot [bytes]."""


def send_stop(url: str) -> None:
    """Stop the robot at `url` now; it asks for no token.

    Raises:
        ConfigError: the URL is not valid.
        DeviceError: the robot does not answer.
    """
    url = url.rstrip("/")
    try:
        status, body = _posted(url, json.dumps({"who": whoami()}).encode())
    except (OSError, ValueError) as error:
        raise unreached(url, error) from error
    try:
        answer = json.loads(body)
    except (ValueError, RecursionError):
        answer = None
    said = answer if isinstance(answer, dict) else {}
    if status >= 400 and isinstance(said.get("detail"), str):
        raise DeviceError(f"the robot at {url} refuses: {said['detail']}")
    if status != 200 or said.get("stopped") is not True:
        raise no_vizbot(url)


def unreached(url: str, error: Exception) -> DeviceError:
    """The error where nothing answers, or not as it should."""
    if "CERTIFICATE_VERIFY_FAILED" in str(error):
        return DeviceError(
            f"the certificate of {url} is not trusted here ({error}); name it:"
            " SSL_CERT_FILE=robot.pem"
        )
    return DeviceError(
        f"no robot answers at {url} ({error}); start `vizbot launch` there or give another --url"
    )


def no_vizbot(url: str) -> DeviceError:
    """The error where something else answers."""
    return DeviceError(
        f"what answers at {url} is no vizbot, or one of another version; give another --url, or"
        " the same version on both machines"
    )


def whoami() -> str:
    """The user's name; where there is none, a stop is sent all the same."""
    try:
        return getpass.getuser().encode(errors="replace").decode()
    except Exception:
        return "somebody"


def _posted(url: str, content: bytes) -> tuple[int, bytes]:
    """HTTP status and body of the answer to a stop.

    Raises:
        ConfigError: the URL is not valid.
        OSError: nothing answers there.
        ValueError: what answers is no HTTP, too much, or too late.
    """
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port or {"http": 80}.get(parts.scheme, 443)
        address = parts.netloc.rpartition("@")[2]
    except ValueError as error:
        raise ConfigError(f"--url {url}: {error}; give one like http://robot:8787") from error
    if not url.startswith(("http://", "https://")) or not host:
        raise ConfigError(f"--url {url!r} is no address; give one like http://robot:8787")
    head = (
        f"POST {parts.path}/stop HTTP/1.0\r\nHost: {address}\r\n"
        "Content-Type: application/json\r\nAccept-Encoding: identity\r\n"
        f"Content-Length: {len(content)}\r\n\r\n"
    )
    until, received = time.monotonic() + _TIMEOUT, bytearray()
    with ExitStack() as opened:
        link = opened.enter_context(socket.create_connection((host, port), _TIMEOUT))
        if parts.scheme == "https":
            import ssl  # takes longer to load than all else

            # As everywhere on this machine: SSL_CERT_FILE names a certificate that is not public.
            trusted = ssl.create_default_context()
            link = opened.enter_context(trusted.wrap_socket(link, server_hostname=host))
        link.sendall(head.encode("ascii") + content)
        while part := link.recv(_MAX_ANSWER):
            received += part
            if len(received) > _MAX_ANSWER:
                raise ValueError(f"an answer of more than {_MAX_ANSWER} bytes")
            if time.monotonic() > until:
                raise ValueError("an answer that does not end")
    try:
        first, _, body = bytes(received).partition(b"\r\n\r\n")
        return int(first.split(None, 2)[1]), body
    except (ValueError, IndexError) as error:
        raise ValueError("no HTTP") from error
