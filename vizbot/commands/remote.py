"""`vizbot goal`, `say`, `explore`, `stop` and `status`: talk to a running robot."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from typing import Any

from vizbot.commands.sentences import one_sentence, require_text
from vizbot.core.observer import Outcome
from vizbot.core.types import Tracking
from vizbot.operator.client.robot_client import RobotClient, answer_lines
from vizbot.operator.client.stop import whoami
from vizbot.operator.language.command import Explore, Stop
from vizbot.operator.language.command_grammar import require_length
from vizbot.operator.language.language import ENGLISH, Language, languages, load_language
from vizbot.operator.printing import echo

_EVERY = 0.5
"""Time between two requests for the state while an outcome is waited for [s]."""
_GOOD = (Outcome.ARRIVED, Outcome.EXPLORED)


def ask(
    client: RobotClient,
    texts: Sequence[str],
    at_once: bool,
    wait: bool,
    language: Language = ENGLISH,
) -> bool:
    """Have the robot do what sentences ask for, and print what it answers.

    Several `texts` are one mission in `language`, in this order; `at_once`: what is running gives
    way.

    Returns:
        Whether the robot has asked nothing back, and all goals were reached where somebody waits.

    Raises:
        VizbotError: a text is empty, the texts do not go together, or the robot does not answer or
            refuses.
    """
    for text in texts:
        require_text(text)
    if any(map(is_stop, texts)):
        stop(client)
        return True
    sentence = texts[0] if len(texts) == 1 else one_sentence(texts, language)
    require_length(sentence)
    at_once = at_once or any(map(language.grammar.is_urgent, texts))
    reply = client.say(sentence, whoami(), at_once=at_once)
    for line in answer_lines(reply):
        echo(line)
    if reply.get("question") is not None:
        return False
    return _accepted(client, reply["numbers"], wait)


def is_stop(text: str) -> bool:
    """Whether a sentence of any language is a stop, which needs no token."""
    grammars = [load_language(code).grammar for code in languages()]
    if any(grammar.is_stop(text) for grammar in grammars):
        return True
    return any(isinstance(grammar.typed(text), Stop) for grammar in grammars)


def explore(client: RobotClient, at_once: bool, wait: bool) -> bool:
    """Ask for an exploration; whether nothing is left to see, True where nobody waits.

    Raises:
        DeviceError: the robot does not answer or refuses.
    """
    number = client.explore(at_once=at_once)
    echo(ENGLISH.say("asked", text=ENGLISH.grammar.text(Explore(), at_once)))
    return _accepted(client, [number], wait)


def stop(client: RobotClient) -> None:
    """Stop the robot now.

    Raises:
        DeviceError: the robot does not answer.
    """
    client.stop(whoami())
    echo("stopped")


def status(client: RobotClient, as_json: bool) -> None:
    """Print the state of the robot.

    Raises:
        DeviceError: the robot does not answer.
    """
    state = client.state()
    if as_json:
        echo(json.dumps(state))
        return
    echo("stopped" if state["stopped"] else _doing(state))
    if state["wheel"] is not None:
        echo(f"driven by hand by {state['wheel']}")
    echo(_whereabouts(state))
    base = state["base"]
    if base is not None:
        battery = "unknown" if base["battery"] is None else f"{100 * base['battery']:.0f} %"
        touches = ", ".join(base["feels"]) or "nothing"
        echo(f"battery {battery}, {base['mode']} mode, feels {touches}")
    rests = state["stopped"] or state["wheel"] is not None
    to_do = [goal["number"] for goal in state["goals"] if goal["outcome"] is None]
    for goal in state["goals"]:
        runs = goal["number"] in to_do[:1] and not rests
        echo(f"{goal['number']:3d} {_outcome(goal, 'running' if runs else 'waiting')}")
    if state["run"] is not None:
        echo(f"run {state['run']}")


def _doing(state: Mapping[str, Any]) -> str:
    """What the robot does, and why where that needs saying."""
    why = state.get("why")
    return f"{state['activity']}: {why}" if why else str(state["activity"])


def _whereabouts(state: Mapping[str, Any]) -> str:
    """x, y of the robot in `map` [m]."""
    if state.get("position") is None or state.get("tracking") == Tracking.LOST:
        return "where it is, is not known"
    x, y = state["position"]
    return f"at {x:.2f}, {y:.2f} m"


def _accepted(client: RobotClient, numbers: Sequence[int], wait: bool) -> bool:
    """Print how many tasks come before those that were accepted; then wait where that is asked for.

    Returns:
        Whether all outcomes are good; True where nobody waits.
    """
    if not numbers:
        return True
    to_do = [goal["number"] for goal in client.state()["goals"] if goal["outcome"] is None]
    before = to_do.index(numbers[0]) if numbers[0] in to_do else 0
    if before:
        echo("1 other task comes before" if before == 1 else f"{before} other tasks come before")
    return _wait_for(client, numbers) if wait else True


def _wait_for(client: RobotClient, numbers: Sequence[int]) -> bool:
    """Print each outcome as it comes; return whether all are good."""
    waiting, good = list(numbers), True
    while waiting:
        goals = {goal["number"]: goal for goal in client.state()["goals"]}
        while waiting:
            goal = goals.get(waiting[0], {"text": waiting[0], "outcome": "forgotten"})
            if goal["outcome"] is None:
                break
            echo(_outcome(goal))
            good &= goal["outcome"] in _GOOD
            del waiting[0]
        time.sleep(_EVERY if waiting else 0.0)
    return good


def _outcome(goal: Mapping[str, Any], before_its_end: str = "") -> str:
    """How a task ended, and x, y in `map` [m] of where that was or its goal was found.

    For a task that has not ended, `before_its_end` is the outcome.
    """
    if goal["outcome"] is None:
        return f"{goal['text']}: {before_its_end}"
    if (headline := goal.get("headline")) is None:  # no search
        outcome = f"{goal['text']}: {goal['outcome']} ({goal.get('reason', '')})"
    else:
        outcome = f"{headline}: {goal['reason']}"
    if (position := goal.get("position")) is None:
        return outcome
    return f"{outcome} at {position[0]:.2f}, {position[1]:.2f} m"
