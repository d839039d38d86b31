"""The server of the API, beside the robot's loop: the acceptor, and two threads that answer.

Requests to stop have a thread, a loop and a limit of open connections of their own, which no other
request can fill. Over TLS they cannot be recognised before they are answered, and go with the rest.
"""

from __future__ import annotations

import logging
import socket
import subprocess
import threading
from collections.abc import Sequence
from contextlib import ExitStack, closing

import uvicorn

from vizbot.core.closeable import Closeable
from vizbot.core.program.interpreter import interpreter_command
from vizbot.operator.api.app import build_app, build_stop_app
from vizbot.operator.api.auth import App, Guard, own_token, store_token
from vizbot.operator.api.connections import acceptor
from vizbot.operator.api.connections.bounded_protocols import (
    LONGEST_LINE,
    BoundedHttp,
    BoundedWebSocket,
)
from vizbot.operator.api.connections.connection_limits import BoundedListener
from vizbot.operator.api.connections.head import is_loopback
from vizbot.operator.api.image_stream import Pictures
from vizbot.operator.api.listener import open_listener, reached_host, require_certificate
from vizbot.operator.api.proof import Credentials
from vizbot.operator.client.endpoint import Service
from vizbot.operator.language.dialogue import Dialogue
from vizbot.operator.language.language import load_language
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.voice.recordings import Recordings

logger = logging.getLogger(__name__)

_MAX_MESSAGE = 4096
"""Size of a message that a client sends over a WebSocket [bytes]."""
_PING_PERIOD = 5.0
"""A WebSocket whose client does not answer a ping within this time is closed [s]."""
_CLOSE_TIMEOUT = 10.0
"""[s]"""
_ACCEPTED_AT_ONCE = 8
"""Connections that are taken in one turn of a loop."""
_SWEEP_PERIOD = 1
"""Between two searches for silent connections [s]."""
_RECEIVE_BUFFER = 16 * 1024
"""What the kernel keeps of what a client sends, so that no turn of a loop takes long [bytes]."""
_RESTART_PAUSE = 0.1
"""[s]"""


class Server(Closeable):
    """Serves the API until it is closed.

    Attributes:
        url: The address at which it listens.
        console_url: What a browser opens to see the console, with the token: where it listens at
            all addresses, one that other computers of the network reach.
        token: The token that clients must give; None where only this machine reaches the robot.
    """

    def __init__(self, session: OperatorSession, service: Service) -> None:
        """Open the port and serve.

        Raises:
            ConfigError: the port, the certificate or the token cannot be used.
        """
        require_certificate(service)
        self.token: str | None = None
        is_new = False
        if not is_loopback(service.host):
            self.token, is_new = own_token()
        with ExitStack() as cleanup:
            listener = cleanup.enter_context(open_listener(service))
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER)
            port = listener.getsockname()[1]
            self.url = _url(service, service.host, port)
            self.console_url = _url(service, reached_host(service.host), port)
            if self.token is not None:
                self.console_url += f"/?token={self.token}"
            live_map = LiveMap(session)
            cleanup.callback(live_map.close)
            language = load_language(service.language)
            dialogue = Dialogue(session, live_map, language)
            recordings = Recordings(session, live_map, dialogue, service.speech, language)
            credentials = Credentials(self.token)
            app = build_app(session, Pictures(session), live_map, dialogue, recordings, credentials)
            answering = [
                cleanup.enter_context(closing(_Answering(Guard(each, credentials), service)))
                for each in (build_stop_app(session), app)
            ]
            if self.token is not None and is_new:
                store_token(self.token)  # now it will be shown
            for each in answering:
                each.start()
                cleanup.callback(each.end)  # of all before it waits for any
            channels = [each.channel for each in answering]
            flags = ["encrypted"] if service.certificate is not None else []
            flags += ["here-alone"] if self.token is None else []
            cleanup.enter_context(closing(_Acceptor([listener, *channels], flags)))
            self._cleanup = cleanup.pop_all()

    def close(self) -> None:
        """Close all connections and the port; twice is fine."""
        self._cleanup.close()


class _Answering:
    """A thread that answers the requests on connections from a channel, once it is started.

    Attributes:
        channel: The end of the channel that takes connections.
    """

    def __init__(self, app: App, service: Service) -> None:
        ours, self.channel = socket.socketpair()
        self._listener = BoundedListener(ours)
        config = uvicorn.Config(
            self._listener.watching(app),
            loop="asyncio",  # uvloop would not call the listener's `accept`
            headers=[("Connection", "close")],  # so that each request goes through the acceptor
            backlog=_ACCEPTED_AT_ONCE,
            callback_notify=self._listener.close_silent,
            timeout_notify=_SWEEP_PERIOD,
            log_level="error",  # a stranger writes the warnings: requests that are none
            proxy_headers=False,
            http=BoundedHttp,
            h11_max_incomplete_event_size=LONGEST_LINE,
            ws=BoundedWebSocket,
            ws_max_size=_MAX_MESSAGE,
            ws_per_message_deflate=False,  # pictures are compressed already
            ws_ping_interval=_PING_PERIOD,
            ws_ping_timeout=_PING_PERIOD,
            timeout_graceful_shutdown=1,
            ssl_certfile=service.certificate,
            ssl_keyfile=service.key,
        )
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(
            target=self._server.run, args=([self._listener],), daemon=True
        )

    def start(self) -> None:
        """Start to answer."""
        self._thread.start()

    def end(self) -> None:
        """Begin to close all connections."""
        self._server.should_exit = True

    def close(self) -> None:
        """Close all connections."""
        self.end()
        if self._thread.is_alive():
            self._thread.join(timeout=_CLOSE_TIMEOUT)
        self._listener.close()
        self.channel.close()


class _Acceptor:
    """The acceptor's process, which is started again where it has ended."""

    def __init__(self, sockets: Sequence[socket.socket], flags: Sequence[str]) -> None:
        self._inherited = [each.fileno() for each in sockets]
        self._flags = flags
        self._closed = threading.Event()
        self._process = self._start()
        self._watcher = threading.Thread(target=self._watch, daemon=True)
        self._watcher.start()

    def _start(self) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            interpreter_command(
                acceptor.__name__, *map(str, self._inherited), *self._flags, packages=False
            ),
            pass_fds=self._inherited,
            start_new_session=True,  # signals of the terminal are for the process that serves
        )

    def _watch(self) -> None:
        while self._process.wait() is not None and not self._closed.wait(_RESTART_PAUSE):
            logger.error("the acceptor of connections has ended; it is started again")
            self._process = self._start()
            if self._closed.is_set():
                self._process.terminate()

    def close(self) -> None:
        """End it."""
        self._closed.set()
        self._process.terminate()
        self._watcher.join(timeout=_CLOSE_TIMEOUT)


def _url(service: Service, host: str, port: int) -> str:
    scheme = "http" if service.certificate is None else "https"
    host = f"[{host}]" if ":" in host else host
    return f"{scheme}://{host}:{port}"
