"""The free wheel at the front of the base, which feels whether it makes way (manual, page 38)."""

from __future__ import annotations

import logging

from vizbot.core.types import BaseState

logger = logging.getLogger(__name__)

_PATIENCE = 1.0
"""It must have stood still for so long while the driven wheels rolled straight ahead [s]."""


class CasterWheel:
    """Tells once when it stands still though the base should make way, until it rolls again."""

    def __init__(self, name: str) -> None:
        """`name` of the port, for the message."""
        self._name = name
        self._still_since: float | None = None
        self._told = False

    def observe(self, state: BaseState, *, ahead: bool) -> None:
        """Take in what it feels.

        Args:
            state: Of the base.
            ahead: Whether the driven wheels are told to roll straight ahead, and do.
        """
        if state.rolls:
            self._told = False
        if not ahead or state.blocked or state.rolls is not False:
            self._still_since = None
        elif self._still_since is None:
            self._still_since = state.stamp
        elif state.stamp - self._still_since > _PATIENCE and not self._told:
            self._told = True
            logger.warning(
                "%s: the wheels roll ahead and the front wheel does not: they slip, or it is stuck "
                "or missing; look under the robot, clean the front wheel",
                self._name,
            )
