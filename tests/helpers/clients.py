"""Clients of this machine, from any of its addresses, that may send what they like."""

import socket


def open_client(port, host="127.0.0.1"):
    """A connection to a port of this machine, from one of its addresses."""
    return socket.create_connection(("127.0.0.1", port), timeout=5.0, source_address=(host, 0))


def is_closed(client):
    """Whether the other end has closed a connection."""
    client.setblocking(False)
    try:
        return client.recv(1) == b""
    except BlockingIOError:
        return False
    except ConnectionResetError:
        return True
