"""Listening all the time: cuts sound into utterances, and finds "stop" before one has ended."""

from __future__ import annotations

import numpy as np

from vizbot.operator.language.command import Stop
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.operator.voice.intent import Utterance
from vizbot.operator.voice.recogniser import Recogniser
from vizbot.operator.voice.sound import Sound
from vizbot.operator.voice.sound_decoder import RATE

_EVERY = 0.5
"""Length of new sound that is examined together [s]."""
_SILENCE = 0.6
"""A pause this long ends an utterance [s]."""
_LONGEST = 15.0
"""Longest utterance; it is cut where nobody pauses [s]."""
_RECENT = 2.5
"""Length of the newest sound in which "stop" is looked for [s]."""
_KEPT = 0.5
"""Length of silence that is kept, so that no beginning is cut off [s]."""


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
            self._sound = self._sound[-int(_KEPT * RATE) :]
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
