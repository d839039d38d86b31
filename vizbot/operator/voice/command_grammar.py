"""The words that vizbot obeys: from a line of text, typed or heard, to a command.

A line is looked through for "stop" first. Otherwise politeness and fillers are dropped, the line is
cut into steps at "then", "and" or a comma, and each step must open with a phrase below. Words that
open with none are no command, so that a robot does not follow what people say to each other; where
only the robot is spoken to, they are a goal.
"""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Stop:
    """Stand still at once; asks for nothing back."""


@dataclass(frozen=True, slots=True)
class ComeBack:
    """Go to where the run began."""


@dataclass(frozen=True, slots=True)
class Dock:
    """Go to the charger and charge."""


@dataclass(frozen=True, slots=True)
class Explore:
    """Drive until nothing is left to see."""


@dataclass(frozen=True, slots=True)
class GoTo:
    """One mission.

    Attributes:
        goals: What to go to, in this order; at least one.
        after: What to do once the last goal has ended; None: stay there.
    """

    goals: tuple[str, ...]
    after: ComeBack | Dock | None = None


@dataclass(frozen=True, slots=True)
class WhereIs:
    """Tell where something is, and stay.

    Attributes:
        goal: What is asked for.
    """

    goal: str


@dataclass(frozen=True, slots=True)
class All:
    """Go to everything of a kind.

    Attributes:
        goal: What is asked for, as said: often a plural.
    """

    goal: str


Command = Stop | ComeBack | Dock | Explore | GoTo | WhereIs | All

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
_STEP = re.compile(
    r"(?:\s*,)?\s+(?:and |but )?(?:then|after that|afterwards|followed by|next)\b(?:\s*,)?\s*"
)
_LIST = re.compile(
    r"(?:\s*,\s*and |\s+and |\s*,\s*)"
    r"(?=(?:the|a|an|my|our|your|go|drive|come|return|find|show|take|dock|charge|to the)\b)"
)


def parse_command(line: str, *, bare: bool = False) -> Command | None:
    """The command in a line of text; None if there is none.

    Args:
        line: Typed or heard.
        bare: A goal needs no words before it.
    """
    words = _plain(line)
    if _STOP.search(words.replace(",", " , ")):
        return Stop()
    steps = [words for words, _ in _steps(line) if words]
    commands = [_step(step, bare=bare or index > 0) for index, step in enumerate(steps)]
    if len(commands) == 1:
        return commands[0]
    return _mission(commands)


def is_urgent(line: str) -> bool:
    """Whether a line says that it must not wait for what is running: "right now", "instead"."""
    around = [around for _, around in _steps(line)]
    return bool(_AT_ONCE.search(_plain(line)) or any(map(_NOW.search, around)))


def is_yes(line: str) -> bool:
    """Whether a line says yes to a question and nothing else: people talk to each other, too."""
    words = _polished(line).replace(",", "")
    return _YES.fullmatch(words) is not None


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


def _step(words: str, bare: bool) -> Command | None:
    """A step's command. What follows a step may be a bare goal: "the sofa, then the lamp"."""
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
    if not goal:
        return None
    if every is not None:
        return All(goal)
    return WhereIs(goal) if asked is not None else GoTo((goal,))


def _mission(commands: list[Command | None]) -> Command | None:
    """Several steps as one command; None if they cannot be one."""
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
