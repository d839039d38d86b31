"""What the command line's TEXT arguments ask for, by the grammar of console and voice."""

from __future__ import annotations

from collections.abc import Sequence

from vizbot.core.errors import ConfigError
from vizbot.operator.language.command import ONE_OF_ALL, All, Command, GoTo, Stop
from vizbot.operator.language.command_grammar import join_commands, parse_typed
from vizbot.operator.printing import echo


def parse_texts(texts: Sequence[str]) -> Command:
    """One command for all arguments; several goals are one mission, and a stop goes before all.

    Raises:
        ConfigError: an argument is empty or not understood, or they do not go together.
    """
    commands = [_parse_text(text) for text in texts]
    if any(isinstance(command, Stop) for command in commands):
        return Stop()
    if (command := join_commands(commands)) is None:
        raise ConfigError(
            f"{' '.join(map(repr, texts))} cannot be one mission; give goals, then at most"
            ' "come back" or "dock", or one sentence alone'
        )
    return command


def parse_goals(texts: Sequence[str]) -> list[str]:
    """What a dry run is to look for, in this order.

    Raises:
        ConfigError: an argument is empty or not understood, or asks for anything but goals.
    """
    goals: list[str] = []
    for text in texts:
        command = _parse_text(text)
        if isinstance(command, GoTo) and command.after is None:
            goals += command.goals
        elif isinstance(command, All):
            echo(f"{command.goal}: {ONE_OF_ALL}", err=True)
            goals.append(command.goal)
        else:
            raise ConfigError(
                f"a dry run takes goals ('sofa', 'go to the sofa') or --explore, and {text!r} is"
                " another command; put a thing of that name in double quotes"
            )
    return goals


def _parse_text(text: str) -> Command:
    if not text.strip():
        raise ConfigError("the goal '' is empty; say what to go to, for example 'yellow chair'")
    if not text.isprintable():
        raise ConfigError(f"the goal {text!r} holds what is no text; say it in plain words")
    if (command := parse_typed(text)) is None:
        raise ConfigError(
            f"{text!r} is not understood; say for example 'go to the kitchen', or put a thing's"
            " name in double quotes"
        )
    return command
