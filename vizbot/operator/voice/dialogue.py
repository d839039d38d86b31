"""What a person types or says to a running robot, from the words or the sound to the answer."""

from __future__ import annotations

import threading
from dataclasses import replace

from vizbot.core.errors import DeviceTimeoutError, VizbotError
from vizbot.core.types import Feedback
from vizbot.operator.client.endpoint import SPEECH
from vizbot.operator.language.command_grammar import command_text, is_urgent, parse_typed
from vizbot.operator.language.dispatcher import Dispatcher, Reply
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
_NOT_UNDERSTOOD = Reply(("not understood; say for example: go to the kitchen",))


class QueueFullError(VizbotError):
    """Too many recordings wait to be listened to."""


class Dialogue:
    """Answers the people around one running robot; safe to use from several threads."""

    def __init__(self, session: OperatorSession, live_map: LiveMap, model: str = SPEECH) -> None:
        """The speech model is loaded when somebody first speaks.

        Args:
            session: Of the robot.
            live_map: Of the robot.
            model: Whisper's size, or a folder of one.
        """
        self._session = session
        self._live_map = live_map
        self._dispatcher = Dispatcher(session, live_map)
        self._model = model
        self._queue = threading.BoundedSemaphore(1 + _MOST_WAITING)
        self._listening = threading.Lock()
        self._recogniser: Recogniser | None = None

    def typed(self, text: str, who: str, *, at_once: bool = False) -> Reply:
        """Do what a line of text asks for; a thing alone is a goal.

        Args:
            text: One line, not empty.
            who: Typed it.
            at_once: What is running gives way, even where the text does not say so.

        Raises:
            VizbotError: too much is asked for, or the robot is too busy to answer.
        """
        stops = self._session.stops
        command = parse_typed(text)
        if command is None:
            return _NOT_UNDERSTOOD
        at_once = at_once or is_urgent(text)
        return self._dispatcher.obey(command, who, at_once=at_once, stops=stops)

    def spoken(self, sound: bytes, who: str) -> Reply:
        """Do what somebody says.

        Args:
            sound: A recording, as `read_sound` takes it.
            who: Speaks.

        Raises:
            QueueFullError: two recordings wait already.
            SoundError: the sound cannot be read.
            VizbotError: there is no speech model, or as for `typed`.
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
        return replace(self._answer(utterance, who, stops), heard=utterance.text)

    def _heard(self, sound: bytes) -> Utterance:
        """What is said in a recording, once it is its turn."""
        if not self._listening.acquire(timeout=_PATIENCE):
            raise DeviceTimeoutError("the robot listens to somebody else; say it again")
        try:
            samples = read_sound(sound, _LONGEST)
            if self._recogniser is None:
                self._recogniser = Recogniser(HOUSEHOLD, self._model)
            updater = VocabularyUpdater(self._live_map.vocabulary, self._recogniser.learn)
            # For the next sentence: a stop must not wait for a robot that is busy.
            threading.Thread(target=updater.ask, daemon=True).start()
            return self._recogniser.hear(samples)
        finally:
            self._listening.release()

    def _answer(self, utterance: Utterance, who: str, stops: int) -> Reply:
        if utterance.question is not None:
            self._session.show(Feedback.DOUBT)
            self._session.write("doubt", utterance.question)
            meant = confirmed(utterance).command
            sentence = None if meant is None else command_text(meant, utterance.at_once)
            return Reply((), utterance.question, sentence)
        if utterance.command is None:
            return _NOT_UNDERSTOOD
        at_once = utterance.at_once
        return self._dispatcher.obey(utterance.command, who, at_once=at_once, stops=stops)
