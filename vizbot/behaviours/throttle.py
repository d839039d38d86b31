"""Changes of twist, held back to what the base's acceleration allows."""

from __future__ import annotations

from nav.follower import FollowerConfig, accelerate
from vizbot.core.interfaces import Base
from vizbot.core.types import STOP, Twist


class Throttle:
    """Remembers what was told last."""

    def __init__(self, config: FollowerConfig, longest: float) -> None:
        """The base is at rest.

        Args:
            config: Accelerations.
            longest: After so long without a command a base has stopped by itself [s].
        """
        self._config = config
        self._longest = longest
        self._twist = STOP
        self._at = 0.0

    def since(self, stamp: float) -> float:
        """Time from the last command to `stamp` [s]."""
        return stamp - self._at

    def drive(self, base: Base | None, twist: Twist, stamp: float) -> Twist:
        """Drive as much of a change of twist as the time since the last command allows.

        Without a base it is only computed.
        """
        period = min(max(self.since(stamp), 0.0), self._longest)
        self._twist, self._at = accelerate(twist, self._twist, period, self._config), stamp
        if base is not None:
            base.drive(self._twist)
        return self._twist

    def let_go(self) -> None:
        """Somebody else drives, or nobody does: when it is our turn again the base is at rest."""
        self._twist = STOP
