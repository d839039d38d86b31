"""What a person says or types to a running robot is done, and answered in plain words."""

from __future__ import annotations

import io
import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace

from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.observer import Outcome
from vizbot.core.types import Feedback
from vizbot.objectnav.tasks import Task
from vizbot.operator.client.endpoint import SPEECH
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.task_queue import TaskRequest
from vizbot.operator.session.vocabulary import HOUSEHOLD, VocabularyUpdater
from vizbot.operator.voice.command_grammar import (
    All,
    ComeBack,
    Command,
    Dock,
    Explore,
    GoTo,
    Stop,
    WhereIs,
    is_urgent,
    parse_command,
)
from vizbot.operator.voice.intent import Utterance, confirmed
from vizbot.operator.voice.recogniser import Recogniser, read_sound

_NAMES = {Stop: "stop", GoTo: "go to", WhereIs: "where is", All: "go to all", ComeBack: "come back"}
_NAMES |= {Dock: "dock", Explore: "explore"}
ONE_OF_ALL = (
    "all of them it cannot visit yet: it goes to one, and of several on its map to one near by"
)
"""What is answered to `All`: a goal is gone to by the way there and by how like it a place is."""
_PATIENCE = 10.0
"""So long a recording waits until another one is understood [s]."""
_LONGEST = 30.0
"""What is said after so long is not listened to [s]."""


@dataclass(frozen=True, slots=True)
class Reply:
    """What the robot answers.

    Attributes:
        said: Lines to be shown.
        question: Asked back before anything is done; None without a doubt.
        meant: What to say for yes to that question; None without one.
        place: x, y in `map` of what was asked for [m]; None where it is not on the map, or nothing
            was asked for.
        heard: The words, where they were spoken; None where they were typed.
    """

    said: tuple[str, ...]
    question: str | None = None
    meant: str | None = None
    place: tuple[float, float] | None = None
    heard: str | None = None


_NOT_UNDERSTOOD = Reply(("not understood; say for example: go to the kitchen",))


class Dialogue:
    """Of one running robot; safe to use from several threads."""

    def __init__(self, session: OperatorSession, live_map: LiveMap, model: str = SPEECH) -> None:
        """No speech model is loaded before somebody speaks.

        Args:
            session: Of the robot.
            live_map: Likewise.
            model: Whisper's size, or a folder of one.
        """
        self._session = session
        self._live_map = live_map
        self._model = model
        self._listening = threading.Lock()
        self._recogniser: Recogniser | None = None

    def typed(self, text: str, who: str, *, at_once: bool = False) -> Reply:
        """Do what a line of text asks for; a bare thing is a goal.

        Args:
            text: One line, not empty.
            who: Typed it.
            at_once: What is running gives way, even where the text does not say so.

        Raises:
            VizbotError: too much is asked for, or the robot is too busy to answer.
        """
        stops = self._session.stops
        command = parse_command(text)
        if command is None:
            command = parse_command(text, bare=True)
            single = isinstance(command, GoTo) and len(command.goals) == 1 and not command.after
            if single and not is_urgent(text):
                command = GoTo((text,))  # in the words that were typed
        if command is None:
            return _NOT_UNDERSTOOD
        return self._obey(command, who, stops, at_once=at_once or is_urgent(text))

    def spoken(self, sound: bytes, who: str) -> Reply:
        """Do what somebody says.

        Args:
            sound: A recording in any usual format.
            who: Speaks.

        Raises:
            VizbotError: there is no speech model, the sound cannot be read, or as for `typed`.
        """
        stops = self._session.stops
        if not self._listening.acquire(timeout=_PATIENCE):
            raise DeviceTimeoutError("the robot listens to somebody else; say it again")
        try:
            said = read_sound(io.BytesIO(sound), _LONGEST)
            if self._recogniser is None:
                self._recogniser = Recogniser(HOUSEHOLD, self._model)
            words = VocabularyUpdater(self._live_map.vocabulary, self._recogniser.learn)
            # For the next sentence: a stop must not wait for a robot that is busy.
            threading.Thread(target=words.ask, daemon=True).start()
            heard = self._recogniser.hear(said)
        finally:
            self._listening.release()
        return replace(self._answer(heard, who, stops), heard=heard.text)

    def _answer(self, heard: Utterance, who: str, stops: int) -> Reply:
        if heard.question is not None:
            self._session.show(Feedback.DOUBT)
            self._session.write("doubt", heard.question)
            meant = confirmed(heard).command
            return Reply(
                (), heard.question, None if meant is None else command_text(meant, heard.at_once)
            )
        if heard.command is None:
            return _NOT_UNDERSTOOD
        return self._obey(heard.command, who, stops, at_once=heard.at_once)

    def _obey(self, command: Command, who: str, stops: int, *, at_once: bool) -> Reply:
        match command:
            case Stop():
                self._session.stop(who)
                return Reply(("stopped",))
            case WhereIs(goal):
                return self._where(goal)
            case All(goal):
                self._session.ask([goal], at_once=at_once, stops=stops)
                return Reply((f"asked for: {goal}", ONE_OF_ALL))
        self._session.ask(task_requests(command), at_once=at_once, stops=stops)
        return Reply((f"asked for: {command_text(command, at_once)}",))

    def _where(self, goal: str) -> Reply:
        answer = self._live_map.places(goal)
        located = answer.outcome is Outcome.LOCATED
        place = answer.places[0].position[:2] if located else None
        return Reply((self._live_map.summary(answer),), place=place)


def task_requests(command: GoTo | ComeBack | Dock | Explore) -> Sequence[TaskRequest]:
    """What is to be done, in order."""
    match command:
        case GoTo(goals, after):
            return [*goals, *([] if after is None else task_requests(after))]
        case ComeBack():
            return [Task.COME_BACK]
        case Explore():
            return [Task.EXPLORE]
        case Dock():
            return [Task.DOCK]


def command_text(command: Command, at_once: bool = False) -> str:
    """A command in words that say the same, for example "go to kitchen, then sofa, then dock"."""
    if at_once:
        return f"{command_text(command)}, right now"
    name = _NAMES[type(command)]
    match command:
        case GoTo(goals, after):
            steps = [*goals, *([] if after is None else [command_text(after)])]
            return f"{name} {', then '.join(steps)}"
        case WhereIs(goal) | All(goal):
            return f"{name} {goal}"
    return name
