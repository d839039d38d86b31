"""The microphone, through PortAudio."""

from __future__ import annotations

import queue
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from vizbot.core.closeable import Closeable
from vizbot.core.errors import ConfigError, DeviceError, DeviceTimeoutError
from vizbot.operator.voice.sound import Sound
from vizbot.operator.voice.sound_decoder import RATE

if TYPE_CHECKING:
    from sounddevice import InputStream

BLOCK = 0.1
"""Length of one block of sound [s]."""
_KEPT = 60.0
"""Length of sound that waits to be read [s]; older sound is dropped."""


class Microphone(Closeable):
    """The default microphone; recording once constructed, until `close()`."""

    def __init__(self) -> None:
        """Start recording.

        Raises:
            ConfigError: `sounddevice` is not installed.
            DeviceError: there is no PortAudio or no microphone, or it cannot be opened.
        """
        try:
            import sounddevice
        except ImportError as error:
            raise ConfigError(
                "the microphone needs sounddevice, not installed: pip install sounddevice"
            ) from error
        except OSError as error:  # what sounddevice raises without the library
            raise DeviceError(
                f"no microphone: {error}; sudo apt-get install libportaudio2"
            ) from error
        self._blocks: queue.SimpleQueue[Sound] = queue.SimpleQueue()
        try:
            self._stream: InputStream = sounddevice.InputStream(
                samplerate=RATE,
                channels=1,
                dtype="float32",
                blocksize=int(BLOCK * RATE),
                callback=self._take,
            )
            self._stream.start()
        except (sounddevice.PortAudioError, ValueError) as error:
            raise DeviceError(
                f"no microphone that gives {RATE} samples a second: {error}; plug one in, and see"
                " that `arecord -l` lists it"
            ) from error

    def read(self, timeout: float = 1.0) -> Sound:
        """The next samples, `BLOCK` long, oldest first.

        Raises:
            DeviceTimeoutError: none came in time.
        """
        try:
            return self._blocks.get(timeout=timeout)
        except queue.Empty:
            raise DeviceTimeoutError(
                f"the microphone gave nothing for {timeout} s; check its plug"
            ) from None

    def drain(self) -> Sound:
        """The sound that was not read yet, a minute at most; it may be empty."""
        blocks = [np.zeros(0, np.float32)]
        while not self._blocks.empty():
            blocks.append(self._blocks.get())
        return np.concatenate(blocks)

    def close(self) -> None:
        """Stop recording; twice is fine."""
        self._stream.close()

    def _take(self, samples: Sound, frames: int, time: object, status: object) -> None:
        """Keep a copy, since PortAudio uses its buffer again; drop what nobody reads."""
        if self._blocks.qsize() >= _KEPT / BLOCK:
            with suppress(queue.Empty):
                self._blocks.get_nowait()
        self._blocks.put(samples[:, 0].copy())
