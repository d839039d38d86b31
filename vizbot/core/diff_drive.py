"""Kinematics of a differential drive: wheel speeds, twists, dead reckoning."""

from __future__ import annotations

import numpy as np

from vizbot.core.geometry import planar
from vizbot.core.types import SE3, Twist


def wheel_speeds(twist: Twist, wheel_base: float) -> tuple[float, float]:
    """Left and right rim speed [m/s] for a twist; `wheel_base` is the track width [m]."""
    half = 0.5 * wheel_base * twist.angular
    return twist.linear - half, twist.linear + half


def within_wheel_limit(twist: Twist, wheel_base: float, limit: float) -> Twist:
    """The twist scaled down, same curvature, until no wheel is faster than `limit` [m/s]."""
    fastest = max(abs(speed) for speed in wheel_speeds(twist, wheel_base))
    scale = 1.0 if fastest <= limit else limit / fastest
    return Twist(twist.linear * scale, twist.angular * scale)


def rolled(left: float, right: float, wheel_base: float) -> SE3:
    """Motion of the base while its wheels roll `left` and `right` metres along one arc."""
    distance, angle = 0.5 * (left + right), (right - left) / wheel_base
    half = np.pi * (angle / (2 * np.pi))
    chord = distance * float(np.sin(half) / half) if half else distance
    return planar(chord * np.cos(angle / 2), chord * np.sin(angle / 2), angle)
