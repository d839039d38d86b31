"""Backing off from what the robot has touched, and from edges."""

from __future__ import annotations

from nav.config import RecoveryConfig
from nav.recovery import Recovery, contact_points, edge_points
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, STOP, BaseState, PoseEstimate, Tracking
from vizbot.objectnav.tasks import Decision
from vizbot.perception.interfaces import ObstacleMapper


class ContactRecovery:
    """Marks contacts and edges as obstacles, and backs off from them."""

    def __init__(self, config: RecoveryConfig, robot_radius: float, *, resume_safe: bool) -> None:
        """Begin away from everything.

        Args:
            config: Distances and times.
            robot_radius: Of the robot [m].
            resume_safe: Whether the robot may drive on by itself where the base has stopped at an
                edge.
        """
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

        Args:
            state: What the base reports.
            estimate: Where the camera is.
            T_map_base: Where the robot is.
            mapper: Takes the obstacles, unless the robot is lost.
            now: Time [s].
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
