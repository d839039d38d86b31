"""The port that a run is served at and its certificate, also to be checked before a run is opened.

Nothing heavy is imported, so that what cannot be served is refused at once.
"""

from __future__ import annotations

import ipaddress
import socket
import ssl

from vizbot.core.errors import ConfigError
from vizbot.operator.api.connections.acceptor import QUEUE
from vizbot.operator.api.connections.head import is_loopback
from vizbot.operator.client.endpoint import SPEECH, Service

_FAR_AWAY = {socket.AF_INET: "192.0.2.1", socket.AF_INET6: "2001:db8::1"}
"""Addresses of documentation, which no computer has."""
_PAIR = "give a certificate and its key as PEM"


def require_service(service: Service) -> None:
    """Check beforehand whether a run can be served so; nothing stays open.

    Raises:
        ConfigError: the port, the certificate, the token or the speech model cannot be used.
    """
    require_certificate(service)
    if not is_loopback(service.host):
        from vizbot.operator.api.auth import own_token

        own_token()
    open_listener(service).close()
    if service.speech != SPEECH:  # without the package nobody is to be kept from serving
        from vizbot.operator.voice.recogniser import require_model

        require_model(service.speech)


def require_certificate(service: Service) -> None:
    """Check certificate and key, where there are any.

    Raises:
        ConfigError: one is missing, cannot be read, or is not for the other.
    """
    certificate, key = service.certificate, service.key
    if certificate is None and key is None:
        return
    if certificate is None or key is None:
        given = f"--tls-key {key}" if certificate is None else f"--tls-certificate {certificate}"
        raise ConfigError(
            f"{given}: a certificate needs its key: give both --tls-certificate and --tls-key"
        )
    for option, path in (("--tls-certificate", certificate), ("--tls-key", key)):
        if not path.is_file():
            raise ConfigError(f"{option} {path} is no file; {_PAIR}")
    try:
        # A key that asks for a password would ask the terminal.
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(certificate, key, password="")
    except (OSError, ValueError) as error:
        raise ConfigError(
            f"--tls-certificate {certificate} cannot be used with --tls-key {key} ({error});"
            f" {_PAIR} without a password"
        ) from error


def open_listener(service: Service) -> socket.socket:
    """Open the port.

    Raises:
        ConfigError: it cannot be used.
    """
    host, port = service.host, service.port
    if not host:  # which would silently be every address
        raise ConfigError("--host '' is empty; give an address of this machine, such as 0.0.0.0")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family, backlog=QUEUE)
    except (OSError, UnicodeError) as error:
        reason = (isinstance(error, OSError) and error.strerror) or "no host has such a name"
        reason, _, _ = reason.partition(" (while")  # which repeats the address
        raise ConfigError(
            f"cannot serve at {host}:{port}: {reason}; give another --port or --host"
        ) from error


def reached_host(host: str) -> str:
    """The address or name by which other computers reach a server that listens on `host`.

    Where that is every address of this computer, it is the one that it has in its network, or its
    name where it is in none. Nothing is sent.
    """
    try:
        if not ipaddress.ip_address(host).is_unspecified:
            return host
    except ValueError:  # a name
        return host
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.connect((_FAR_AWAY[family], 9))  # chooses its own address for the way there
            return str(probe.getsockname()[0])
    except OSError:  # there is no way there
        return socket.gethostname()
