"""Where the API is served."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

PORT = 8787


@dataclass(frozen=True, slots=True)
class Address:
    """Where to serve.

    Attributes:
        host: Name or address of the network card; that of this machine alone by default.
        port: 0 for any that is free.
        certificate: PEM file for https; None for http.
        key: Its private key.
    """

    host: str = "127.0.0.1"
    port: int = PORT
    certificate: Path | None = None
    key: Path | None = None
