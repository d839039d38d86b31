"""Sends what was heard to a running robot."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from queue import SimpleQueue
from typing import Any, Protocol, Self

from vizbot.operator.client.robot_client import answer_lines
from vizbot.operator.client.stop import whoami
from vizbot.operator.language.command import Stop
from vizbot.operator.printing import echo
from vizbot.operator.voice.intent import Utterance

_STOP_WITHIN = 1.5
"""A stop that has no answer after this time is sent again [s]."""
_STOP_PAUSE = 0.5
"""Pause before a stop is sent again [s]."""
_PATIENCE = 5.0
"""At the end the last command has this time to reach the robot [s]."""


class Robot(Protocol):
    """The part of `vizbot.operator.client.robot_client.RobotClient` that voice commands need."""

    def say(self, text: str, who: str, *, at_once: bool) -> dict[str, Any]:
        """Do what a sentence asks for; `at_once`: what is running gives way."""
        ...

    def stop(self, who: str, timeout: float = ...) -> None:
        """Stop the robot now, or raise `DeviceError` after `timeout` [s] at the latest."""
        ...

    def doubt(self, question: str) -> None:
        """Show a question that was asked back."""
        ...


class CommandSender:
    """Sends commands in order, by a thread, so that whoever listens goes on listening.

    A stop overtakes all others: it is sent until the robot has answered it, and commands that were
    said before are not sent any more. Entering starts the thread, leaving ends it.
    """

    def __init__(self, robot: Robot | None, pause: float = _STOP_PAUSE) -> None:
        """Create it idle.

        `robot` None only prints commands; a stop without an answer is sent again after `pause` [s].
        """
        self._robot = robot
        self._pause = pause
        self._waiting: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._stops = 0
        self._stopping: threading.Thread | None = None
        self._ended = threading.Event()
        self._worker = threading.Thread(target=self._work, name="commands", daemon=True)

    def send(self, utterance: Utterance) -> None:
        """Queue a command to be sent; returns at once."""
        if self._robot is None or not isinstance(utterance.command, Stop):
            self._waiting.put(partial(self._obey, utterance, self._stops))
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
            job = self._waiting.get()
            if self._stopping is not None:
                self._stopping.join()  # what was said after a stop must not come before it
            job()

    def _obey(self, utterance: Utterance, stops: int) -> None:
        """Send one command, unless a stop was said since there were `stops` of them."""
        if stops != self._stops:
            return
        try:
            obey(utterance, self._robot)
        except Exception as error:  # whatever it is, the next command may come through
            echo(str(error), err=True)
        if stops != self._stops and self._robot is not None:
            self._stop(self._robot)  # what was on its way may have come after the stop

    def _stop(self, robot: Robot) -> None:
        reported = False
        while not self._ended.is_set():
            try:
                robot.stop(whoami(), _STOP_WITHIN)
            except Exception as error:  # likewise
                if not reported:
                    echo(f"STOP was not heard and is sent until it is: {error}", err=True)
                reported = True
                self._ended.wait(self._pause)
            else:
                echo("stopped")
                return


def obey(utterance: Utterance, robot: Robot | None, *, quiet: bool = False) -> None:
    """Print what was understood, unless `quiet`, and have the robot do it; None only prints.

    Raises:
        DeviceError: the robot does not answer or refuses.
    """
    lines = []
    if utterance.question is not None:
        lines.append(utterance.question)
    elif utterance.command is None:
        lines.append(
            f"not understood; say for example: {' '.join(utterance.language.grammar.examples)}"
        )
    else:
        answer = [] if robot is None else _sent(utterance, robot)  # a stop waits for no word
        lines += [f"command: {utterance.language.grammar.text(utterance.command)}", *answer]
    if not quiet:
        for line in lines:
            echo(line)
    if utterance.question is not None and robot is not None:
        robot.doubt(utterance.question)  # asked here first: the robot may not answer


def _sent(utterance: Utterance, robot: Robot) -> list[str]:
    """Have the robot obey; what it answers beyond repeating the command."""
    if utterance.command is None:
        return []
    if isinstance(utterance.command, Stop):
        robot.stop(whoami())  # by its own way, which needs no token
        return ["stopped"]
    sentence = utterance.language.grammar.text(utterance.command)
    reply = robot.say(sentence, whoami(), at_once=utterance.at_once)
    return answer_lines(reply)[1:] if reply["numbers"] else answer_lines(reply)
