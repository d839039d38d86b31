"""The dock of the simulated Roomba: its beams, its contacts, and how the base drives onto it.

Frame of the dock: x out of its front, z up. A robot that docks faces it and sees the green beam on
its left and the red one on its right (manual, page 25). Obstacles do not block the beams.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from drivers.roomba.packets import DockBeam
from vizbot.core.geometry import invert, wrap_angle, yaw_of
from vizbot.core.types import SE3

_RANGE = 2.5
"""Range of the beams [m]."""
_BEAM, _OVERLAP = math.radians(30.0), math.radians(5.0)
"""Angles of each beam to its side, and across the middle."""
_FIELD = 0.6
"""Range of the force field [m]."""
_SIDE_VIEW = math.radians(10.0), math.radians(80.0)
"""Angles of the left receiver to the right and to the left; the right one is mirrored."""
_CONTACT = 0.19
"""Distance of the dock's front from the middle of a docked robot [m]."""
_NARROW, _STRAIGHT = 0.03, math.radians(10.0)
_SPIN, _CREEP = 60.0, 100.0
"""Speeds of the wheels while the base seeks the dock [mm/s]."""
_FIRST = 160
"""First character of the dock of the 600 series, without any beam."""


class SensedDock(Protocol):
    """What a base senses of a dock, as of `SimulatedDock`."""

    def infrared(self, T_world_base: SE3) -> tuple[int, int, int]:
        """Characters at the robot's omnidirectional, left and right receivers."""
        ...

    def touches(self, T_world_base: SE3) -> bool:
        """Whether the robot stands on the charging contacts."""
        ...

    def seek_speeds(self, T_world_base: SE3) -> tuple[float, float]:
        """Left, right wheel speed [mm/s] of a base that seeks the dock."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedDock:
    """A dock with power.

    Attributes:
        T_world_dock: Pose of its front.
    """

    T_world_dock: SE3

    def infrared(self, T_world_base: SE3) -> tuple[int, int, int]:
        """Characters at the robot's omnidirectional, left and right receivers."""
        place, bearing = self._seen_from(T_world_base)
        beams = self._beams(place)
        character = 0 if not beams else _FIRST + int(beams)
        behind, ahead = _SIDE_VIEW
        left, right = -behind < bearing < ahead, -ahead < bearing < behind
        return character, character if left else 0, character if right else 0

    def touches(self, T_world_base: SE3) -> bool:
        """Whether the robot stands on the charging contacts."""
        place, bearing = self._seen_from(T_world_base)
        near = 0.0 < place[0] < _CONTACT and abs(place[1]) < _NARROW
        return bool(near and abs(bearing) < _STRAIGHT)

    def seek_speeds(self, T_world_base: SE3) -> tuple[float, float]:
        """Left, right wheel speed [mm/s] of a base that seeks the dock."""
        if self.touches(T_world_base):
            return 0.0, 0.0
        x, y = self._seen_from(T_world_base)[0]
        if not self.infrared(T_world_base)[0]:
            return -_SPIN, _SPIN
        aim = np.array([min(max(0.5 * x, x - 0.3), x), 0.0]) if abs(y) > 0.01 else np.zeros(2)
        towards = math.atan2(aim[1] - y, aim[0] - x)
        off = wrap_angle(towards - yaw_of(invert(self.T_world_dock) @ T_world_base))
        if abs(off) > 0.3:
            return (-_SPIN, _SPIN) if off > 0 else (_SPIN, -_SPIN)
        return _CREEP * (1 - off), _CREEP * (1 + off)

    def _seen_from(self, T_world_base: SE3) -> tuple[tuple[float, float], float]:
        """The robot's x, y in the dock's frame [m], and the dock's bearing from the robot [rad]."""
        T_dock_base = invert(self.T_world_dock) @ T_world_base
        x, y = float(T_dock_base[0, 3]), float(T_dock_base[1, 3])
        return (x, y), wrap_angle(math.atan2(-y, -x) - yaw_of(T_dock_base))

    def _beams(self, place: tuple[float, float]) -> DockBeam:
        x, y = place
        away, aside = math.hypot(x, y), math.atan2(y, x)
        beams = DockBeam(0)
        if x <= 0.0 or away > _RANGE:
            return beams
        if away < _FIELD:
            beams |= DockBeam.FORCE_FIELD
        if -_BEAM < aside < _OVERLAP:
            beams |= DockBeam.GREEN
        if -_OVERLAP < aside < _BEAM:
            beams |= DockBeam.RED
        return beams
