"""Recordings of speech as samples; a process of its own decodes them."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vizbot.core.errors import ConfigError
from vizbot.core.program.interpreter import interpreter_command
from vizbot.operator.voice.sound_container import container_of
from vizbot.operator.voice.sound_decoder import REFUSED, UNREADABLE

Sound = NDArray[np.float32]
"""(N,) samples of one channel at `sound_decoder.RATE`, -1 to 1."""

_LONGEST = 600.0
"""Length of sound that is read of a file [s]."""
_MOST_BYTES = 100_000_000
_TIMEOUT = 5.0
"""The process that decodes is killed after this time [s]; it takes a fifth of a second."""


class SoundError(ConfigError):
    """A recording that is not read."""


def read_sound(source: Path | bytes, longest: float = _LONGEST) -> Sound:
    """Read a recording: WAV (PCM), WebM (Opus), Ogg (Opus, Vorbis) or MP4 (AAC, Opus).

    It is decoded up to `longest` [s].

    Raises:
        SoundError: it is of another kind, cut short, damaged or too large, takes too long, or holds
            less than 4000 samples a second.
    """
    named = str(source) if isinstance(source, Path) else "what was sent"
    content = _content(source) if isinstance(source, Path) else source
    container = container_of(content)
    if container is None:
        raise SoundError(f"{named} holds no sound in WAV, WebM, Ogg or MP4; record one of these")
    command = interpreter_command(
        "vizbot.operator.voice.sound_decoder", container.value, str(longest)
    )
    try:
        done = subprocess.run(
            command,
            input=content,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=_TIMEOUT,
            check=False,
            start_new_session=True,  # signals of the terminal are for the process that listens
        )
    except subprocess.TimeoutExpired:
        raise SoundError(
            f"{named} could not be decoded within {_TIMEOUT:g} s; record it again"
        ) from None
    if done.returncode != 0:
        reason = done.stdout.decode() if done.returncode == REFUSED else UNREADABLE
        raise SoundError(f"{named} {reason}")
    return np.frombuffer(done.stdout, "<i2").astype(np.float32) / np.float32(32768)


def _content(path: Path) -> bytes:
    """The content of a file that is not too large.

    Raises:
        SoundError: it is, or cannot be read.
    """
    try:
        if not path.is_file():
            raise SoundError(f"{path}: no such file; give a recording, for example a .wav")
        size = path.stat().st_size
        if size > _MOST_BYTES:
            raise SoundError(f"{path}: {size / 1e6:.0f} MB are too many; give a shorter recording")
        return path.read_bytes()
    except OSError as error:
        raise SoundError(f"{path}: {error.strerror}; check the path and its rights") from error
