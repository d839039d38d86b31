"""Has a running robot obey commands, whichever way they came in."""

from __future__ import annotations

from dataclasses import dataclass

from vizbot.core.observer import Outcome
from vizbot.operator.language.command import ONE_OF_ALL, All, Command, Stop, WhereIs, task_requests
from vizbot.operator.language.command_grammar import command_text
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession


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
        numbers: Of the tasks that it asked for, in order.
    """

    said: tuple[str, ...]
    question: str | None = None
    meant: str | None = None
    place: tuple[float, float] | None = None
    heard: str | None = None
    numbers: tuple[int, ...] = ()


class Dispatcher:
    """Obeys one running robot's operators; safe to use from several threads."""

    def __init__(self, session: OperatorSession, live_map: LiveMap) -> None:
        self._session = session
        self._live_map = live_map

    def obey(
        self, command: Command, who: str, *, at_once: bool = False, stops: int | None = None
    ) -> Reply:
        """Do what a command asks for.

        Args:
            command: From any way in.
            who: Gave it.
            at_once: What is running gives way.
            stops: What the session's `stops` was when the command was given, where that was a
                while ago.

        Raises:
            VizbotError: too much is asked for, the robot was stopped since, or it is too busy.
        """
        match command:
            case Stop():
                self._session.stop(who)
                return Reply(("stopped",))
            case WhereIs(goal):
                return self._where(goal)
        tasks = self._session.ask(task_requests(command), at_once=at_once, stops=stops)
        numbers = tuple(task.number for task in tasks)
        if isinstance(command, All):
            return Reply((f"asked for: {command.goal}", ONE_OF_ALL), numbers=numbers)
        return Reply((f"asked for: {command_text(command, at_once)}",), numbers=numbers)

    def _where(self, goal: str) -> Reply:
        answer = self._live_map.places(goal)
        located = answer.outcome is Outcome.LOCATED
        place = answer.places[0].position[:2] if located else None
        return Reply((self._live_map.summary(answer),), place=place)
