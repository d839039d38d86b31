"""Wheels of the simulated Roomba: drive commands and encoder counts."""

from __future__ import annotations

import math

from drivers.roomba.commands import (
    CLOCKWISE,
    COUNTER_CLOCKWISE,
    METRES_PER_COUNT,
    STRAIGHT,
    Command,
    Opcode,
)
from drivers.roomba.packets import Packet
from sim_stubs.world.body import Body

_WHEEL_BASE_MM = 235.0
_OWN_RADIUS_MM = 174.0
_FASTEST_MM_S = 500.0
_FULL_DUTY = 255


class Wheels:
    """Two wheels that turn as last commanded, and their encoders."""

    def __init__(self, body: Body, counts: tuple[int, int]) -> None:
        """Start at rest, with the encoders at `counts` (left, right)."""
        self._body = body
        self._first_counts = counts
        self._body_travel = body.wheel_travel
        self._counted_mm = (0.0, 0.0)
        self._speeds_mm_s = (0.0, 0.0)
        self._distance_mm = 0.0
        self._angle = 0.0
        self._requested = {
            Packet.REQUESTED_VELOCITY: 0,
            Packet.REQUESTED_RADIUS: 0,
            Packet.REQUESTED_RIGHT_VELOCITY: 0,
            Packet.REQUESTED_LEFT_VELOCITY: 0,
        }

    @property
    def turning(self) -> bool:
        """Whether a wheel is commanded to turn."""
        return self._speeds_mm_s != (0.0, 0.0)

    @property
    def advancing(self) -> bool:
        """Whether the base is commanded to drive straight ahead."""
        left, right = self._speeds_mm_s
        return left == right > 0

    @property
    def stops_for_cliffs(self) -> bool:
        """Whether Safe mode guards this motion: forward, or back in an arc within the base."""
        left, right = self._speeds_mm_s
        mean, difference = (left + right) / 2, right - left
        return mean > 0 or (
            mean < 0 and abs(mean) * _WHEEL_BASE_MM < abs(difference) * _OWN_RADIUS_MM
        )

    def obey(self, command: Command) -> None:
        """Execute Drive, Drive Direct or Drive PWM."""
        first, second = command.arguments
        if command.opcode is Opcode.DRIVE:
            self._requested[Packet.REQUESTED_VELOCITY] = first
            self._requested[Packet.REQUESTED_RADIUS] = second
            self.turn(*wheel_speeds_of_arc(first, second))
        elif command.opcode is Opcode.DRIVE_DIRECT:
            self._requested[Packet.REQUESTED_RIGHT_VELOCITY] = first
            self._requested[Packet.REQUESTED_LEFT_VELOCITY] = second
            self.turn(left=second, right=first)
        else:
            scale = _FASTEST_MM_S / _FULL_DUTY
            self.turn(left=second * scale, right=first * scale)

    def stop(self) -> None:
        """Switch both motors off."""
        self.turn(0.0, 0.0)

    def turn(self, left: float, right: float) -> None:
        """Turn at these speeds [mm/s], which the base chooses itself."""
        self._speeds_mm_s = left, right
        self._body.set_wheel_speeds(left / 1000, right / 1000)

    def jump(self, counts: int) -> None:
        """Add counts to both encoders without motion."""
        left, right = self._first_counts
        self._first_counts = left + counts, right + counts

    def advance(self, seconds: float) -> None:
        """Let the body move for `seconds`, and count.

        The encoders sense no direction: they count in the commanded direction, and up without a
        command (manual, page 30).
        """
        self._body.advance(seconds)
        travel = self._body.wheel_travel
        left, right = (
            math.copysign(1000 * abs(new - old), speed if speed != 0 else 1.0)
            for new, old, speed in zip(travel, self._body_travel, self._speeds_mm_s, strict=True)
        )
        self._body_travel = travel
        self._counted_mm = self._counted_mm[0] + left, self._counted_mm[1] + right
        self._distance_mm += (left + right) / 2
        self._angle += (right - left) / _WHEEL_BASE_MM

    def packets(self) -> dict[Packet, int]:
        """Packets 19, 20, 39 to 44 as they stand."""
        left, right = (
            _signed_16_bit(first + round(counted / (1000 * METRES_PER_COUNT)))
            for first, counted in zip(self._first_counts, self._counted_mm, strict=True)
        )
        return self._requested | {
            Packet.DISTANCE: _saturated(self._distance_mm),
            Packet.ANGLE: _saturated(math.degrees(self._angle)),
            Packet.LEFT_ENCODER: left,
            Packet.RIGHT_ENCODER: right,
        }

    def was_read(self, packets: tuple[Packet, ...]) -> None:
        """Reset packets that count since they were last read."""
        if Packet.DISTANCE in packets:
            self._distance_mm = 0.0
        if Packet.ANGLE in packets:
            self._angle = 0.0


def within_range(command: Command) -> Command:
    """Drive, Drive Direct or Drive PWM with every speed or duty limited."""
    first, second = command.arguments
    most = _FULL_DUTY if command.opcode is Opcode.DRIVE_PWM else round(_FASTEST_MM_S)
    first = max(-most, min(most, first))
    if command.opcode is not Opcode.DRIVE:
        second = max(-most, min(most, second))
    return Command(command.opcode, (first, second))


def wheel_speeds_of_arc(velocity: int, radius: int) -> tuple[float, float]:
    """Left and right wheel speed [mm/s] of Drive; at most 500 (manual, page 13).

    The radius 0 has no meaning there; it is taken as straight.
    """
    if radius in (STRAIGHT, 32767, 0):
        return velocity, velocity
    if radius in (CLOCKWISE, COUNTER_CLOCKWISE):
        return -velocity * radius, velocity * radius
    half = _WHEEL_BASE_MM / 2
    left, right = velocity * (radius - half) / radius, velocity * (radius + half) / radius
    return _within_limit(left), _within_limit(right)


def _within_limit(speed: float) -> float:
    return max(-_FASTEST_MM_S, min(_FASTEST_MM_S, speed))


def _signed_16_bit(count: int) -> int:
    return (count + 32768) % 65536 - 32768


def _saturated(value: float) -> int:
    return max(-32768, min(32767, round(value)))
