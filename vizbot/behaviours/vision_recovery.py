"""What the robot does while its camera shows no depth, or nothing that it recognises."""

from __future__ import annotations

from math import radians

import numpy as np

from nav.look_around import LookAround
from vizbot.core.geometry import wrap_angle, yaw_of
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, Tracking
from vizbot.objectnav.tasks import Decision

_TURNED = radians(10.0)
"""From so far apart two headings show different things [rad]."""
_TURNS = radians(2.0)
"""A robot that turned by more from one frame to the next is turning [rad]."""
_SAME_PLACE = 0.3
"""Farther away the robot was driven or carried, and did not turn on the spot [m]."""


class VisionRecovery:
    """Turns once on the spot for each task, and gives up if that does not help."""

    def __init__(self, depth_patience: float, turn_rate: float) -> None:
        """Begin with a camera that sees.

        Args:
            depth_patience: How long the robot stands still without depth before it turns [s].
            turn_rate: Angular velocity of the turns [rad/s].
        """
        self._depth_patience = depth_patience
        self._turn_rate = turn_rate
        self._turn_for_depth: LookAround | None = None
        self._turn_when_lost = LookAround(turn_rate)
        self._yaw: float | None = None
        self._without_depth: list[SE3] = []
        self._turned_away_from: list[SE3] = []

    def decide(
        self, depth_lost_for: float | None, tracking: Tracking, T_map_base: SE3
    ) -> Decision | None:
        """What to do without depth or when lost; None while the robot sees where it is.

        Args:
            depth_lost_for: How long depth has shown nothing [s]; None while it shows something.
            tracking: How far the pose can be trusted.
            T_map_base: Where the robot is.
        """
        if depth_lost_for is not None:
            return self._wait_for_depth(depth_lost_for, T_map_base)
        if self._without_depth and tracking is not Tracking.LOST:
            if _turned_on_spot(self._without_depth[0], T_map_base):
                self._turned_away_from += self._without_depth
            self._without_depth = []
        self._turn_for_depth, self._yaw = None, yaw_of(T_map_base)
        if tracking is Tracking.LOST:
            return self._turn_to_recognise(T_map_base)
        self._turn_when_lost = LookAround(self._turn_rate)
        return None

    def turned_away_from(self) -> list[SE3]:
        """Where the camera showed nothing although it works, each pose once.

        A turn away from there has brought depth back: something is right ahead there.
        """
        poses, self._turned_away_from = self._turned_away_from, []
        return poses

    def _onwards(self, T_map_base: SE3) -> LookAround:
        """A turn in the direction in which the robot has just turned.

        A turn back would be undone by what has turned it.
        """
        turned = 0.0 if self._yaw is None else wrap_angle(yaw_of(T_map_base) - self._yaw)
        return LookAround(-self._turn_rate if turned < -_TURNS else self._turn_rate)

    def _wait_for_depth(self, depth_lost_for: float, T_map_base: SE3) -> Decision:
        """Stand still at first; what hides everything may be right in front of the camera."""
        if self._turn_for_depth is None:
            self._turn_for_depth = self._onwards(T_map_base)
        if not self._without_depth or _turned_on_spot(self._without_depth[-1], T_map_base):
            self._without_depth.append(T_map_base)
        if depth_lost_for < self._depth_patience:
            return Decision(STOP, "blind, standing still")
        if (turn := self._turn_for_depth.twist(T_map_base)) is not None:
            return Decision(turn, "blind, looking around")
        reason = "depth shows nothing; clean the camera, see vizbot doctor"
        return Decision(STOP, "stopped, blind", ended=(Outcome.GAVE_UP, reason))

    def _turn_to_recognise(self, T_map_base: SE3) -> Decision:
        if (turn := self._turn_when_lost.twist(T_map_base)) is not None:
            return Decision(turn, "lost, looking around")
        self._turn_when_lost = LookAround(self._turn_rate)
        reason = "the robot recognises nothing around it; put it where it has been"
        return Decision(STOP, "lost, standing still", ended=(Outcome.GAVE_UP, reason))


def _turned_on_spot(T_map_before: SE3, T_map_base: SE3) -> bool:
    """Whether the robot looks elsewhere than before from the same place."""
    away = float(np.linalg.norm(T_map_base[:2, 3] - T_map_before[:2, 3]))
    turned = abs(wrap_angle(yaw_of(T_map_base) - yaw_of(T_map_before)))
    return away < _SAME_PLACE and turned > _TURNED
