"""Clients of this machine, from any of its addresses, that may send what they like."""

import socket
from contextlib import closing


def open_client(port, host="127.0.0.1"):
    """A connection to a port of this machine, from one of its addresses."""
    return socket.create_connection(("127.0.0.1", port), timeout=5.0, source_address=(host, 0))


def client_of(server, opened):
    """A connection to a server, closed with all that is `opened`."""
    return opened.enter_context(closing(open_client(int(server.url.rsplit(":", 1)[1]))))


def is_closed(client):
    """Whether the other end has closed a connection."""
    client.setblocking(False)
    try:
        return client.recv(1) == b""
    except BlockingIOError:
        return False
    except ConnectionResetError:
        return True
