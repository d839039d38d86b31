"""What people say to a running robot, from their words to the answer."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from vizbot.core.errors import VizbotError
from vizbot.core.types import Feedback
from vizbot.operator.language.command import Command, No, Stop, Yes
from vizbot.operator.language.dispatcher import Dispatcher, Reply
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.operator.language.understanding import Understanding, read_typed
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession

_MOST_WAITING = 2
"""Sentences that wait while another one is read."""
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
    """Too many sentences wait to be read, or recordings to be listened to."""


class Dialogue:
    """Answers the people around one running robot; safe to use from several threads."""

    def __init__(
        self,
        session: OperatorSession,
        live_map: LiveMap,
        language: Language = ENGLISH,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """Make the grammar now, so that no stop waits for it."""
        self._session = session
        self._language = language
        self._grammar = language.grammar
        self._dispatcher = Dispatcher(session, live_map, language)
        self._now = now
        self._doubts: dict[str, _Doubt] = {}
        self._sentences = threading.BoundedSemaphore(1 + _MOST_WAITING)
        self._reading = threading.Lock()

    def typed(self, text: str, who: str, *, at_once: bool = False) -> Reply:
        """Do what a line of text asks for; a thing alone is a goal.

        A stop of a few words is obeyed before the others that wait are read.

        With `at_once` what is running gives way, even where the line does not say so.

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
        return self.answer(command, understood, who, at_once=at_once or urgent, stops=stops)

    def answer(
        self,
        command: Command | None,
        understood: Understanding | None,
        who: str,
        *,
        at_once: bool,
        stops: int,
    ) -> Reply:
        """Do what is understood, or ask back.

        `understood` is what is done about `command`, None where it is none; a yes or a no to what
        `who` was asked settles that. With `at_once` what is running gives way; `stops` was the
        session's when it was said.

        Raises:
            VizbotError: as for `typed`.
        """
        doubt = self._doubts.pop(who, None)
        if isinstance(command, Yes | No) and doubt is not None and self._now() <= doubt.until:
            if isinstance(command, Yes) and doubt.meant is not None:
                return self.typed(doubt.meant, who, at_once=doubt.at_once)
            return Reply((self._language.say("no_then"),))
        if understood is None:
            return Reply((self._language.say("not_understood"),))
        if understood.question is None:
            reply = self._dispatcher.obey(understood.command, who, at_once=at_once, stops=stops)
            return replace(reply, said=(*reply.said, *understood.notes))
        self._session.robot.show(Feedback.DOUBT)
        self._session.log.write("doubt", understood.question)
        meant, now = understood.meant, self._now()
        for other, doubt in list(self._doubts.items()):  # whoever asks may give any name
            if doubt.until < now:
                self._doubts.pop(other, None)
        self._doubts[who] = _Doubt(meant, at_once, now + _DOUBT_HOLDS)
        if meant is not None and at_once:
            meant = self._grammar.urgent(meant)
        return Reply((), understood.question, meant)

    def _read(self, text: str) -> tuple[Command | None, Understanding | None, bool]:
        """What a line says, as `read_typed` has it.

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
