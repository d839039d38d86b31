"""Wheel speeds on a line that may lose a byte.

Towards the base the Open Interface has no checksum. A command that lacks a byte takes it from the
one behind it, and the data of a command whose opcode is lost are read as opcodes (manual, page 8).
"""

from __future__ import annotations

from bisect import bisect
from collections import deque
from functools import lru_cache

from drivers.roomba.commands import Opcode, encode
from drivers.roomba.config import RoombaConfig
from vizbot.core.types import STOP, BaseState, Twist

_LIVE = frozenset(Opcode)
_HARMLESS = tuple(
    speed for speed in range(-500, 501) if _LIVE.isdisjoint(speed.to_bytes(2, "big", signed=True))
)
"""Speeds [mm/s] neither of whose bytes is an opcode, which leaves out 128 to 146, for example."""

WHEEL_BASE = 0.235
"""Distance of the wheels by the manual [m]."""
COMPLETION = 4 * bytes([24])
"""Completes a wheel command that lost a byte, and is nothing by itself: 24 is no opcode, no opcode
differs from it by one bit, and as the data of Buttons it presses none that moves the base.

What it completes holds for less than a millisecond where a command comes right behind it.
"""


@lru_cache(maxsize=1024)
def harmless(speed: int, most: int = 500) -> int:
    """The nearest speed whose data are no opcodes if its own is lost.

    It is at most 10 mm/s off, or 19 towards rest where the other one would be beyond `most`.

    Args:
        speed: Of a wheel, at most `most` either way [mm/s].
        most: Largest speed of the wheel, 500 at most [mm/s].
    """
    above = bisect(_HARMLESS, speed)
    around = [near for near in _HARMLESS[max(above - 1, 0) : above + 1] if abs(near) <= most]
    return min(around, key=lambda other: (abs(other - speed), abs(other)))


def within_limits(right: float, left: float, config: RoombaConfig) -> tuple[int, int]:
    """`harmless` speeds of right and left wheel [mm/s] that keep their ratio as far as limits let.

    The limits hold for what the wheels do, with the manual's geometry as well as with the
    calibrated one: settings that are wrong make no wheel and no turn faster.

    Both are wanted speeds at the rim by the calibration [m/s].
    """
    rolls = max(1.0, config.wheel_scale)
    most = min(500, int(1000 * config.max_wheel_speed / rolls + 1e-9))
    apart = 1000 * config.max_turn_rate * WHEEL_BASE / rolls
    right, left = 1000 * right / config.wheel_scale, 1000 * left / config.wheel_scale
    fastest, differ = max(abs(right), abs(left)), abs(right - left)
    share = min(1.0, most / max(fastest, 1e-9), apart / max(differ, 1e-9))
    while True:
        wheels = harmless(round(share * right), most), harmless(round(share * left), most)
        if abs(wheels[0] - wheels[1]) <= apart:
            return wheels
        share *= 0.95  # what is kept clear of opcodes may lie farther apart


def drive_command(right: int, left: int) -> bytes:
    """Drive Direct at `harmless` speeds [mm/s], behind the rest of a command cut by a lost byte."""
    return COMPLETION + encode(Opcode.DRIVE_DIRECT, right, left)


STOP_WHEELS = drive_command(0, 0)
SURE_STOP = 4 * STOP_WHEELS
"""Works after any wheel command cut short, and after a list of packets that lacks up to 12."""


class CommandedSpeeds:
    """Recently commanded wheel speeds, to be compared with those that the base reports."""

    def __init__(self, memory: float) -> None:
        """Start empty; the report of the base may be `memory` [s] old."""
        self._memory = memory
        self._commanded: deque[tuple[float, tuple[int, int]]] = deque()

    @property
    def latest(self) -> tuple[int, int] | None:
        """Right and left [mm/s]; None before the first."""
        return self._commanded[-1][1] if self._commanded else None

    def add(self, wheels: tuple[int, int], now: float) -> None:
        """Add right and left speed [mm/s] that were sent at `now` [s]."""
        if wheels != self.latest:
            self._commanded.append((now, wheels))
        # The command in force when the memory starts counts as well.
        while len(self._commanded) > 1 and now - self._commanded[1][0] > self._memory:
            self._commanded.popleft()

    def explains(self, wheels: tuple[int, int], tolerance: float) -> bool:
        """Whether a recent command explains the speeds that the base reports (packets 41, 42).

        Args:
            wheels: Reported right and left speed [mm/s].
            tolerance: Largest difference to a command [mm/s]; firmware may round.
        """
        return not self._commanded or any(
            max(abs(right - wheels[0]), abs(left - wheels[1])) <= tolerance
            for _, (right, left) in self._commanded
        )

    def clear(self) -> None:
        """Drop all commands: none is in force any more."""
        self._commanded.clear()


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
