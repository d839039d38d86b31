"""Getting away from what was touched, and from where the camera shows nothing that is known."""

from __future__ import annotations

from math import radians

import numpy as np

from nav.config import RecoveryConfig
from nav.recovery import Recovery, contact_points, edge_points
from vizbot.core.geometry import wrap_angle, yaw_of
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, BaseState, PoseEstimate, Tracking
from vizbot.objectnav.looks import LookAround
from vizbot.objectnav.tasks import Decision
from vizbot.perception.interfaces import ObstacleMapper

_TURNED = radians(10.0)
"""Two headings that differ by this show different things [rad]."""
_TURNS = radians(2.0)
"""A robot that turned by more from one frame to the next is turning [rad]."""
_SAME_PLACE = 0.3
"""A robot that has moved farther than this did not turn on the spot [m]."""


class ContactRecovery:
    """Marks contacts and edges as obstacles, and backs off from them."""

    def __init__(self, config: RecoveryConfig, robot_radius: float, *, resume_safe: bool) -> None:
        """Begin away from everything; `resume_safe` lets it drive on after a stop at an edge."""
        self._config = config
        self._robot_radius = robot_radius
        self._resume_safe = resume_safe
        self._recovery = Recovery(config)
        self._touched = ""
        self._at_edge_since: float | None = None

    @property
    def at_edge(self) -> bool:
        """Whether the robot has not got away from an edge."""
        return self._at_edge_since is not None

    def observe_edge(self, state: BaseState, now: float) -> None:
        """Note an edge that the base reports at `now` [s]."""
        if any(state.cliffs) and self._at_edge_since is None:
            self._at_edge_since = now

    def forget_edge(self) -> None:
        """Forget the edge: somebody has lifted the robot off it."""
        self._at_edge_since = None

    def decide(
        self,
        state: BaseState,
        estimate: PoseEstimate,
        T_map_base: SE3,
        mapper: ObstacleMapper,
        now: float,
    ) -> Decision | None:
        """What to do at an edge, after a contact and while backing off; None otherwise.

        `mapper` takes the obstacles, unless the robot is lost at `now` [s].
        """
        obeys, twist = state.mode.obeys, self._recovery.twist(now)
        if any(state.cliffs) or state.blocked:
            if twist is None:
                if estimate.tracking is not Tracking.LOST:
                    self._mark_obstacles(state, T_map_base, mapper)
                self._touched = _touched(state)
                self._recovery.begin(now)
                twist = STOP
        elif twist is None and obeys:
            self._at_edge_since = None
        if self._at_edge_since is not None:
            if now - self._at_edge_since > self._config.edge_timeout:
                return _stop_at_edge("the robot does not get away from an edge; put it elsewhere")
            if not obeys:  # in Safe mode the base has stopped by itself
                if not self._resume_safe:
                    held = "the base stopped at an edge; put it elsewhere, or set resume_safe"
                    return _stop_at_edge(held)
                self._recovery.begin(now)
                twist = STOP
        if twist is None:
            return None
        cause = "an edge" if self.at_edge else self._touched
        return Decision(twist, f"backing off after {cause}")

    def _mark_obstacles(self, state: BaseState, T_map_base: SE3, mapper: ObstacleMapper) -> None:
        ahead = state.virtual_wall and not state.bumped
        left, right = state.bump_left or ahead, state.bump_right or ahead
        contacts = contact_points(left, right, self._robot_radius)
        mapper.mark_obstacle(T_map_base, contacts, touched=not ahead)
        mapper.mark_obstacle(T_map_base, edge_points(state.cliffs, self._robot_radius))


def _stop_at_edge(reason: str) -> Decision:
    return Decision(STOP, "stopped at an edge", ended=(Outcome.GAVE_UP, reason))


def _touched(state: BaseState) -> str:
    """What stops the robot; nothing is known to be in front of a stuck wheel."""
    if state.bumped:
        return "a bump"
    return "a virtual wall" if state.virtual_wall else "a stuck wheel"


class VisionRecovery:
    """Turns on the spot where nothing known is seen, once for each task, and then gives up."""

    def __init__(self, depth_patience: float, turn_rate: float) -> None:
        """Begin with a camera that sees.

        Without depth the robot stands for `depth_patience` [s], then turns at `turn_rate` [rad/s].
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

        Depth has shown nothing for `depth_lost_for` [s]; None while it shows something.
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

        A turn away from there has brought depth back, so something is right ahead there.
        """
        poses, self._turned_away_from = self._turned_away_from, []
        return poses

    def _onwards(self, T_map_base: SE3) -> LookAround:
        """A turn in the direction in which the robot has just turned.

        Otherwise the behaviour that has turned it would undo the turn.
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
