"""Has a running robot obey what was heard."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import partial
from queue import SimpleQueue
from typing import Any, Protocol, Self

import typer

from vizbot.commands.remote import whoami
from vizbot.operator.voice.command_grammar import (
    EXAMPLES,
    All,
    ComeBack,
    Command,
    Dock,
    Explore,
    GoTo,
    Stop,
    WhereIs,
)
from vizbot.operator.voice.dialogue import ONE_OF_ALL, command_text
from vizbot.operator.voice.intent import Utterance

_STOP_WITHIN = 1.5
"""A stop that is not answered for so long is sent again [s] ..."""
_STOP_PAUSE = 0.5
"""... after so long [s]."""
_PATIENCE = 5.0
"""So long what was said last is waited for at the end [s]."""


class Robot(Protocol):
    """As much of `vizbot.operator.client.robot_client.RobotClient` as obeys a voice."""

    def ask(self, texts: Sequence[str], *, at_once: bool) -> object:
        """Ask for goals; `at_once`: what is running gives way."""
        ...

    def come_back(self, *, at_once: bool) -> object:
        """Ask it to go back to where the run began."""
        ...

    def explore(self, *, at_once: bool) -> object:
        """Ask for an exploration."""
        ...

    def dock(self, *, at_once: bool) -> object:
        """Ask it to go to its charger."""
        ...

    def stop(self, who: str, timeout: float = ...) -> None:
        """Have it rest now, or raise `DeviceError` after `timeout` [s] at the latest."""
        ...

    def doubt(self, question: str) -> None:
        """Have it tell what is asked back."""
        ...

    def places(self, text: str) -> dict[str, Any]:
        """Where on its map something is."""
        ...


class Orders:
    """What was said is done in order, by a thread, so that whoever listens goes on listening.

    A stop overtakes it: it is sent until the robot has heard it, and what was said before is not
    done any more. Entering it begins, leaving it ends.
    """

    def __init__(self, robot: Robot | None, pause: float = _STOP_PAUSE) -> None:
        """Nothing was said.

        Args:
            robot: That shall obey; None where what was understood is only printed.
            pause: Before a stop that was not heard is sent again [s].
        """
        self._robot = robot
        self._pause = pause
        self._waiting: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._stops = 0
        self._stopping: threading.Thread | None = None
        self._ended = threading.Event()
        self._worker = threading.Thread(target=self._work, name="orders", daemon=True)

    def give(self, heard: Utterance) -> None:
        """Do what was said; comes back at once."""
        if self._robot is None or not isinstance(heard.command, Stop):
            self._waiting.put(partial(self._obey, heard, self._stops))
            return
        self._stops += 1
        self._stopping = threading.Thread(target=self._stop, args=(self._robot,), daemon=True)
        self._stopping.start()

    def __enter__(self) -> Self:
        self._worker.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._waiting.put(self._ended.set)
        self._worker.join(_PATIENCE)
        self._ended.set()

    def _work(self) -> None:
        while not self._ended.is_set():
            order = self._waiting.get()
            if self._stopping is not None:
                self._stopping.join()  # what was said after a stop must not come before it
            order()

    def _obey(self, heard: Utterance, stops: int) -> None:
        """Do it, unless a stop was said since there were `stops` of them."""
        if stops != self._stops:
            return
        try:
            obey(heard, self._robot)
        except Exception as error:  # whatever it is, the next command may come through
            typer.echo(str(error), err=True)
        if stops != self._stops and self._robot is not None:
            self._stop(self._robot)  # what was on its way may have come after the stop

    def _stop(self, robot: Robot) -> None:
        told = False
        while not self._ended.is_set():
            try:
                robot.stop(whoami(), _STOP_WITHIN)
            except Exception as error:  # likewise
                if not told:
                    typer.echo(f"STOP was not heard and is sent until it is: {error}", err=True)
                told = True
                self._ended.wait(self._pause)
            else:
                typer.echo("stopped")
                return


def obey(heard: Utterance, robot: Robot | None, *, quiet: bool = False) -> None:
    """Say what was understood, and have the robot do it.

    Args:
        heard: What was heard.
        robot: That shall obey; None where it is only said.
        quiet: Say nothing.

    Raises:
        DeviceError: the robot does not answer or refuses.
    """
    said = []
    if heard.question is not None:
        said.append(heard.question)
    elif heard.command is None:
        said.append(f"not understood; say for example: {' '.join(EXAMPLES)}")
    else:
        answer = (
            None if robot is None else _done(heard.command, heard.at_once, robot)
        )  # a stop waits for no word
        said.append(f"command: {command_text(heard.command)}")
        said += [] if answer is None else [answer]
    if not quiet:
        for line in said:
            typer.echo(line)
    if heard.question is not None and robot is not None:
        robot.doubt(heard.question)  # asked here first: the robot may not answer


def _done(command: Command, at_once: bool, robot: Robot) -> str | None:
    """Have the robot obey; what it answers, or what it cannot do yet."""
    match command:
        case Stop():
            robot.stop(whoami())
            return "stopped"
        case GoTo(goals, after):
            robot.ask(goals, at_once=at_once)
            return None if after is None else _done(after, False, robot)
        case All(goal):
            robot.ask([goal], at_once=at_once)
            return ONE_OF_ALL
        case WhereIs(goal):
            return str(robot.places(goal)["told"])
        case ComeBack():
            robot.come_back(at_once=at_once)
        case Dock():
            robot.dock(at_once=at_once)
        case Explore():
            robot.explore(at_once=at_once)
    return None
