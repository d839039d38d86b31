"""What is done about a command: done, done in other words, or asked back first.

Whether it was typed or spoken, whoever understands it makes it go through here, so that nothing
drives to what nobody named.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from vizbot.operator.language.command import (
    Command,
    HowMany,
    WhereIs,
    drives,
    goals_of,
    split_goals,
    with_goals,
)
from vizbot.operator.language.language import Language


@dataclass(frozen=True, slots=True)
class Understanding:
    """What a sentence is understood as.

    Attributes:
        command: The command in the encoder's words; with a question, the one for yes.
        notes: Lines that say which words were taken for which.
        question: What to ask back before anything is done; None without a doubt.
        meant: The sentence that says yes to it; None without one.
    """

    command: Command
    notes: tuple[str, ...] = ()
    question: str | None = None
    meant: str | None = None


def understand(
    command: Command, language: Language, literal: Collection[str] = (), *, alone: bool = False
) -> Understanding:
    """Read the goals of a command.

    `literal` parts of goals are taken literally; `alone`: they were typed without a command.
    """

    def parts(goal: str) -> tuple[str, ...]:
        literally = _is_literal(goal, literal)
        return (goal,) if literally else language.lexicon.parts(goal, language.joint)

    command = split_goals(command, parts)
    notes = list[str]()
    if isinstance(command, WhereIs | HowMany) and not _is_literal(command.goal, literal):
        goal, room = language.without_room(command.goal)
        command = replace(command, goal=goal)
        notes += [language.say("unread", word=room)] if room else []
    goals, read = goals_of(command), list[str]()
    for place, goal in enumerate(goals):
        if _is_literal(goal, literal):
            read.append(goal)
            continue
        meaning = language.lexicon.read(goal, alone=alone)
        if not meaning.known:
            near, plain = meaning.near, language.grammar.without_article
            better = goal if near is None else plain(near)
            instead = with_goals(command, [*goals[:place], better, *goals[place + 1 :]])
            quoted = {*literal} | ({goal} if near is None else set())
            return Understanding(
                command,
                question=_question(command, goal, near, language),
                meant=language.grammar.text(instead, quoted=quoted),
            )
        read.append(meaning.words)
        notes += [language.say("reading", heard=one, meant=other) for one, other in meaning.notes]
        notes += [language.say("unread", word=word) for word in meaning.unread]
    return Understanding(with_goals(command, read), tuple(notes))


def read_typed(line: str, language: Language) -> tuple[Command | None, Understanding | None, bool]:
    """The command in a typed line, what it is understood as, and whether all else gives way to it.

    Raises:
        SentenceTooLongError: the line is too long to be read.
    """
    read = language.grammar.read(line)
    if read.command is None:
        return None, None, False
    understood = understand(read.command, language, read.literals, alone=read.alone)
    return read.command, understood, read.at_once


def _question(command: Command, goal: str, near: str | None, language: Language) -> str:
    if near is not None:
        return language.say("did_you_mean", goal=near)
    return language.say("search_for" if drives(command) else "look_for", goal=goal)


def _is_literal(goal: str, literal: Collection[str]) -> bool:
    return any(part in goal for part in literal)
