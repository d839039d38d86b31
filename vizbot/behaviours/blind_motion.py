"""The budget of motion that nobody asked for and no sensor watches: the base feels nothing behind.

Every twist that the program decides passes through it, whichever behaviour wants it. A person who
drives by hand looks where the robot goes, and is not limited.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from nav.config import UNDOCKING_TIME
from vizbot.core.geometry import invert
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, BaseState, Twist
from vizbot.objectnav.tasks import Decision

FARTHEST, LONGEST = 0.3, 5.0
"""Way [m] and time [s] that the robot may drive backwards in all."""
RETURNED = 0.15
"""Distance ahead without a contact after which it may drive backwards again [m]."""
DOCK_MARGIN = 0.1
"""Distance beyond the usual one that the robot may drive to leave its dock [m]."""
_LEAST = 0.005
"""Distance that is too short to be worth driving [m]."""
_LATE = 0.02
"""Time that the base takes to stop once a command has held for its longest [s]."""


@dataclass(slots=True)
class _Budget:
    """Limits of driving backwards, and what was used of them.

    Attributes:
        farthest: Way backwards by the wheel counts [m].
        longest: Time of driving backwards [s].
        way: Distance used so far [m].
        seconds: Time used so far [s].
    """

    farthest: float
    longest: float
    way: float = 0.0
    seconds: float = 0.0


class BlindMotion:
    """Counts distance and time driven backwards, and lets no more pass than is left.

    The way off the dock has a budget of its own, since it begins where the dock was before.
    """

    def __init__(self, undocking: float, hold: float) -> None:
        """Begin with nothing spent.

        Args:
            undocking: Way off the dock [m].
            hold: Longest time for which the base holds a command [s].
        """
        self._hold = hold + _LATE
        self._common = _Budget(FARTHEST, LONGEST)
        self._off_dock = _Budget(undocking + DOCK_MARGIN, UNDOCKING_TIME)
        self._drawn = self._common
        self._backing_since: float | None = None
        self._ahead = 0.0
        self._T_odom_base: SE3 | None = None

    def observe(self, state: BaseState, now: float, *, by_hand: bool) -> None:
        """Account for the motion since the last call.

        Where a person drove `by_hand`, or nobody drove, only motion ahead counts up to `now` [s].
        """
        before, self._T_odom_base = self._T_odom_base, state.T_odom_base
        if self._backing_since is not None:
            self._drawn.seconds += min(now - self._backing_since, self._hold)
            self._backing_since = None
        if before is None:
            return
        ahead = float((invert(before) @ state.T_odom_base)[0, 3])
        if ahead < 0.0 and not by_hand:
            self._drawn.way -= ahead
        touches = state.blocked or any(state.cliffs)
        self._ahead = 0.0 if touches else max(0.0, self._ahead + ahead)
        if self._ahead >= RETURNED:
            self._ahead = 0.0
            for budget in (self._common, self._off_dock):
                budget.way = budget.seconds = 0.0

    def permit(self, decision: Decision, now: float) -> Decision:
        """The decision, as far as the budget lets it drive backwards; at rest where it is spent."""
        twist = decision.twist
        if twist.linear >= 0.0:
            return decision
        budget = self._drawn = self._off_dock if decision.leaves_dock else self._common
        left = budget.farthest - budget.way
        if left < _LEAST or budget.seconds + self._hold > budget.longest:
            return Decision(STOP, "stopped, backed off enough", ended=_spent(decision, budget))
        self._backing_since = now
        slower = min(1.0, left / self._hold / -twist.linear)
        return replace(decision, twist=Twist(slower * twist.linear, slower * twist.angular))


def _spent(decision: Decision, budget: _Budget) -> tuple[Outcome, str]:
    done = f"{decision.activity} has not helped: {budget.way:.1f} m in {budget.seconds:.0f} s"
    place = "off its dock" if decision.leaves_dock else "where its way ahead is free"
    return Outcome.GAVE_UP, f"{done}, and the robot sees nothing behind it; put it {place}"
