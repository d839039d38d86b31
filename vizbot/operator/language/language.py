"""The languages that vizbot understands and answers in; each is a file of `languages`."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import ROOMS
from vizbot.core.observer import CLAUSE_JOINT
from vizbot.operator.language.command_grammar import Grammar
from vizbot.operator.language.lexicon import Lexicon, english_lexicon, translating_lexicon
from vizbot.operator.language.phrase_grammar import Phrasing
from vizbot.operator.language.step_splitter import either

_OF_ENCODERS = "en"
"""The language that encoders know."""
FOLDER = Path(__file__).with_name("languages")


@dataclass(frozen=True, eq=False)
class Language:
    """What people say to the robot, and what it answers.

    Attributes:
        code: As ISO 639-1 has it.
        name: In the language itself.
        entries: What its file holds.
        lexicon: Reads its names of things and rooms.
        answers: Templates of what the robot says, by what they are for.
        joint: The word between two things, "and".
        spoken: The sentences that are searched for in a sound.
    """

    code: str
    name: str
    entries: Mapping[str, Any]
    lexicon: Lexicon
    answers: Mapping[str, str]
    joint: str
    spoken: Phrasing

    @cached_property
    def grammar(self) -> Grammar:
        """Reads its sentences; made when the first one is read, since that takes a while."""
        return Grammar(self.entries, self.lexicon.is_name, self.lexicon.knows)

    def without_room(self, goal: str) -> tuple[str, str]:
        """A known thing without the room that it is said to be in, and these words.

        The second is empty, and the first the goal, where it is in none.
        """
        plain = self.grammar.without_article
        for found in re.finditer(rf"\s(?:{either(self.entries['words']['within'])})\s", goal):
            thing, room = goal[: found.start()], plain(goal[found.end() :])
            if self.lexicon.names.get(room) in ROOMS and self.lexicon.knows(thing):
                return thing, goal[found.start() :].strip()
        return goal, ""

    def say(self, answer: str, **fields: object) -> str:
        """What the robot says."""
        return self.answers[answer].format(**fields)

    def doing(self, text: str) -> str:
        """What the robot does, or why; each clause that the table `doing` lacks stays English."""
        return CLAUSE_JOINT.join(map(self._clause, text.split(CLAUSE_JOINT)))

    def _clause(self, clause: str) -> str:
        for english, own in self._doing:
            if found := english.fullmatch(clause):
                return own.format(**found.groupdict())
        return clause

    @cached_property
    def _doing(self) -> list[tuple[re.Pattern[str], str]]:
        """What clauses look like, and how the language has them."""
        field = re.compile(r"\\{(\w+)\\}")
        return [
            (re.compile(field.sub(r"(?P<\1>.+)", re.escape(english))), own)
            for english, own in self.entries.get("doing", {}).items()
        ]


def languages() -> tuple[str, ...]:
    """Codes of the languages that there are."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


@cache
def load_language(code: str) -> Language:
    """A language by its code.

    Raises:
        ConfigError: there is no such language.
    """
    if code not in languages():
        raise ConfigError(f"--language {code}: give one of {', '.join(languages())}")
    entries = tomllib.loads((FOLDER / f"{code}.toml").read_text(encoding="utf-8"))
    make_lexicon = english_lexicon if code == _OF_ENCODERS else translating_lexicon
    lexicon = make_lexicon(entries["names"], entries["small"], entries["words"]["unread"])
    joint = entries["words"]["and"][0]
    return Language(
        code,
        entries["name"],
        entries,
        lexicon,
        entries["answers"],
        joint,
        Phrasing(entries["spoken"]),
    )


ENGLISH = load_language("en")
