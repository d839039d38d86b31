"""The server of the API, in a thread of its own beside the robot's loop."""

from __future__ import annotations

import socket
import threading
from contextlib import ExitStack
from typing import Self

import uvicorn

from vizbot.core.errors import ConfigError
from vizbot.operator.api.app import build_app
from vizbot.operator.api.auth import Guard, is_loopback, own_token, store_token
from vizbot.operator.api.connection_limits import BoundedListener
from vizbot.operator.api.image_stream import Pictures
from vizbot.operator.client.endpoint import Service
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.voice.dialogue import Dialogue

_MAX_MESSAGE = 4096
"""Size of a message that a client sends over a WebSocket [bytes]."""
_PING_PERIOD = 5.0
"""A WebSocket whose client does not answer a ping within this time is closed [s]."""
_CLOSE_TIMEOUT = 10.0
"""[s]"""
_QUEUE, _ACCEPTED_AT_ONCE = 1024, 8
"""Connections that may wait in the kernel, and those accepted in one turn of the loop."""
_SWEEP_PERIOD = 1
"""Between two searches for silent connections [s]."""


class Server:
    """Serves the API until it is closed.

    Attributes:
        url: The address of the console.
        token: The token that clients must give; None where only this machine reaches the robot.
        token_is_new: Whether the token has never been shown.
    """

    def __init__(self, session: OperatorSession, service: Service) -> None:
        """Open the port and serve.

        Raises:
            ConfigError: the port, the certificate or the token cannot be used.
        """
        if (service.certificate is None) != (service.key is None):
            raise ConfigError(
                "a certificate needs its key: give both --tls-certificate and --tls-key"
            )
        for path in (service.certificate, service.key):
            if path is not None and not path.is_file():
                raise ConfigError(f"{path} is no file; give a certificate and its key as PEM")
        self.token, self.token_is_new = None, False
        if not is_loopback(service.host):
            self.token, self.token_is_new = own_token()
        family = socket.AF_INET6 if ":" in service.host else socket.AF_INET
        try:
            address = service.host, service.port
            bound = socket.create_server(address, family=family, backlog=_QUEUE)
        except OSError as error:
            raise ConfigError(
                f"cannot serve at {service.host}:{service.port}: {error.strerror}; give another"
                " --port or --host"
            ) from error
        self._socket = BoundedListener(bound)
        scheme = "http" if service.certificate is None else "https"
        host = f"[{service.host}]" if family == socket.AF_INET6 else service.host
        self.url = f"{scheme}://{host}:{self._socket.getsockname()[1]}"
        live_map = LiveMap(session)
        sentences = Dialogue(session, live_map, service.speech)
        config = uvicorn.Config(
            self._socket.watching(
                Guard(build_app(session, Pictures(session), live_map, sentences), self.token)
            ),
            loop="asyncio",  # uvloop would not call the listener's `accept`
            backlog=_ACCEPTED_AT_ONCE,
            callback_notify=self._socket.close_silent,
            timeout_notify=_SWEEP_PERIOD,
            log_level="warning",
            proxy_headers=False,
            ws_max_size=_MAX_MESSAGE,
            ws_per_message_deflate=False,  # pictures are compressed already
            ws_ping_interval=_PING_PERIOD,
            ws_ping_timeout=_PING_PERIOD,
            timeout_graceful_shutdown=1,
            ssl_certfile=service.certificate,
            ssl_keyfile=service.key,
        )
        with ExitStack() as cleanup:
            cleanup.callback(self._socket.close)
            try:
                config.load()
            except (OSError, ValueError) as error:
                raise ConfigError(
                    f"the certificate {service.certificate} cannot be used ({error}); give it and"
                    " its key as PEM"
                ) from error
            if self.token is not None and self.token_is_new:
                store_token(self.token)  # now it will be shown
            cleanup.pop_all()
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(
            target=self._server.run, args=([self._socket],), daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Close all connections and the port; twice is fine."""
        self._server.should_exit = True
        self._thread.join(timeout=_CLOSE_TIMEOUT)
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()
