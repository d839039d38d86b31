"""A base in a mode in which it does not drive."""

from __future__ import annotations

from vizbot.core.observer import OpenQuestion, Outcome
from vizbot.core.types import STOP, BaseState
from vizbot.objectnav.tasks import Decision

MAYBE_MOVED = OpenQuestion(
    "somebody may have moved me: go on?",
    "somebody may have moved the robot while its base was not heard; look at it and start again,"
    " or set resume_safe in [roomba]",
)


def ask_whether_moved(state: BaseState) -> Decision | None:
    """What to do with a base that somebody may have moved unheard; None with any other.

    Its pose counts for nothing: once somebody says to go on, the robot finds its place first.
    """
    if not state.maybe_moved:
        return None
    return Decision(STOP, MAYBE_MOVED.text, question=MAYBE_MOVED, idle=True)


class BaseModeMonitor:
    """Waits a while for the base to obey again."""

    def __init__(self, patience: float) -> None:
        """Wait for up to `patience` [s]."""
        self._patience = patience
        self._passive_since: float | None = None

    def decide(self, state: BaseState, now: float, *, at_edge: bool) -> Decision | None:
        """What to do while the base does not obey; None while it does.

        Args:
            state: What the base reports.
            now: Time [s].
            at_edge: Whether an edge explains it: there a base in Safe mode stops by itself.
        """
        if state.mode.obeys:
            self._passive_since = None
            return None
        if self._passive_since is None:
            self._passive_since = now
        if at_edge:
            return None
        if now - self._passive_since < self._patience:
            return Decision(STOP, "waiting for the base to obey")
        reason = f"the base is in {state.mode.name} mode and does not drive; launch again"
        return Decision(STOP, "the base does not drive", ended=(Outcome.GAVE_UP, reason))
