"""The guard on progress, above all behaviours: it ends what brings no progress.

Each behaviour ends by itself, but two that undo each other may go on for ever, as one that turns
the robot away from a wall and one that turns it back. So the guard measures progress over all of
them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import degrees

import numpy as np
from numpy.typing import NDArray

from nav.frontier import FrontierSearch
from vizbot.core.geometry import yaw_of
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP
from vizbot.objectnav import reasons
from vizbot.objectnav.looks import APART
from vizbot.objectnav.tasks import Decision, Errand, Goal, ShortMove
from vizbot.perception.interfaces import ObstacleMapper

PATIENCE = 15.0
"""Time of motion and waiting within which there must be progress [s]."""
CLOSER = 0.3
"""The way left to an aim must be shorter by this than ever before to be progress [m]."""
AREA = 0.1
"""Area of floor that must be newly seen to be progress [m^2]."""
HELD = 60.0
"""An aim that was not held for this time counts as new [s]."""
BARRED = 60.0
"""A dropped aim is left alone for this time [s]."""
MOST = 3
"""Number of dropped aims that ends the task."""
REASON = (
    f"in {MOST} times {PATIENCE:.0f} s of trying the robot came no nearer to anything, saw nothing"
    " new and found nothing else to go to"
)
"""Reason that the task then ends with."""

_NEW_AGAIN = 2
"""Number of times that one aim may be new again, so that no round of aims goes on for ever."""
_DETOUR = 1.0
"""A way left that is suddenly longer by this is another way: the map has closed the old one [m]."""
_MOST_DETOURS = 2
_MOST_BLINDED = 2
"""Number of times that the camera may show nothing on the way to a frontier."""
_LONGEST_PERIOD = 1.0
"""Longest time between two frames that counts: the robot is not to blame for the rest [s]."""
_PLACE = 0.5
"""Turns in cells of this size are turns on one spot [m]."""
_HERE = 0.3
"""Points within this distance of an aim that is left alone belong to it; others begin at 0.5
[m]."""
_SECTOR = 30.0
"""Turn on a spot after which it shows another side [degrees]."""


@dataclass(slots=True, eq=False)
class _HeldAim:
    """An aim that the robot has held, and how near it came.

    Attributes:
        exploring: Whether the aim is a frontier.
        xy: (2,) in `map` [m].
        closest: Least way left so far [m].
        way_left: The newest way left [m].
        held_at: When the aim was held last [s].
        new_again: How often the aim was new again.
        detours: How often the way to it was replaced by a longer one.
        barred_until: Until when the aim is left alone [s].
        blinded: How often the camera showed nothing on the way to it.
    """

    exploring: bool
    xy: NDArray[np.float64]
    closest: float
    way_left: float
    held_at: float
    new_again: int = 0
    detours: int = 0
    barred_until: float = -np.inf
    blinded: int = 0


@dataclass(slots=True, eq=False)
class _Account:
    """The progress of one task so far."""

    task: Errand
    aims: list[_HeldAim] = field(default_factory=list)
    newest: _HeldAim | None = None
    area: float | None = None
    sides: set[tuple[int, int, int]] = field(default_factory=set)
    in_vain: float = 0.0
    dropped: int = 0


class ProgressGuard:
    """Drops an aim that brings no progress, and ends a task in which that happens again."""

    def __init__(self) -> None:
        self._account: _Account | None = None
        self._seen_at: float | None = None

    def rest(self) -> None:
        """Note that a person drives, or nobody: the time until the next frame does not count."""
        self._seen_at = None

    def close(self) -> None:
        """Note that the task is over: the same one may be asked for again."""
        self.rest()
        self._account = None

    def elapse(self, now: float) -> None:
        """Count the time of a frame, at `now` [s], in which the robot drives or waits."""
        if self._seen_at is not None and self._account is not None:
            self._account.in_vain += min(now - self._seen_at, _LONGEST_PERIOD)
        self._seen_at = now

    def barred(self, now: float, *, exploring: bool) -> NDArray[np.float64]:
        """Frontiers, or places, (B, 2) in `map` [m] that are left alone at `now` [s]."""
        aims = [] if self._account is None else self._account.aims
        left_alone = [a.xy for a in aims if a.exploring == exploring and a.barred_until > now]
        return np.array(left_alone).reshape(-1, 2)

    def blinding_frontier(self) -> NDArray[np.float64] | None:
        """The frontier (2,) aimed at, after the robot was blind on its way to it once more.

        Call it whenever the camera shows something again after it showed nothing.
        """
        aim = None if self._account is None else self._account.newest
        if aim is None or not aim.exploring:
            return None
        aim.blinded += 1
        return aim.xy if aim.blinded >= _MOST_BLINDED else None

    def instead_of(
        self,
        decision: Decision,
        task: Errand,
        aim_xy: NDArray[np.float64] | None,
        T_map_base: SE3,
        area: float,
        now: float,
    ) -> Decision:
        """The decision of a step, or another one where such decisions bring no progress.

        The robot is on its way to `aim_xy` (2,) in `map` [m], None without a path; it has seen
        `area` [m^2] of floor at `now` [s].
        """
        if self._account is None or self._account.task is not task:
            self._account = _Account(task)
        account = self._account
        if decision.idle:
            self.rest()
            return decision
        self.elapse(now)
        if decision.ended is not None:
            return self._ended(account, decision, now)
        progress = [
            _is_more(account, area),
            _turns_to_another_side(account, decision, T_map_base),
            _comes_nearer(account, decision, aim_xy, now),
        ]
        if any(progress):
            account.in_vain = 0.0
        if account.in_vain < PATIENCE:
            return decision
        account.in_vain = 0.0
        account.dropped += 1
        if account.dropped >= (1 if isinstance(task, ShortMove) else MOST):
            outcome = Outcome.STUCK if isinstance(task, Goal) else Outcome.GAVE_UP
            reason = "the robot does not move" if isinstance(task, ShortMove) else REASON
            self.close()
            return Decision(STOP, "stopped, nothing comes of it", ended=(outcome, reason))
        if account.newest is not None:
            account.newest.barred_until = now + BARRED
        if decision.navigation is None:  # a behaviour that must go on until it is over
            return decision
        why = reasons.NOTHING_COMES_OF_IT
        return Decision(STOP, "leaving it alone", threshold=decision.threshold, why=why)

    def _ended(self, account: _Account, decision: Decision, now: float) -> Decision:
        """The end of a task; where it would end in vain, aims left alone are tried again first."""
        assert decision.ended is not None
        barred = [aim for aim in account.aims if aim.barred_until > now]
        if decision.ended[0] not in IN_VAIN or not barred:
            self.close()
            return decision
        for aim in barred:
            aim.barred_until = -np.inf
        why = reasons.OTHERS_TRIED
        return Decision(STOP, "trying again", threshold=decision.threshold, why=why)


def _is_more(account: _Account, area: float) -> bool:
    """Whether enough floor was newly seen."""
    if account.area is not None and area < account.area + AREA:
        return False
    account.area = area
    return True


def _turns_to_another_side(account: _Account, decision: Decision, T_map_base: SE3) -> bool:
    """Whether a turn on the spot shows a side that the robot has not turned to from there."""
    if decision.twist.linear != 0.0 or decision.twist.angular == 0.0:
        return False
    x, y = np.round(T_map_base[:2, 3] / _PLACE).astype(int).tolist()
    side = x, y, int(degrees(yaw_of(T_map_base)) // _SECTOR)
    is_new = side not in account.sides
    account.sides.add(side)
    return is_new


def _comes_nearer(
    account: _Account, decision: Decision, aim_xy: NDArray[np.float64] | None, now: float
) -> bool:
    """Whether the aim is a new one, or less way is left to it than ever."""
    way_left, xy = decision.way_left, np.zeros(2) if aim_xy is None else aim_xy
    if decision.navigation is not None:
        way_left = decision.navigation.distance
    if way_left is None:
        return False
    aim = _same(account.aims, xy, now, exploring=decision.exploring)
    account.newest = aim
    if aim is None:
        account.newest = _HeldAim(decision.exploring, xy, way_left, way_left, now)
        account.aims.append(account.newest)
        return True
    is_new = now - aim.held_at > HELD and aim.new_again < _NEW_AGAIN
    aim.new_again += is_new
    if way_left > aim.way_left + _DETOUR and aim.detours < _MOST_DETOURS:
        aim.closest = way_left
        aim.detours += 1
    aim.xy, aim.way_left, aim.held_at = xy, way_left, now
    is_nearer = way_left <= aim.closest - CLOSER
    if is_nearer:
        aim.closest = way_left
    return is_new or is_nearer


def _same(
    aims: list[_HeldAim], xy: NDArray[np.float64], now: float, *, exploring: bool
) -> _HeldAim | None:
    """The aim of this kind that is nearest to a point, if it is the same as far as one knows.

    One that is left alone now is so only if the robot is on its way to that very place, as tasks
    are that heed no bar: what is left out must not move to what is gone to instead.
    """
    alike = [aim for aim in aims if aim.exploring == exploring]
    beyond = [
        float(np.linalg.norm(aim.xy - xy)) - (_HERE if aim.barred_until > now else APART)
        for aim in alike
    ]
    return alike[int(np.argmin(beyond))] if beyond and min(beyond) <= 0.0 else None


IN_VAIN = (Outcome.NOT_FOUND, Outcome.EXPLORED)


class SecondTry:
    """Forgets what the bumper touched where a task would otherwise end in vain, once a task.

    A person, a pet or a door that has moved since would close the room behind it for good, since no
    camera need have seen it. Edges and virtual walls stay.
    """

    def __init__(self) -> None:
        self._tried: Errand | None = None

    def instead_of(
        self, decision: Decision, task: Errand, mapper: ObstacleMapper, frontiers: FrontierSearch
    ) -> Decision:
        """The decision, or a step that lets the task go on where the decision would end it in vain.

        `mapper` knows what was touched; `frontiers` that were given up because of it are open
        again.
        """
        if decision.ended is None or decision.ended[0] not in IN_VAIN:
            return decision
        again = task is not self._tried and mapper.forget_touched()
        self._tried = task if again else None
        if not again:
            return decision
        frontiers.reopen()
        return Decision(STOP, "trying again", why=reasons.MAY_BE_GONE)
