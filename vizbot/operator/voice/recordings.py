"""What people say to a running robot in recordings, from the sound to the answer."""

from __future__ import annotations

import threading
from dataclasses import replace

from vizbot.core.errors import DeviceTimeoutError
from vizbot.operator.client.endpoint import SPEECH
from vizbot.operator.language.dialogue import Dialogue, QueueFullError
from vizbot.operator.language.dispatcher import Reply
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.operator.language.understanding import Understanding, understand
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.vocabulary import HOUSEHOLD, VocabularyUpdater
from vizbot.operator.voice.intent import Utterance, confirmed
from vizbot.operator.voice.recogniser import Recogniser
from vizbot.operator.voice.sound import read_sound

_PATIENCE = 10.0
"""A recording waits this long for the recogniser while it is busy with another one [s]."""
_MOST_WAITING = 2
"""Recordings that wait while another one is listened to."""
_LONGEST = 30.0
"""The recogniser ignores what a recording says after this time [s]."""


class Recordings:
    """Listens for one running robot; safe to use from several threads."""

    def __init__(
        self,
        session: OperatorSession,
        live_map: LiveMap,
        dialogue: Dialogue,
        model: str = SPEECH,
        language: Language = ENGLISH,
    ) -> None:
        """Create it; the speech model is loaded when it is used."""
        self._session = session
        self._live_map = live_map
        self._dialogue = dialogue
        self._model = model
        self._language = language
        self._queue = threading.BoundedSemaphore(1 + _MOST_WAITING)
        self._listening = threading.Lock()
        self._recogniser: Recogniser | None = None

    def spoken(self, sound: bytes, who: str) -> Reply:
        """Do what somebody says.

        Raises:
            QueueFullError: two recordings wait already.
            SoundError: the sound cannot be read.
            VizbotError: there is no speech model, or as for `Dialogue.typed`.
        """
        stops = self._session.stops
        if not self._queue.acquire(blocking=False):
            raise QueueFullError(
                f"{_MOST_WAITING} recordings wait already; say it again in a moment, or type it"
            )
        try:
            utterance = self._heard(sound)
        finally:
            self._queue.release()
        reply = self._dialogue.answer(
            utterance.command,
            self._understood(utterance),
            who,
            at_once=utterance.at_once,
            stops=stops,
        )
        return replace(reply, heard=utterance.text)

    def _heard(self, sound: bytes) -> Utterance:
        """What is said in a recording, once it is its turn."""
        if not self._listening.acquire(timeout=_PATIENCE):
            raise DeviceTimeoutError("the robot listens to somebody else; say it again")
        try:
            samples = read_sound(sound, _LONGEST)
            if self._recogniser is None:
                self._recogniser = Recogniser(HOUSEHOLD, self._model, language=self._language)
            updater = VocabularyUpdater(self._live_map.vocabulary, self._recogniser.learn)
            # For the next sentence: a stop must not wait for a robot that is busy.
            threading.Thread(target=updater.ask, daemon=True).start()
            return self._recogniser.hear(samples)
        finally:
            self._listening.release()

    def _understood(self, utterance: Utterance) -> Understanding | None:
        if utterance.command is None:
            return None
        if utterance.question is None:
            return understand(utterance.command, self._language)
        meant = confirmed(utterance).command
        sentence = None if meant is None else self._language.grammar.text(meant)
        return Understanding(utterance.command, question=utterance.question, meant=sentence)
