"""Reflexes of the base: limits to its motion by its contacts. Pure rules, no I/O."""

from __future__ import annotations

from vizbot.core.types import STOP, BaseState, Twist

GENTLY = 0.12
"""Largest speed towards an obstacle that the light bumper senses [m/s]."""


def allowed(twist: Twist, state: BaseState) -> Twist:
    """The part of `twist` that is safe in `state`.

    - The base is in neither Safe nor Full mode, a wheel hangs, or the cable of a charger is plugged
      in: nothing.
    - A cliff: only backing off straight, since the rear has no cliff sensors to turn by.
    - A wheel is stuck: only backing off straight.
    - The bumper is pressed or a virtual wall is seen: backing off and turning on the spot.
    - Something reflects right before the front of the bumper: forward only slowly.
    """
    if not state.mode.obeys or any(state.wheel_drops) or state.plugged_in:
        return STOP
    if any(state.cliffs) or any(state.overcurrents):
        return twist if twist.linear < 0 and twist.angular == 0 else STOP
    if state.blocked:
        return twist if twist.linear <= 0 else STOP
    if any(state.light_bumpers[1:-1]) and twist.linear > GENTLY:
        slower = GENTLY / twist.linear
        return Twist(GENTLY, twist.angular * slower)
    return twist
