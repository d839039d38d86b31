"""`vizbot voice`: commands by microphone or from a sound file."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict
from enum import Enum
from pathlib import Path

import numpy as np
import typer

from vizbot.commands.dispatch import CommandSender, obey
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.core.program.interrupts import ended_by_interrupt
from vizbot.operator.client.endpoint import LANGUAGE
from vizbot.operator.client.robot_client import RobotClient
from vizbot.operator.client.stop import HERE
from vizbot.operator.language.command import Cancel, Command, Explore, GoTo, No, Yes, command_name
from vizbot.operator.language.language import ENGLISH, Language, load_language
from vizbot.operator.printing import echo
from vizbot.operator.session.vocabulary import HOUSEHOLD, VocabularyUpdater
from vizbot.operator.voice.endpointing import Listener
from vizbot.operator.voice.intent import Utterance, after_wake, confirmed
from vizbot.operator.voice.microphone import Microphone
from vizbot.operator.voice.recogniser import Recogniser, require_model, transcribe

_DOUBT_HOLDS = 15.0
"""Longest time between a question and a yes to it [s]."""


def run(
    *,
    wav: Path | None,
    model: str,
    wake: str | None,
    as_json: bool,
    url: str | None,
    token: str | None,
    language: str = LANGUAGE,
) -> bool:
    """Listen once to a file, or to the microphone until Ctrl-C or the end of input.

    `wav` None listens to the microphone; `wake` None has a key pushed to talk; `model` is Whisper's
    size or a folder; `as_json` prints what a file says, and nothing else. The running robot at
    `url` obeys, None that of this machine; where none runs here, commands are only printed.

    Returns:
        Whether a command was understood without a doubt; always True with a microphone.

    Raises:
        ConfigError: a package, the model or the file cannot be used.
        DeviceError: there is no microphone, or the robot does not answer.
    """
    if wav is not None and wake is not None:
        raise ConfigError("--wake is for the microphone; leave it out with --wav")
    if wav is None and as_json:
        raise ConfigError("--json is for one sound file; give --wav FILE")
    if wav is not None and not wav.is_file():
        raise ConfigError(f"{wav}: no such file; give a recording, for example a .wav")
    spoken = load_language(language)
    require_model(model)
    with ExitStack() as opened:
        robot = _robot(url, token, opened)
        if wav is None:
            microphone = opened.enter_context(Microphone())
            recogniser = Recogniser(HOUSEHOLD, model, language=spoken)
            if robot is not None:
                opened.enter_context(VocabularyUpdater(robot.vocabulary, recogniser.learn))
            sender = opened.enter_context(CommandSender(robot))
            with ended_by_interrupt():
                _converse(microphone, recogniser, wake, sender, language=spoken)
            return True
        recogniser = Recogniser(HOUSEHOLD, model, language=spoken)
        if robot is not None:
            VocabularyUpdater(robot.vocabulary, recogniser.learn).ask()
        utterance = transcribe(wav, recogniser)
        if as_json:
            echo(json.dumps(_utterance_json(utterance)))
        else:
            echo(f"heard: {utterance.text or 'nobody speaks'}")
        obey(utterance, robot, quiet=as_json)
        return utterance.command is not None and utterance.question is None


def _robot(url: str | None, token: str | None, opened: ExitStack) -> RobotClient | None:
    """The robot at a URL, or the one of this machine if it answers."""
    robot = opened.enter_context(RobotClient(url or HERE, token))
    if url is None:
        try:
            robot.state()
        except DeviceError:
            echo(
                "No robot runs on this machine: what is understood is only printed. Give --url.",
                err=True,
            )
            return None
    return robot


def _converse(
    microphone: Microphone,
    recogniser: Recogniser,
    wake: str | None,
    sender: CommandSender,
    now: Callable[[], float] = time.monotonic,
    language: Language = ENGLISH,
) -> None:
    """Listen on a key, or all the time for a wake phrase; a doubt ends with the next utterance."""
    doubtful: Utterance | None = None
    doubted_at = now()
    listener = Listener(recogniser, wake, language)
    if wake is None:
        echo("Press Enter, speak, press Enter again; Ctrl-C ends.", err=True)
    else:
        echo(f'Say "{wake}" and what to do, or "stop" at any time; Ctrl-C ends.', err=True)
    while True:
        utterance = _push_to_talk(microphone, recogniser) if wake is None else None
        if utterance is None and wake is not None:
            utterance = listener.take(np.concatenate([microphone.read(), microphone.drain()]))
        if utterance is None or not utterance.text:
            continue
        doubted, doubtful = doubtful, None
        if doubted is not None and now() - doubted_at < _DOUBT_HOLDS:
            if isinstance(utterance.command, No):  # not for the robot, which would take it for more
                echo(language.say("no_then"))
                continue
            if isinstance(utterance.command, Yes):
                utterance = confirmed(doubted)
        if wake is not None and not _is_addressed(utterance, wake):
            continue  # people talk to each other, too
        echo(f"heard: {utterance.text}", err=True)
        sender.send(utterance)
        if utterance.question is not None:
            doubtful, doubted_at = utterance, now()


def _is_addressed(utterance: Utterance, wake: str) -> bool:
    """Whether the robot is meant; a yes or a no to nothing needs the wake phrase, too."""
    if isinstance(utterance.command, Yes | No):
        return after_wake(utterance.text, wake) is not None
    return utterance.command is not None


def _push_to_talk(microphone: Microphone, recogniser: Recogniser) -> Utterance:
    """One utterance between two presses of Enter."""
    _enter()
    microphone.drain()
    _enter()
    return recogniser.hear(microphone.drain())


def _enter() -> None:
    """Wait for Enter; the end of input ends the command."""
    if not typer.get_binary_stream("stdin").readline():
        raise typer.Exit(0)


def _utterance_json(utterance: Utterance) -> dict[str, object]:
    command = None if utterance.command is None else _command_json(utterance.command)
    understood = {"command": command, "question": utterance.question, "at_once": utterance.at_once}
    return {"heard": utterance.text, **understood}


def _command_json(command: Command) -> dict[str, object]:
    fields = {"name": command_name(command), **asdict(command)}
    if isinstance(command, GoTo | Explore | Cancel):
        fields["after"] = None if command.after is None else command_name(command.after)
    return {
        name: field.value if isinstance(field, Enum) else field for name, field in fields.items()
    }
