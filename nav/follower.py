"""Path follower: pure pursuit, with a turn in place where the path leads elsewhere.

The base holds a twist until the next one, up to 0.29 s, so every speed is bounded by the motion
within that time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nav.config import FollowerConfig
from vizbot.core.geometry import wrap_angle, yaw_of
from vizbot.core.types import SE3, STOP, Twist


def follow_path(
    path_xy: NDArray[np.float64],
    T_map_base: SE3,
    config: FollowerConfig,
    gap: float = np.inf,
) -> Twist:
    """Twist that drives the base along a path; STOP at its end.

    Args:
        path_xy: (P, 2) in `map` [m], P 1 or more; the robot may stand beside it or part way along.
        T_map_base: Where the base is.
        config: Speeds and distances.
        gap: From the robot's rim to the nearest obstacle [m].
    """
    position = T_map_base[:2, 3]
    room = np.clip(gap / config.slow_gap, 0.0, 1.0)
    lookahead = config.min_lookahead + room * (config.lookahead - config.min_lookahead)
    target, to_go = pursued_point(path_xy, position, float(lookahead))
    ahead = float(np.linalg.norm(target - position))
    if ahead < 1e-3:
        return STOP
    error = bearing(T_map_base, target)
    if abs(error) > config.turn_in_place_angle:
        return Twist(0.0, turn_rate(error, config))
    speed = config.max_linear * (config.slow_fraction + room * (1 - config.slow_fraction))
    # The robot must be able to stop at the end, and not pass it while the base holds the twist.
    speed = min(speed, np.sqrt(2 * config.deceleration * to_go), to_go / config.twist_duration)
    speed *= np.cos(error)
    # Near the end the arc through the target grows too tight: a turn rate bounds it.
    angular = 2 * speed * np.sin(error) / ahead
    limit = min(config.max_angular, config.turn_gain * abs(error))
    return Twist(float(speed), float(np.clip(angular, -limit, limit)))


def face(point_xy: NDArray[np.float64], T_map_base: SE3, config: FollowerConfig) -> Twist:
    """Twist that turns the base in place towards a point (2,) in `map` [m]."""
    return Twist(0.0, turn_rate(bearing(T_map_base, point_xy), config))


def bearing(T_map_base: SE3, point_xy: NDArray[np.float64]) -> float:
    """Direction of a point (2,) in `map` as the base sees it [rad, left positive]."""
    dx, dy = point_xy - T_map_base[:2, 3]
    return wrap_angle(float(np.arctan2(dy, dx)) - yaw_of(T_map_base))


def turn_rate(error: float, config: FollowerConfig) -> float:
    """Turn rate that takes out an error of heading without overshoot [rad/s]."""
    return float(np.clip(config.turn_gain * error, -config.max_angular, config.max_angular))


def pursued_point(
    path_xy: NDArray[np.float64], position: NDArray[np.float64], lookahead: float
) -> tuple[NDArray[np.float64], float]:
    """The point `lookahead` [m] further along the path than its nearest point to `position`.

    Returns:
        The point (2,), at most the end of the path, and the way left to that end [m].
    """
    if len(path_xy) == 1:
        return path_xy[0], float(np.linalg.norm(path_xy[0] - position))
    starts, legs = path_xy[:-1], np.diff(path_xy, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    squared = np.maximum(lengths**2, 1e-12)
    along = np.clip(((position - starts) * legs).sum(axis=1) / squared, 0.0, 1.0)
    nearest = starts + along[:, None] * legs
    leg = int(np.argmin(np.linalg.norm(nearest - position, axis=1)))
    distance = np.concatenate([[0.0], np.cumsum(lengths)])
    passed = distance[leg] + along[leg] * lengths[leg]
    wanted = min(passed + lookahead, distance[-1])
    target = np.array([np.interp(wanted, distance, path_xy[:, axis]) for axis in (0, 1)])
    beside = float(np.linalg.norm(nearest[leg] - position))
    return target, float(distance[-1] - passed) + beside
