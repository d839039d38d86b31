"""How people reach a running robot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

PORT = 8787
HERE = f"http://127.0.0.1:{PORT}"
"""Where the robot of this machine is found."""
SPEECH = "tiny.en"


@dataclass(frozen=True, slots=True)
class Service:
    """Where it is served, and what listens there.

    Attributes:
        host: Name or address of the network card; that of this machine alone by default.
        port: 0 for any that is free.
        certificate: PEM file for https; None for http.
        key: Its private key.
        speech: Whisper's size, or a folder with a model of faster-whisper.
    """

    host: str = "127.0.0.1"
    port: int = PORT
    certificate: Path | None = None
    key: Path | None = None
    speech: str = SPEECH
