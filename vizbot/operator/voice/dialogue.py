"""What a person types or says to a running robot, from the words or the sound to the answer."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from vizbot.core.errors import DeviceTimeoutError, VizbotError
from vizbot.core.types import Feedback
from vizbot.operator.client.endpoint import SPEECH
from vizbot.operator.language.command import Command, No, Stop, Yes
from vizbot.operator.language.dispatcher import Dispatcher, Reply
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.operator.language.understanding import Understanding, read_typed, understand
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.vocabulary import HOUSEHOLD, VocabularyUpdater
from vizbot.operator.voice.intent import Utterance, confirmed
from vizbot.operator.voice.recogniser import Recogniser
from vizbot.operator.voice.sound import read_sound

_PATIENCE = 10.0
"""A recording waits this long for the recogniser while it is busy with another one [s]."""
_MOST_WAITING = 2
"""Recordings that wait while another one is listened to, and sentences while one is read."""
_LONGEST = 30.0
"""The recogniser ignores what a recording says after this time [s]."""
_DOUBT_HOLDS = 30.0
"""Longest time between a question and a yes to it [s]."""


@dataclass(frozen=True, slots=True)
class _Doubt:
    """A question that waits for an answer.

    Attributes:
        meant: The sentence for yes; None where nothing can be done.
        at_once: Whether what is running gives way to that.
        until: Time at which nobody waits any more [s].
    """

    meant: str | None
    at_once: bool
    until: float


class QueueFullError(VizbotError):
    """Too many recordings wait to be listened to, or sentences to be read."""


class Dialogue:
    """Answers the people around one running robot; safe to use from several threads."""

    def __init__(
        self,
        session: OperatorSession,
        live_map: LiveMap,
        model: str = SPEECH,
        language: Language = ENGLISH,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """The grammar is made now, so that no stop waits for it; the speech model when it is used.

        Args:
            session: Of the robot.
            live_map: Of the robot.
            model: Whisper's size, or a folder of one.
            language: That people and robot speak.
            now: Time of the wall clock [s].
        """
        self._session = session
        self._live_map = live_map
        self._language = language
        self._grammar = language.grammar
        self._dispatcher = Dispatcher(session, live_map, language)
        self._now = now
        self._doubts: dict[str, _Doubt] = {}
        self._model = model
        self._queue = threading.BoundedSemaphore(1 + _MOST_WAITING)
        self._listening = threading.Lock()
        self._sentences = threading.BoundedSemaphore(1 + _MOST_WAITING)
        self._reading = threading.Lock()
        self._recogniser: Recogniser | None = None

    def typed(self, text: str, who: str, *, at_once: bool = False) -> Reply:
        """Do what a line of text asks for; a thing alone is a goal.

        A stop of a few words is obeyed before the others that wait are read.

        Args:
            text: One line, not empty.
            who: Typed it.
            at_once: What is running gives way, even where the text does not say so.

        Raises:
            QueueFullError: two sentences wait already.
            SentenceTooLongError: it is too long to be read.
            VizbotError: too much is asked for, or the robot is too busy to answer.
        """
        stops = self._session.stops
        if self._grammar.is_stop(text):
            self._doubts.pop(who, None)
            return self._dispatcher.obey(Stop(), who)
        command, understood, urgent = self._read(text)
        doubt = self._doubts.pop(who, None)
        if isinstance(command, Yes | No) and doubt is not None and self._now() <= doubt.until:
            if isinstance(command, Yes) and doubt.meant is not None:
                return self.typed(doubt.meant, who, at_once=doubt.at_once)
            return Reply((self._language.say("no_then"),))
        if understood is None:
            return Reply((self._language.say("not_understood"),))
        return self._done(understood, who, at_once or urgent, stops)

    def _read(self, text: str) -> tuple[Command | None, Understanding | None, bool]:
        """The command in a line, what it is understood as, and whether all else gives way to it.

        One line is read at a time, and two may wait for their turn.
        """
        if not self._sentences.acquire(blocking=False):
            raise QueueFullError(
                f"{_MOST_WAITING} sentences wait already; say it again in a moment"
            )
        try:
            with self._reading:
                return read_typed(text, self._language)
        finally:
            self._sentences.release()

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
                self._recogniser = Recogniser(HOUSEHOLD, self._model, language=self._language)
            updater = VocabularyUpdater(self._live_map.vocabulary, self._recogniser.learn)
            # For the next sentence: a stop must not wait for a robot that is busy.
            threading.Thread(target=updater.ask, daemon=True).start()
            return self._recogniser.hear(samples)
        finally:
            self._listening.release()

    def _answer(self, utterance: Utterance, who: str, stops: int) -> Reply:
        if utterance.command is None:
            self._doubts.pop(who, None)
            return Reply((self._language.say("not_understood"),))
        if isinstance(utterance.command, Yes | No):
            return self.typed(self._grammar.text(utterance.command), who)
        self._doubts.pop(who, None)
        if utterance.question is not None:
            meant = confirmed(utterance).command
            sentence = None if meant is None else self._grammar.text(meant)
            understood = Understanding(
                utterance.command, question=utterance.question, meant=sentence
            )
        else:
            understood = understand(utterance.command, self._language)
        return self._done(understood, who, utterance.at_once, stops)

    def _done(self, understood: Understanding, who: str, at_once: bool, stops: int) -> Reply:
        """Do what is understood, or ask back."""
        if understood.question is None:
            reply = self._dispatcher.obey(understood.command, who, at_once=at_once, stops=stops)
            return replace(reply, said=(*reply.said, *understood.notes))
        self._session.show(Feedback.DOUBT)
        self._session.log.write("doubt", understood.question)
        meant, now = understood.meant, self._now()
        for other, doubt in list(self._doubts.items()):  # whoever asks may give any name
            if doubt.until < now:
                self._doubts.pop(other, None)
        self._doubts[who] = _Doubt(meant, at_once, now + _DOUBT_HOLDS)
        if meant is not None and at_once:
            meant = self._grammar.urgent(meant)
        return Reply((), understood.question, meant)
