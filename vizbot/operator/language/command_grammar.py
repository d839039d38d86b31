"""The sentences that vizbot obeys: from a line of text, typed or heard, to a command.

The grammar looks for "stop" first. Otherwise it drops politeness and fillers, cuts the line into
steps at "then", "and" or a comma, and expects each step to open with one of the phrases below.
Words that open with none are no command, so that a robot does not follow what people say to each
other. Where only the robot is addressed, as in everything that is typed, they are a goal.

Words in double quotes are taken literally, so that anything can be asked for: `"go to the kitchen"`
with its quotes is a thing of that name, as in `find "the last exit sign", then come back`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from vizbot.operator.language.command import (
    All,
    ComeBack,
    Command,
    Dock,
    Explore,
    GoTo,
    Stop,
    WhereIs,
    command_name,
)

EXAMPLES = (
    "Go to the kitchen.",
    "Find the chair, then the table.",
    "Take me to the sofa.",
    "Where is the lamp?",
    "Show me all the doors.",
    "Come back.",
    "Dock.",
    "Go to your dock.",
    "Stop!",
)
"""A sentence for each thing that is understood: help for people, a hint for those who listen."""

_STOP = re.compile(r"\b(?:stop|stops|stopped|stopping|halt)\b(?! signs?\b)")
"""A "stop sign" can be gone to; no other use of the word is worth missing a stop."""

_REST = re.compile(
    r"(?:wait(?: a (?:moment|minute|second))?|pause|freeze|quit|abort|forget it|never mind|"
    r"cancel(?: (?:it|this|that|everything))?|hold (?:on|it|still)|stand still|"
    r"stay (?:here|there|where you are)|(?:don't|do not) move)"
)
"""These mean stop where nothing else is said: there are waiting rooms and pause buttons."""
_NOT = re.compile(r"(?:don't|do not|never|not)\b|.* not$")

_FILLERS = re.compile(
    r"\b(?:uh|uhm|um|er|erm|ah|hm+|please|kindly|actually|just|maybe|"
    r"for me|thank you|thanks|(?:hey|hi|hello|okay|ok) robot)\b"
)
_AT_ONCE = re.compile(r"\b(?:right now|right away|straight away|at once|immediately)\b")
_NOW = re.compile(r"\b(?:now|instead)\b")
"""They say the same as those above before or after a step; within it they may be of its goal."""
_OPENINGS = re.compile(
    r"^(?:(?:hey|hi|hello|okay|ok|so|now|instead|well|yes|robot|and|then|next|"
    r"(?!(?:don't|do|have|did) )[\w']+ you(?! see)|"
    r"(?:i want|i need|i would like|i'd like) (?:you )?to|"
    r"would you mind|let's|let us|you (?:can|should|must)|go and|go ahead and)(?: |$))+"
)
"""Any word may stand before "you": "could you" in noise is often heard as "show you"."""
_CLOSINGS = re.compile(r"(?: (?:now|instead|okay|ok|robot|will you|would you|can you|could you))+$")
_ARTICLES = re.compile(r"^(?:(?:the|a|an|my|our|your|this|that|these|those|some)(?: |$))+")

_PLACE = r"(?: over| back| on| straight)?(?: to| into| in| towards?)"
_GO = re.compile(
    rf"(?:(?:go|drive|head|move|navigate|walk|travel|run|come|return|get){_PLACE}|"
    r"(?:(?:take|bring|lead|guide) (?:me|us))(?: over| back)?(?: to| into)|"
    r"find(?: me| us)?|show (?:me|us)|look for|search for|seek|locate|go (?:see|find)|"
    r"go look for|visit) (?P<goal>.+)"
)
_WHERE = re.compile(
    r"(?:where (?:is|are)|where's|where can i find|where did you see|have you seen|"
    r"can you see|do you see) (?P<goal>.+)"
)
_WHERE_LAST = re.compile(
    r"(?:do you know|tell me|show me|find out) where (?P<goal>.+?) (?:is|are|stands?)"
)
_ALL = re.compile(r"(?:all(?: of)?|every|each(?: of)?) (?P<goal>.+)")
_YEA = r"(?:yes|yeah|yep|yup|right|correct|exactly|sure|i did|that's (?:right|correct|it))"
_YES = re.compile(rf"{_YEA}(?: (?:{_YEA}|i do|it is|that one|do it|go ahead|robot))*")
_START = (
    r"(?:(?:to )?(?:me|us|here|home|(?:the |your )?start(?:ing point)?|where you (?:started|were)))"
)
_COME_BACK = re.compile(
    rf"come (?:back|home|here|to me)(?: {_START})?|(?:go|drive) back(?: {_START})?|"
    rf"return(?: {_START})?|(?:go|drive|head|back) {_START}|come {_START}"
)
_CHARGER = (
    r"(?:the |your )?(?:dock|docking station|charger|charging (?:station|dock|base)|home base|base)"
)
_DOCK = re.compile(
    rf"dock(?: yourself)?|(?:go|drive|head|return|back)(?: back)?(?: home)?(?: to)? {_CHARGER}|"
    r"go home|(?:(?:go|come|return|drive|head)(?: back)?(?: home)? (?:to|and) )?"
    r"(?:charge|recharge|dock)(?: yourself| your battery)?"
)
_EXPLORE = re.compile(
    r"(?:explore|(?:have a )?look around)(?: (?:in )?(?:the |my |our |this |your )?"
    r"(?:house|home|flat|apartment|place|rooms?|surroundings|everything|everywhere))?"
)
_QUOTE = re.compile(r"[\"\N{LEFT DOUBLE QUOTATION MARK}\N{RIGHT DOUBLE QUOTATION MARK}]")
_LITERAL = re.compile(rf"{_QUOTE.pattern}(.*?){_QUOTE.pattern}")
_MARK = "\N{LATIN LETTER BIDENTAL PERCUSSIVE}"
"""A letter that no language is written with: it stands for what was in quotes."""
_MARKED = re.compile(rf"{_MARK}(\d+){_MARK}")
_STEP = re.compile(
    r"(?:\s*,)?\s+(?:and |but )?(?:then|after that|afterwards|followed by|next)\b(?:\s*,)?\s*"
)
_LIST = re.compile(
    r"(?:\s*,\s*and |\s+and |\s*,\s*)"
    r"(?=(?:the|a|an|my|our|your|go|drive|come|return|find|show|take|dock|charge|to the)\b)"
)


def parse_command(line: str) -> Command | None:
    """The command in a line that was heard; None if there is none.

    Quotes mean nothing here: no speaker says them.
    """
    return _parse(line.replace(_MARK, " "), ())


def parse_typed(line: str) -> Command | None:
    """The command in a line that was typed to the robot; None if there is none.

    A thing that stands alone is a goal, in the very words that were typed. Words in quotes are
    taken literally.
    """
    marked, literals = _without_literals(line)
    command = _parse(marked, literals)
    if command is not None:
        return command
    command = _parse(marked, literals, bare=True)
    single = isinstance(command, GoTo) and len(command.goals) == 1 and command.after is None
    if single and not _QUOTE.search(line) and not is_urgent(line):
        return GoTo((line.strip(),))
    return command


def command_text(command: Command, at_once: bool = False) -> str:
    """A sentence with the same meaning, for example "go to kitchen, then sofa, then dock".

    Goals stand in quotes where `parse_typed` would not find them again without.
    """
    if at_once:
        return f"{command_text(command)}, right now"
    text = _sentence(command, "{}")
    found_again = parse_typed(text) == command and not is_urgent(text)
    return text if found_again else _sentence(command, '"{}"')


def is_urgent(line: str) -> bool:
    """Whether a line says that it must not wait for what is running: "right now", "instead"."""
    line, _ = _without_literals(line)
    around = [around for _, around in _steps(line)]
    return bool(_AT_ONCE.search(_plain(line)) or any(map(_NOW.search, around)))


def is_yes(line: str) -> bool:
    """Whether a line agrees to a question and says nothing else."""
    words = _polished(line).replace(",", "")
    return _YES.fullmatch(words) is not None


def _without_literals(line: str) -> tuple[str, Sequence[str]]:
    """The line with a mark in place of each part in quotes, and these parts.

    A stop alone is no literal: it must not be missed because somebody puts it in quotes.
    """
    literals: list[str] = []

    def mark(found: re.Match[str]) -> str:
        literal = " ".join(found[1].split())
        if not literal or _STOP.fullmatch(_tidy(_plain(literal))):
            return f" {literal} "
        literals.append(literal)
        return f" {_MARK}{len(literals) - 1}{_MARK} "

    return _LITERAL.sub(mark, line.replace(_MARK, " ")), literals


def _with_literals(goal: str, literals: Sequence[str]) -> str:
    """A goal with each part in quotes in the place of its mark again."""
    return _MARKED.sub(lambda found: literals[int(found[1])], goal)


def _sentence(command: Command, goal_format: str) -> str:
    match command:
        case GoTo(goals, after):
            steps = [goal_format.format(goal) for goal in goals]
            steps += [] if after is None else [command_name(after)]
            return f"go to {', then '.join(steps)}"
        case WhereIs(goal):
            return f"where is {goal_format.format(goal)}"
        case All(goal):
            return f"go to all {goal_format.format(goal)}"
    return command_name(command)


def _parse(line: str, literals: Sequence[str], *, bare: bool = False) -> Command | None:
    """The command in a line.

    Args:
        line: With marks in place of its literals.
        literals: What each mark stands for.
        bare: A goal needs no words before it.
    """
    if _STOP.search(_plain(line).replace(",", " , ")):
        return Stop()
    steps = [words for words, _ in _steps(line) if words]
    return join_commands(
        [_step(step, literals, bare=bare or index > 0) for index, step in enumerate(steps)]
    )


def _plain(line: str) -> str:
    """Small letters, digits, apostrophes and hyphens; commas where a sentence has a pause."""
    line = line.casefold().replace("\N{RIGHT SINGLE QUOTATION MARK}", "'")
    line = re.sub(r"[,;:.!?…]+(?=\s|$)", ",", line)
    return re.sub(r"[^\w',-]+", " ", line)


def _tidy(words: str) -> str:
    return re.sub(r"\s*,[\s,]*", ", ", " ".join(words.split())).strip(", -")


def _polished(line: str) -> str:
    return _tidy(_AT_ONCE.sub(" ", _FILLERS.sub(" ", _plain(line))))


def _steps(line: str) -> list[tuple[str, str]]:
    """Of each step its words, which may be none, and those before and after them."""
    parts = [part for half in _STEP.split(_polished(line)) for part in _LIST.split(half)]
    steps = []
    for whole in (_tidy(part).replace(",", "") for part in parts):
        rest = _OPENINGS.sub("", whole)
        words = _CLOSINGS.sub("", rest)
        steps.append((words, whole.removesuffix(rest) + rest.removeprefix(words)))
    return steps


def _step(words: str, literals: Sequence[str], *, bare: bool) -> Command | None:
    """The command of one step.

    After the first step a goal may stand alone: "the sofa, then the lamp".
    """
    if _REST.fullmatch(words):
        return Stop()
    if _NOT.match(words):
        return None
    if _EXPLORE.fullmatch(words):
        return Explore()
    if _DOCK.fullmatch(words):
        return Dock()
    if _COME_BACK.fullmatch(words):
        return ComeBack()
    asked = _WHERE_LAST.fullmatch(words) or _WHERE.fullmatch(words)
    went = _GO.fullmatch(words)
    if asked is None and went is None and not bare:
        return None
    match = asked or went
    wanted = words.removeprefix("to ") if match is None else match["goal"]
    every = _ALL.fullmatch(wanted)
    goal = _ARTICLES.sub("", wanted if every is None else every["goal"])
    goal = _with_literals(goal, literals)
    if not goal:
        return None
    if every is not None:
        return All(goal)
    return WhereIs(goal) if asked is not None else GoTo((goal,))


def join_commands(commands: Sequence[Command | None]) -> Command | None:
    """Several commands as one; None if they cannot be one, or one of them is none."""
    if len(commands) == 1:
        return commands[0]
    goals: list[str] = []
    after: ComeBack | Dock | None = None
    for command in commands:
        if isinstance(command, GoTo) and after is None:
            goals += command.goals
        elif isinstance(command, Dock) or (isinstance(command, ComeBack) and after is None):
            after = command
        else:
            return None
    return GoTo(tuple(goals), after) if goals else after
