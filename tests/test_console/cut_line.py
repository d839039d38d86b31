"""A network that is cut."""

import socket
import threading


class Line:
    """A network between a browser and a robot: it carries bytes until it is cut.

    Attributes:
        url: What the browser opens in place of the robot's own.
    """

    def __init__(self, url):
        self._to = int(url.rsplit(":", 1)[1])
        self._lock = threading.Lock()
        self._cut = threading.Event()
        self._ends = []
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listening.getsockname()[1]}"
        self._accepting = threading.Thread(target=self._accept)
        self._accepting.start()

    def cut(self):
        """What is sent arrives no more; neither end is told."""
        self._cut.set()

    def restore(self):
        """New connections are carried; the old ones end."""
        with self._lock:
            ends, self._ends, self._cut = self._ends, [], threading.Event()
        for end in ends:
            end.close()

    def close(self):
        self._listening.shutdown(socket.SHUT_RDWR)
        self._accepting.join()
        self._listening.close()
        self.cut()
        self.restore()

    def _accept(self):
        while True:
            try:
                near, _ = self._listening.accept()
            except OSError:
                return
            far = socket.create_connection(("127.0.0.1", self._to))
            with self._lock:
                self._ends += [near, far]
                cut = self._cut
            for ends in ((near, far), (far, near)):
                threading.Thread(target=_carry, args=(*ends, cut), daemon=True).start()


def _carry(source, sink, cut):
    try:
        while carried := source.recv(65536):
            if not cut.is_set():
                sink.sendall(carried)
        if not cut.is_set():
            sink.shutdown(socket.SHUT_WR)
    except OSError:
        return
