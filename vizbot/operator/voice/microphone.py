"""The microphone, through PortAudio, and where utterances end in its sound."""

from __future__ import annotations

import queue
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from vizbot.core.closeable import Closeable
from vizbot.core.errors import ConfigError, DeviceError, DeviceTimeoutError
from vizbot.operator.language.command import Stop
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.operator.voice.intent import Utterance
from vizbot.operator.voice.recogniser import Recogniser
from vizbot.operator.voice.sound import Sound
from vizbot.operator.voice.sound_decoder import RATE

if TYPE_CHECKING:
    from sounddevice import InputStream

BLOCK = 0.1
"""Length of one block of sound [s]."""
_KEPT = 60.0
"""Length of sound that waits to be read [s]; older sound is dropped."""
_EVERY = 0.5
"""Length of new sound that is examined together [s]."""
_SILENCE = 0.6
"""A pause this long ends an utterance [s]."""
_LONGEST = 15.0
"""Longest utterance; it is cut where nobody pauses [s]."""
_RECENT = 2.5
"""Length of the newest sound in which "stop" is looked for [s]."""
_KEPT_SILENCE = 0.5
"""Length of silence that is kept, so that no beginning is cut off [s]."""


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


class Listener:
    """Takes sound as it comes and returns one utterance at a time.

    It returns "stop" while somebody still speaks, and without a wake phrase.
    """

    def __init__(
        self, recogniser: Recogniser, wake: str | None, language: Language = ENGLISH
    ) -> None:
        """Begin with silence; every command must begin with `wake`, unless that is None."""
        self._recogniser = recogniser
        self._wake = wake
        self._grammar = language.grammar
        self._sound: Sound = np.zeros(0, np.float32)
        self._fresh = 0
        self._stopped = False

    def take(self, sound: Sound) -> Utterance | None:
        """Take sound: a stop once it is said, an utterance once it has ended, else None."""
        self._sound = np.concatenate([self._sound, sound])
        self._fresh += len(sound)
        if self._fresh < _EVERY * RATE:
            return None
        self._fresh = 0
        spans = self._recogniser.speech(self._sound)
        if not spans:
            self._sound = self._sound[-int(_KEPT_SILENCE * RATE) :]
            return None
        silence = len(self._sound) - spans[-1][1]
        if silence >= _SILENCE * RATE or len(self._sound) >= _LONGEST * RATE:
            return self._end()
        if self._stopped:
            return None
        text = self._recogniser.glance(self._sound[-int(_RECENT * RATE) :])
        if not isinstance(self._grammar.heard(text), Stop):
            return None
        self._stopped = True
        return Utterance(text, Stop())

    def _end(self) -> Utterance | None:
        """The utterance; None if it is a stop that was returned before."""
        sound, stopped = self._sound, self._stopped
        self._sound, self._stopped = sound[:0], False
        utterance = self._recogniser.hear(sound, self._wake)
        return None if stopped and not utterance.obeys else utterance
