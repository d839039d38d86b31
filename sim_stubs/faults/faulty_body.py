"""A simulated robot's body with faults: invisible obstacles, slipping wheels, kidnapping."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from nav.recovery import CLIFF_BEARINGS
from sim_stubs.faults.catalogue import FaultSchedule
from sim_stubs.world.body import Body, Contacts
from vizbot.core.geometry import invert, planar, transform
from vizbot.core.types import SE3

_RADIUS = 0.175
_CLIFF_SENSORS = 0.165 * np.array(
    [(math.cos(angle), math.sin(angle), 0.0) for angle in np.radians(CLIFF_BEARINGS)]
)
"""Positions of the cliff sensors (4, 3) in `base` [m]."""
_AHEAD = 0.03
"""Distance from the bumper at which panes and edges appear [m]."""
_HALF_WIDTH = 0.3
"""Half the width of a pane and of a square hole in the floor [m]."""
_BOTH_SIDES = 0.2
"""Bearing within which a contact presses both halves of the bumper [rad]."""
_CARRIED = 1.0
"""Least distance that the robot is carried, to where it has been before [m]."""
_TRAIL = 0.25
"""Distance between the remembered places of the path [m]."""
_ROLLS = 0.1
"""Speed above which a robot rolls ahead [m/s]."""
_SLIP = 1.4
"""Metres counted for each metre that is rolled."""


class FaultyBody:
    """A `Body` that touches things that are not in its world.

    Attributes:
        asked: Commanded speeds of the left and right wheel [m/s].
    """

    def __init__(
        self, body: Body, schedule: FaultSchedule, seed: int, place: Callable[[SE3], None]
    ) -> None:
        """Wrap a body."""
        self._body = body
        self._schedule = schedule
        self._place = place
        self._rng = np.random.default_rng((seed, 9))
        self._trail = [body.T_world_base[:2, 3].copy()]
        self._carried_at: float | None = None
        self._before = body.wheel_travel
        self._travel = np.array(body.wheel_travel)
        self._placed_at: dict[str, float] = {}
        self._Ts_world_ahead: dict[str, SE3] = {}
        self.asked = (0.0, 0.0)
        schedule.wait_for_rolling(lambda: sum(self.asked) / 2 > _ROLLS)

    @property
    def T_world_base(self) -> SE3:
        """True pose of the base."""
        return self._body.T_world_base

    @property
    def wheel_travel(self) -> tuple[float, float]:
        """Signed rim travel of the left and right wheel, as the encoders measure it [m]."""
        return float(self._travel[0]), float(self._travel[1])

    @property
    def stalls(self) -> bool:
        """Whether the left wheel is commanded to turn and cannot."""
        return self.asked[0] != 0.0 and self._schedule.active("stuck-wheel")

    @property
    def contacts(self) -> Contacts:
        """Contacts with the world and with things that are not in it."""
        felt = self._body.contacts
        touches = self._touched()
        left, front_left, front_right, right = (
            any(seen) for seen in zip(felt.cliffs, self._over_edge(), strict=True)
        )
        lifted = self._is_lifted
        return Contacts(
            felt.bump_left or (touches is not None and touches >= -_BOTH_SIDES),
            felt.bump_right or (touches is not None and touches <= _BOTH_SIDES),
            (left, front_left, front_right, right),
            (felt.wheel_drops[0] or lifted, felt.wheel_drops[1] or lifted),
        )

    def set_wheel_speeds(self, left: float, right: float) -> None:
        """Turn the wheels at these rim speeds [m/s] until the next command."""
        self.asked = left, right

    def advance(self, seconds: float) -> None:
        """Let `seconds` pass."""
        schedule = self._schedule
        self._place_what_appears()
        left, right = self.asked
        if schedule.active("stuck-wheel"):
            left = 0.0
        spins = 0.0
        if self._is_lifted:
            left = right = 0.0
            if schedule.active("kidnapped") and self._carried_at != schedule.began("kidnapped"):
                self._carried_at = schedule.began("kidnapped")
                self._Ts_world_ahead.clear()  # nobody puts it into a hole or through a pane
                self._place(self._somewhere())
        elif (touches := self._touched()) is not None and abs(touches) < math.pi / 2:
            spins = max(0.0, (left + right) / 2)  # against the glass
        self._body.set_wheel_speeds(left - spins, right - spins)
        self._body.advance(seconds)
        travel = self._body.wheel_travel
        rolled = np.subtract(travel, self._before)
        self._before = travel
        here = self._body.T_world_base[:2, 3]
        if np.linalg.norm(here - self._trail[-1]) > _TRAIL:
            self._trail.append(here.copy())
        self._travel += spins * seconds + rolled * (_SLIP if schedule.active("wheel-slip") else 1.0)

    @property
    def _is_lifted(self) -> bool:
        held = self._schedule.active("wheel-drop") or self._schedule.active("kidnapped")
        return held or self._schedule.second_half("lifted-unheard")

    def _somewhere(self) -> SE3:
        """A place where the robot has been before, with a random heading."""
        trail = np.array(self._trail)
        distances = np.linalg.norm(trail - self._body.T_world_base[:2, 3], axis=1)
        far = np.flatnonzero(distances >= min(_CARRIED, distances.max()))
        x, y = trail[self._rng.choice(far)]
        return planar(float(x), float(y), float(self._rng.uniform(-math.pi, math.pi)))

    def _place_what_appears(self) -> None:
        """Place a due pane or edge across the robot's path."""
        T_world_ahead = self._body.T_world_base @ planar(_RADIUS + _AHEAD, 0.0, 0.0)
        for name in ("bump", "cliff"):
            began = self._schedule.began(name)
            if began is not None and self._placed_at.get(name) != began:
                self._placed_at[name], self._Ts_world_ahead[name] = began, T_world_ahead

    def _touched(self) -> float | None:
        """Bearing of the pane where it touches the robot [rad]; None without contact."""
        T_world_pane = self._Ts_world_ahead.get("bump")
        if T_world_pane is None or not self._schedule.active("bump"):
            return None
        p_pane = self._in(T_world_pane, np.zeros((1, 3)))[0]
        nearest = np.array([[0.0, np.clip(p_pane[1], -_HALF_WIDTH, _HALF_WIDTH), 0.0]])
        T_base_pane = invert(self._body.T_world_base) @ T_world_pane
        x, y, _ = transform(T_base_pane, nearest)[0]
        return math.atan2(y, x) if math.hypot(x, y) <= _RADIUS else None

    def _over_edge(self) -> tuple[bool, bool, bool, bool]:
        """Which cliff sensors are over the hole."""
        T_world_edge = self._Ts_world_ahead.get("cliff")
        if T_world_edge is None or not self._schedule.active("cliff"):
            return False, False, False, False
        p_edge = self._in(T_world_edge, _CLIFF_SENSORS)
        ahead, aside = p_edge[:, 0], np.abs(p_edge[:, 1])
        beyond = (ahead > 0.0) & (ahead < 2 * _HALF_WIDTH) & (aside < _HALF_WIDTH)
        left, front_left, front_right, right = (bool(seen) for seen in beyond)
        return left, front_left, front_right, right

    def _in(self, T_world_frame: SE3, p_base: NDArray[np.float64]) -> NDArray[np.float64]:
        return transform(invert(T_world_frame) @ self._body.T_world_base, p_base)
