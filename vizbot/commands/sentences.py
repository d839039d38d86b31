"""What the command line's TEXT arguments ask for, by the grammar of console and voice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from vizbot.core.errors import ConfigError
from vizbot.core.normal_text import seen_text
from vizbot.operator.language.command import (
    All,
    Command,
    Decline,
    GoTo,
    HowMany,
    Reason,
    WhereIs,
    goals_of,
    join_commands,
)
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.operator.printing import echo


def parse_texts(texts: Sequence[str], language: Language = ENGLISH) -> Command:
    """One command for all arguments; several goals are one mission.

    Raises:
        ConfigError: an argument is empty or not understood, or they do not go together.
    """
    commands = [_parse_text(text, language) for text in texts]
    if (command := join_commands(commands)) is None:
        raise ConfigError(
            f"{' '.join(map(repr, texts))} cannot be one mission; give goals, then at most"
            ' "come back" or "dock", or one sentence alone'
        )
    return command


def one_sentence(texts: Sequence[str], language: Language = ENGLISH) -> str:
    """A sentence that asks for what all arguments ask for.

    Raises:
        ConfigError: an argument is empty or not understood, or they do not go together.
    """
    command = parse_texts(texts, language)
    literals = [part for text in texts for part in language.grammar.literals(text)]
    quoted = {goal for goal in goals_of(command) if any(part in goal for part in literals)}
    return language.grammar.text(command, quoted=quoted)


def parse_goals(texts: Sequence[str], language: Language = ENGLISH) -> list[str]:
    """What a dry run is to look for, in this order.

    Raises:
        ConfigError: an argument is empty or not understood, or asks for anything but goals.
    """
    goals: list[str] = []
    for text in texts:
        command = _parse_text(text, language)
        if isinstance(command, GoTo) and command.after is None:
            goals += command.goals
        elif isinstance(command, All):
            echo(f"{command.goal}: {language.say('one_of_all')}", err=True)
            goals.append(command.goal)
        else:
            raise ConfigError(
                f"a dry run takes goals ('sofa', 'go to the sofa') or --explore, and {text!r} is"
                " another command; put a thing of that name in double quotes"
            )
    return goals if language is ENGLISH else [_translated(goal, language) for goal in goals]


def parse_question(text: str, language: Language = ENGLISH) -> WhereIs | HowMany:
    """What a saved map is asked: where a thing is, which may be named alone, or how many there are.

    A description ("something to sit on") counts as a thing: encoders know open words.

    Raises:
        ConfigError: the text is empty, another command, or not understood.
    """
    if not text.strip():
        raise ConfigError("the question '' is empty; say what to look for, for example 'sofa'")
    match language.grammar.typed(text):
        case WhereIs() | HowMany() as question:
            pass
        case GoTo((goal,), None):
            question = WhereIs(goal)
        case Decline(Reason.STATEMENT):
            question = WhereIs(text)
        case _:
            raise ConfigError(
                "map query takes a thing ('sofa'), 'where is the sofa?' or 'how many sofas are"
                f" there?', not {text!r}; put a thing of that name in double quotes"
            )
    if language is ENGLISH:
        return question
    return replace(question, goal=_translated(question.goal, language))


def _translated(goal: str, language: Language) -> str:
    """A goal in the encoder's words; others are said."""
    words = language.lexicon.read(goal).words
    echo(language.say("reading", heard=goal, meant=words), err=True)
    return words


def require_text(text: str) -> None:
    """Raise a `ConfigError` for what is no sentence."""
    if not text.strip():
        raise ConfigError("the goal '' is empty; say what to go to, for example 'yellow chair'")
    if not seen_text(text).isprintable():
        raise ConfigError(
            f"the goal {text!r} holds characters that are no text; say it in plain words"
        )


def _parse_text(text: str, language: Language) -> Command:
    require_text(text)
    command = language.grammar.typed(text)
    if command is None or isinstance(command, Decline):
        raise ConfigError(
            f"{text!r} is not understood; say for example 'go to the kitchen', or put a thing's"
            " name in double quotes"
        )
    return command
