"""How people reach a running robot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vizbot.operator.client.stop import PORT

SPEECH = "tiny.en"
LANGUAGE = "en"


@dataclass(frozen=True, slots=True)
class Service:
    """Where a run is served, and which speech model it uses.

    Attributes:
        host: Name or address to listen on; by default only this machine can reach it.
        port: TCP port; 0 for any free one.
        certificate: PEM file for https; None for http.
        key: Its private key.
        speech: Whisper's size, or a folder with a model of faster-whisper.
        language: Code of the language that people and robot speak.
    """

    host: str = "127.0.0.1"
    port: int = PORT
    certificate: Path | None = None
    key: Path | None = None
    speech: str = SPEECH
    language: str = LANGUAGE
