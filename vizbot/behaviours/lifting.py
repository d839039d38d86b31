"""A robot that somebody has lifted."""

from __future__ import annotations

from vizbot.core.observer import Outcome
from vizbot.core.types import STOP, BaseState
from vizbot.objectnav.tasks import Decision


class Lifting:
    """Stops a lifted robot, for good or until it is put down."""

    def __init__(self, patience: float, *, resume_safe: bool) -> None:
        """Begin on the floor.

        Args:
            patience: How long the robot waits to be put down [s].
            resume_safe: Whether it may drive on by itself then.
        """
        self._patience = patience
        self._resume_safe = resume_safe
        self._since: float | None = None

    @property
    def lifted(self) -> bool:
        """Whether it was lifted and has not obeyed since."""
        return self._since is not None

    def decide(self, state: BaseState, now: float) -> Decision | None:
        """What to do while a wheel hangs and until the base obeys again; None on the floor."""
        hangs = any(state.wheel_drops)
        if hangs and self._since is None:
            self._since = now
        if not hangs and state.mode.obeys:
            self._since = None
        if self._since is None or not (hangs or self._resume_safe):
            return None
        if self._resume_safe and now - self._since < self._patience:
            return Decision(STOP, "waiting to be put down", idle=True)
        reason = "a wheel hangs; put the robot on the floor"
        if not hangs:
            reason = "the base does not obey since it was lifted; press Clean and launch again"
        return Decision(STOP, "stopped, lifted", ended=(Outcome.GAVE_UP, reason))
