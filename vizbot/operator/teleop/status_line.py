"""One line in plain words about what the base does and feels, for its driver."""

from __future__ import annotations

from vizbot.core.types import BaseState, Twist

_LINGER = 1.0
"""Shortest display of a contact [s]."""
_SIDES = ("left", "front left", "front right", "right")


class StatusLine:
    """Makes the line; remembers contacts until a person can have read them."""

    def __init__(self) -> None:
        self._felt: dict[str, float] = {}

    def text(self, state: BaseState, twist: Twist, step: int, speed: float, now: float) -> str:
        """The line, what matters most first: a narrow terminal cuts the rest.

        `speed` ahead is that of the speed `step` [m/s].
        """
        self._felt.update(dict.fromkeys(contacts(state), now))
        self._felt = {word: at for word, at in self._felt.items() if now - at < _LINGER}
        battery = "?" if state.battery is None else f"{100 * state.battery:.0f} %"
        parts = [
            motion(twist) if state.mode.obeys else _refusal(state),
            *self._felt,
            f"speed {step} ({speed:.2f} m/s)",
            f"battery {battery}",
            f"{state.mode.name.title()} mode",
        ]
        return " | ".join(parts)


def contacts(state: BaseState) -> list[str]:
    """What the base feels, in plain words."""
    felt = []
    if state.bumped:
        both = state.bump_left and state.bump_right
        felt.append("bump ahead" if both else f"bump {'left' if state.bump_left else 'right'}")
    edges = [side for side, missing in zip(_SIDES, state.cliffs, strict=True) if missing]
    if edges:
        felt.append(f"edge {' and '.join(edges)}")
    if any(state.wheel_drops):
        felt.append("lifted")
    if state.virtual_wall:
        felt.append("virtual wall")
    if any(state.overcurrents):
        felt.append("wheel stuck")
    if state.on_charger:
        felt.append("on charger: pull its cable" if state.plugged_in else "on charger: back off")
    return felt


def motion(twist: Twist) -> str:
    """The commanded motion, in plain words."""
    ways = []
    if twist.linear:
        ways.append("ahead" if twist.linear > 0 else "back")
    if twist.angular:
        ways.append("left" if twist.angular > 0 else "right")
    return " ".join(ways) or "standing"


def _refusal(state: BaseState) -> str:
    """Why the base does not drive, as far as it still feels it, and the remedy."""
    if state.plugged_in:
        return "does not drive: unplug its charger, then press r"
    if any(state.wheel_drops):
        return "does not drive: put it on the floor, then press r"
    if any(state.cliffs):
        return "stopped at an edge: press r, then back straight off"
    if state.maybe_moved:
        return "somebody may have moved it: look at it, then press r"
    return "does not drive: press r to go on"
