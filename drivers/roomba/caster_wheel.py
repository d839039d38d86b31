"""The caster wheel at the front of the base, and whether it rolls (manual, page 38)."""

from __future__ import annotations

import logging

from vizbot.core.types import BaseState

logger = logging.getLogger(__name__)

_STANDSTILL = 1.0
"""Time that it must stand still, while the driven wheels roll straight ahead, for a warning [s]."""


class CasterWheel:
    """Warns, once until it rolls again, when the caster stands still although the base drives."""

    def __init__(self, name: str) -> None:
        """`name` of the port, for the message."""
        self._name = name
        self._still_since: float | None = None
        self._warned = False

    def observe(self, state: BaseState, *, ahead: bool) -> None:
        """Update; `ahead`: the driven wheels are commanded to roll straight ahead, and do."""
        if state.rolls:
            self._warned = False
        if not ahead or state.blocked or state.rolls is not False:
            self._still_since = None
        elif self._still_since is None:
            self._still_since = state.stamp
        elif state.stamp - self._still_since > _STANDSTILL and not self._warned:
            self._warned = True
            logger.warning(
                "%s: the wheels roll ahead and the front wheel does not: they slip, or it is stuck "
                "or missing; look under the robot, clean the front wheel",
                self._name,
            )
