"""A stranger's program that has taken the port of a robot."""

import socket
import threading
from contextlib import suppress


def http_answer(body, status=200, kind="application/json"):
    head = f"HTTP/1.1 {status} X\r\nContent-Type: {kind}\r\nContent-Length: {len(body)}\r\n\r\n"
    return head.encode() + body


class Impostor:
    """Listens on this machine, keeps every byte that it is sent, and answers as it is made to.

    Attributes:
        url: Where it listens.
        requests: All that came, a request or the start of one each, as bytes.
    """

    def __init__(self, answer, port=0):
        """Listen; `answer` makes an answer, or parts of one, of the bytes of a request."""
        self._answer = answer
        self._listener = socket.create_server(("127.0.0.1", port))
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        self.requests = []
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *exc):
        self._listener.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._listener.close()

    def _serve(self):
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            with client, suppress(OSError):
                client.settimeout(1.0)
                self.requests.append(_request(client))
                answer = self._answer(self.requests[-1])
                for part in [answer] if isinstance(answer, bytes) else answer:
                    client.sendall(part)
                client.shutdown(socket.SHUT_WR)
                while more := client.recv(65536):
                    self.requests.append(more)


def _request(client):
    """A request with its body."""
    came = b""
    while b"\r\n\r\n" not in came and (more := client.recv(65536)):
        came += more
    head, _, body = came.partition(b"\r\n\r\n")
    for line in head.lower().split(b"\r\n"):
        if line.startswith(b"content-length:"):
            while len(body) < int(line.split(b":")[1]) and (more := client.recv(65536)):
                body += more
    return head + b"\r\n\r\n" + body
