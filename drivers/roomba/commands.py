"""Commands of the Roomba Open Interface: bytes only, no I/O.

Source: iRobot Create 2 Open Interface Specification based on the Roomba 600 (2016), pages 8 to 22.
A command is its opcode and whole-number arguments in the order of the wire; counts that the wire
carries (notes of a song, packets of a list) are not arguments, they follow from the others.
"""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import dataclass
from enum import IntEnum, IntFlag

from drivers.roomba.packets import SIZES, Buttons
from vizbot.core.types import Feedback

STRAIGHT = -32768
"""Radius of Drive for a straight line: 0x8000; 0x7FFF means the same."""
CLOCKWISE = -1
"""Radius of Drive to spin clockwise."""
COUNTER_CLOCKWISE = 1
"""Radius of Drive to spin counter-clockwise."""

BAUD_RATES = (300, 600, 1200, 2400, 4800, 9600, 14400, 19200, 28800, 38400, 57600, 115200)
"""Line rate [bit/s] of each code of the Baud command (page 9)."""

COUNTS_PER_REVOLUTION = 508.8
"""Encoder counts for one turn of a wheel (page 31)."""
WHEEL_DIAMETER = 0.072
"""Diameter of a wheel [m] (page 31)."""
METRES_PER_COUNT = 3.141592653589793 * WHEEL_DIAMETER / COUNTS_PER_REVOLUTION
"""Rim travel for one encoder count [m]: 0.444565 mm."""


class Opcode(IntEnum):
    """Every command (pages 8 to 22)."""

    RESET = 7
    START = 128
    BAUD = 129
    CONTROL = 130
    SAFE = 131
    FULL = 132
    POWER = 133
    SPOT = 134
    CLEAN = 135
    MAX = 136
    DRIVE = 137
    MOTORS = 138
    LEDS = 139
    SONG = 140
    PLAY = 141
    SENSORS = 142
    SEEK_DOCK = 143
    PWM_MOTORS = 144
    DRIVE_DIRECT = 145
    DRIVE_PWM = 146
    STREAM = 148
    QUERY_LIST = 149
    PAUSE_RESUME_STREAM = 150
    SCHEDULING_LEDS = 162
    DIGIT_LEDS_RAW = 163
    DIGIT_LEDS_ASCII = 164
    BUTTONS = 165
    SCHEDULE = 167
    SET_DAY_TIME = 168
    STOP = 173


class Motors(IntFlag):
    """Argument of Motors (page 15)."""

    SIDE_BRUSH = 1
    VACUUM = 2
    MAIN_BRUSH = 4
    SIDE_BRUSH_CLOCKWISE = 8
    MAIN_BRUSH_OUTWARD = 16


class Leds(IntFlag):
    """First argument of LEDs (page 16)."""

    DEBRIS = 1
    SPOT = 2
    DOCK = 4
    CHECK_ROBOT = 8


class Days(IntFlag):
    """First argument of Schedule and of Scheduling LEDs (pages 12, 16)."""

    SUNDAY = 1
    MONDAY = 2
    TUESDAY = 4
    WEDNESDAY = 8
    THURSDAY = 16
    FRIDAY = 32
    SATURDAY = 64


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument of a command.

    Attributes:
        name: As the manual calls it.
        allowed: The values that it may take.
        legend: `allowed`, for people.
        size: Bytes on the wire.
        signed: Whether it is two's complement there.
    """

    name: str
    allowed: Container[int]
    legend: str
    size: int = 1
    signed: bool = False


@dataclass(frozen=True, slots=True)
class CommandLayout:
    """Arguments of one command.

    Attributes:
        fixed: Always there.
        repeated: Group of arguments that occurs as often as a count byte says; empty if none does.
        most: Largest such count.
    """

    fixed: tuple[Argument, ...] = ()
    repeated: tuple[Argument, ...] = ()
    most: int = 0


def _number(name: str, low: int, high: int, size: int = 1) -> Argument:
    return Argument(name, range(low, high + 1), f"{low} to {high}", size, low < 0)


def _bits(name: str, flags: type[IntFlag]) -> Argument:
    return _number(name, 0, sum(flags))


def _layouts() -> dict[Opcode, CommandLayout]:
    wheels = [_number(f"{side} velocity", -500, 500, 2) for side in ("right", "left")]
    duties = [_number(f"{side} duty", -255, 255, 2) for side in ("right", "left")]
    radii = {*range(-2000, 2001), STRAIGHT, 32767}
    radius = Argument("radius", radii, "-2000 to 2000, -32768 or 32767", 2, True)
    brushes = [_number(f"{brush} brush", -127, 127) for brush in ("main", "side")]
    packet = Argument("packet", frozenset(SIZES), "0 to 58, 100, 101, 106 or 107")
    note = (_number("note", 0, 255), _number("duration", 0, 255))
    time = (_number("hour", 0, 23), _number("minute", 0, 59))
    layouts = {opcode: CommandLayout() for opcode in Opcode}
    layouts |= {
        Opcode.BAUD: CommandLayout((_number("code", 0, 11),)),
        Opcode.DRIVE: CommandLayout((_number("velocity", -500, 500, 2), radius)),
        Opcode.MOTORS: CommandLayout((_bits("motors", Motors),)),
        Opcode.LEDS: CommandLayout(
            (_bits("LEDs", Leds), _number("power colour", 0, 255), _number("power level", 0, 255))
        ),
        Opcode.SONG: CommandLayout((_number("song", 0, 4),), note, 16),
        Opcode.PLAY: CommandLayout((_number("song", 0, 4),)),
        Opcode.SENSORS: CommandLayout((packet,)),
        Opcode.PWM_MOTORS: CommandLayout((*brushes, _number("vacuum", 0, 127))),
        Opcode.DRIVE_DIRECT: CommandLayout(tuple(wheels)),
        Opcode.DRIVE_PWM: CommandLayout(tuple(duties)),
        Opcode.STREAM: CommandLayout((), (packet,), 255),
        Opcode.QUERY_LIST: CommandLayout((), (packet,), 255),
        Opcode.PAUSE_RESUME_STREAM: CommandLayout((_number("state", 0, 1),)),
        Opcode.SCHEDULING_LEDS: CommandLayout((_bits("days", Days), _number("LEDs", 0, 31))),
        Opcode.DIGIT_LEDS_RAW: CommandLayout((_number("segments", 0, 127),) * 4),
        Opcode.DIGIT_LEDS_ASCII: CommandLayout((_number("character", 32, 126),) * 4),
        Opcode.BUTTONS: CommandLayout((_bits("buttons", Buttons),)),
        Opcode.SCHEDULE: CommandLayout((_bits("days", Days), *time * 7)),
        Opcode.SET_DAY_TIME: CommandLayout((_number("day", 0, 6), *time)),
    }
    return layouts


LAYOUTS = _layouts()


@dataclass(frozen=True, slots=True)
class Command:
    """One command as it was read from the line.

    Attributes:
        arguments: In the order of the wire, counts left out; not range-checked.
    """

    opcode: Opcode
    arguments: tuple[int, ...] = ()


def check(command: Command) -> None:
    """Compare a command with the manual.

    Raises:
        ValueError: too many or too few arguments, or one is outside the range that it may have.
    """
    layout, values, name = LAYOUTS[command.opcode], command.arguments, command.opcode.name
    surplus = len(values) - len(layout.fixed)
    count = surplus // len(layout.repeated) if layout.repeated else 0
    if surplus < 0 or surplus != count * len(layout.repeated) or count > layout.most:
        raise ValueError(f"{name} takes other arguments than {values}")
    for argument, value in zip(layout.fixed + layout.repeated * count, values, strict=True):
        if value not in argument.allowed:
            raise ValueError(f"{name}: {argument.name} {value} is not {argument.legend}")


def encode(opcode: Opcode, *arguments: int) -> bytes:
    """Bytes of one command.

    Drive Direct and Drive PWM take the RIGHT wheel first. A song is its number, then note and
    duration in turns; Stream and Query List take packet and group ids.

    Raises:
        ValueError: as `check`.
    """
    check(Command(opcode, arguments))
    layout, fixed = LAYOUTS[opcode], len(LAYOUTS[opcode].fixed)
    encoded = bytearray([opcode])
    for argument, value in zip(layout.fixed, arguments[:fixed], strict=True):
        encoded += value.to_bytes(argument.size, "big", signed=argument.signed)
    if layout.repeated:
        encoded.append((len(arguments) - fixed) // len(layout.repeated))
        encoded += bytes(arguments[fixed:])
    return bytes(encoded)


class CommandParser:
    """Splits the bytes that reach a base into commands, as the base does.

    Bytes that are no opcode are skipped; a command whose data bytes are missing waits for them
    without limit (manual, page 8).
    """

    def __init__(self) -> None:
        self._pending = bytearray()

    def feed(self, received: bytes) -> Iterator[Command]:
        """Yield the commands that `received` completes."""
        self._pending += received
        while self._pending:
            if self._pending[0] not in LAYOUTS:
                del self._pending[0]
                continue
            opcode = Opcode(self._pending[0])
            size = _size(LAYOUTS[opcode], self._pending)
            if size is None or len(self._pending) < size:
                return
            encoded = bytes(self._pending[1:size])
            del self._pending[:size]
            yield Command(opcode, _decode(LAYOUTS[opcode], encoded))


def _size(layout: CommandLayout, pending: bytearray) -> int | None:
    """Bytes of the command that `pending` begins with; None before its count byte is there."""
    size = 1 + sum(argument.size for argument in layout.fixed)
    if not layout.repeated:
        return size
    return size + 1 + pending[size] * len(layout.repeated) if len(pending) > size else None


def _decode(layout: CommandLayout, encoded: bytes) -> tuple[int, ...]:
    values, start = [], 0
    for argument in layout.fixed:
        end = start + argument.size
        values.append(int.from_bytes(encoded[start:end], "big", signed=argument.signed))
        start = end
    return (*values, *encoded[start + 1 :])


_GREEN, _ORANGE, _RED = 0, 64, 255
_BRIGHT = 255
_SHORT, _LONG = 12, 24
"""Durations of notes [1/64 s]."""

_LIGHTS = {
    Feedback.LISTENING: (Leds.SPOT, _GREEN),
    Feedback.FOUND: (Leds.DEBRIS, _GREEN),
    Feedback.NOT_FOUND: (Leds(0), _ORANGE),
    Feedback.STUCK: (Leds.CHECK_ROBOT, _RED),
    Feedback.DOUBT: (Leds.SPOT, _ORANGE),
}
"""Lit LEDs, and the colour of the power LED, for each feedback."""
_SONGS = {
    Feedback.LISTENING: ((76, _SHORT),),
    Feedback.FOUND: ((67, _SHORT), (72, _SHORT), (76, _LONG)),
    Feedback.NOT_FOUND: ((67, _SHORT), (62, _LONG)),
    Feedback.STUCK: ((50, _SHORT), (50, _SHORT), (50, _LONG)),
    Feedback.DOUBT: ((67, _SHORT), (74, _SHORT)),
}
"""Notes (MIDI numbers) and durations; the order gives the slot of each song."""


def songs() -> bytes:
    """Commands that store the songs in their slots, which a reset of the base clears."""
    return b"".join(
        encode(Opcode.SONG, slot, *(number for note in notes for number in note))
        for slot, notes in enumerate(_SONGS.values())
    )


def show_feedback(feedback: Feedback) -> bytes:
    """Commands that light the LEDs and play the song (manual, pages 16, 19 and 20).

    No data byte of them is an opcode: where the line loses an opcode, their data start nothing.
    """
    leds, colour = _LIGHTS[feedback]
    lights = encode(Opcode.LEDS, leds, colour, _BRIGHT)
    return lights + encode(Opcode.PLAY, list(_SONGS).index(feedback))
