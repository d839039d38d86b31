"""Listening all the time: sound is cut into utterances, and "stop" told before one has ended."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from vizbot.operator.language.command import Stop
from vizbot.operator.language.command_grammar import parse_command
from vizbot.operator.voice.intent import Utterance
from vizbot.operator.voice.recogniser import RATE, Sound

_EVERY = 0.5
"""So much new sound is looked at together [s]."""
_SILENCE = 0.6
"""A pause this long ends an utterance [s]."""
_LONGEST = 15.0
"""Where nobody pauses, it is cut [s]."""
_RECENT = 2.5
"""In so much of what was said last "stop" is looked for [s]."""
_KEPT = 0.5
"""Of silence this much is kept, so that no beginning is cut off [s]."""


class SpeechRecogniser(Protocol):
    """What `vizbot.operator.voice.recogniser.Recogniser` does."""

    def hear(self, sound: Sound, wake: str | None = None) -> Utterance:
        """What was said in an utterance, and the command in it."""
        ...

    def glance(self, sound: Sound) -> str:
        """What is probably being said."""
        ...

    def speech(self, sound: Sound) -> list[tuple[int, int]]:
        """First sample of each stretch of speech, and the one after its last."""
        ...


class Listener:
    """Takes sound as it comes and tells what is heard, one utterance at a time.

    "Stop" is told while somebody still speaks, and needs no wake phrase.
    """

    def __init__(self, ear: SpeechRecogniser, wake: str | None) -> None:
        """Begin with silence.

        Args:
            ear: Who understands.
            wake: What every command must begin with; None: nothing.
        """
        self._ear = ear
        self._wake = wake
        self._sound: Sound = np.zeros(0, np.float32)
        self._fresh = 0
        self._stopped = False

    def take(self, sound: Sound) -> Utterance | None:
        """Go on listening.

        Args:
            sound: (N,) what came since the last call.

        Returns:
            A stop as soon as it is said, an utterance when it has ended; None: nothing yet.
        """
        self._sound = np.concatenate([self._sound, sound])
        self._fresh += len(sound)
        if self._fresh < _EVERY * RATE:
            return None
        self._fresh = 0
        spans = self._ear.speech(self._sound)
        if not spans:
            self._sound = self._sound[-int(_KEPT * RATE) :]
            return None
        silence = len(self._sound) - spans[-1][1]
        if silence >= _SILENCE * RATE or len(self._sound) >= _LONGEST * RATE:
            return self._end()
        if self._stopped:
            return None
        text = self._ear.glance(self._sound[-int(_RECENT * RATE) :])
        if not isinstance(parse_command(text), Stop):
            return None
        self._stopped = True
        return Utterance(text, Stop())

    def _end(self) -> Utterance | None:
        """The utterance; None if it is a stop that was told before."""
        utterance, stopped = self._sound, self._stopped
        self._sound, self._stopped = utterance[:0], False
        heard = self._ear.hear(utterance, self._wake)
        return None if stopped and not heard.obeys else heard
