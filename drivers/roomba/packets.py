"""Sensor packets of the Roomba Open Interface: sizes, ranges, bit fields and enumerations.

Source: iRobot Create 2 Open Interface Specification based on the Roomba 600 (2016), pages 21 to 39.
Values are the integers of the wire (mm, mV, mA, mAh, degrees Celsius), big-endian there.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from functools import lru_cache


class Packet(IntEnum):
    """The 52 single packets (pages 23 to 32)."""

    BUMPS_AND_WHEEL_DROPS = 7
    WALL = 8
    CLIFF_LEFT = 9
    CLIFF_FRONT_LEFT = 10
    CLIFF_FRONT_RIGHT = 11
    CLIFF_RIGHT = 12
    VIRTUAL_WALL = 13
    OVERCURRENTS = 14
    DIRT_DETECT = 15
    UNUSED_16 = 16
    IR_OMNI = 17
    BUTTONS = 18
    DISTANCE = 19
    ANGLE = 20
    CHARGING_STATE = 21
    VOLTAGE = 22
    CURRENT = 23
    TEMPERATURE = 24
    BATTERY_CHARGE = 25
    BATTERY_CAPACITY = 26
    WALL_SIGNAL = 27
    CLIFF_LEFT_SIGNAL = 28
    CLIFF_FRONT_LEFT_SIGNAL = 29
    CLIFF_FRONT_RIGHT_SIGNAL = 30
    CLIFF_RIGHT_SIGNAL = 31
    UNUSED_32 = 32
    UNUSED_33 = 33
    CHARGING_SOURCES = 34
    OI_MODE = 35
    SONG_NUMBER = 36
    SONG_PLAYING = 37
    STREAM_PACKET_COUNT = 38
    REQUESTED_VELOCITY = 39
    REQUESTED_RADIUS = 40
    REQUESTED_RIGHT_VELOCITY = 41
    REQUESTED_LEFT_VELOCITY = 42
    LEFT_ENCODER = 43
    RIGHT_ENCODER = 44
    LIGHT_BUMPER = 45
    LIGHT_BUMP_LEFT = 46
    LIGHT_BUMP_FRONT_LEFT = 47
    LIGHT_BUMP_CENTER_LEFT = 48
    LIGHT_BUMP_CENTER_RIGHT = 49
    LIGHT_BUMP_FRONT_RIGHT = 50
    LIGHT_BUMP_RIGHT = 51
    IR_LEFT = 52
    IR_RIGHT = 53
    LEFT_MOTOR_CURRENT = 54
    RIGHT_MOTOR_CURRENT = 55
    MAIN_BRUSH_CURRENT = 56
    SIDE_BRUSH_CURRENT = 57
    STASIS = 58


@dataclass(frozen=True, slots=True)
class PacketLayout:
    """Layout of one packet on the wire.

    Attributes:
        code: `struct` character: B, b (one byte), H, h (two); lower case is signed.
        low: Smallest value the manual allows.
        high: Largest value the manual allows.
    """

    code: str
    low: int
    high: int


_BITS = {7: 15, 14: 29, 34: 3, 45: 127, 58: 3}
"""Packets of single bits, and all bits that the manual has."""


def _layouts() -> dict[Packet, PacketLayout]:
    u8, u16 = PacketLayout("B", 0, 255), PacketLayout("H", 0, 65535)
    s16, signal = PacketLayout("h", -32768, 32767), PacketLayout("H", 0, 4095)
    flag, velocity = PacketLayout("B", 0, 1), PacketLayout("h", -500, 500)
    enums = {21: 5, 35: 3, 36: 4, 38: 108}
    layouts = {number: PacketLayout("B", 0, high) for number, high in (_BITS | enums).items()}
    layouts |= dict.fromkeys((8, 9, 10, 11, 12, 13, 37), flag)
    layouts |= dict.fromkeys((15, 16, 17, 18, 32, 52, 53), u8)
    layouts |= dict.fromkeys((22, 25, 26, 33), u16)
    layouts |= dict.fromkeys((19, 20, 23, 40, 43, 44, 54, 55, 56, 57), s16)
    layouts |= dict.fromkeys((*range(28, 32), *range(46, 52)), signal)
    layouts |= dict.fromkeys((39, 41, 42), velocity)
    layouts |= {24: PacketLayout("b", -128, 127), 27: PacketLayout("H", 0, 1023)}
    return {packet: layouts[packet] for packet in Packet}


LAYOUTS = _layouts()

GROUPS: dict[int, tuple[Packet, ...]] = {
    group: tuple(Packet(number) for number in range(first, last + 1))
    for group, first, last in (
        (0, 7, 26),
        (1, 7, 16),
        (2, 17, 20),
        (3, 21, 26),
        (4, 27, 34),
        (5, 35, 42),
        (6, 7, 42),
        (100, 7, 58),
        (101, 43, 58),
        (106, 46, 51),
        (107, 54, 58),
    )
}
"""Groups and the packets they hold, in order (pages 23, 39); 102 to 105 are not defined."""


def singles(ids: Iterable[int]) -> tuple[Packet, ...]:
    """The single packets that packet and group ids stand for, in order.

    Raises:
        ValueError: an id is neither a packet nor a group.
    """
    return _singles(tuple(ids))


@lru_cache(maxsize=256)
def _singles(ids: tuple[int, ...]) -> tuple[Packet, ...]:
    packets: list[Packet] = []
    for number in ids:
        packets.extend(GROUPS.get(number) or (Packet(number),))
    return tuple(packets)


def wire_codes(packets: Iterable[Packet]) -> str:
    """`struct` characters of the data of these packets, in order."""
    return "".join(LAYOUTS[packet].code for packet in packets)


SIZES: dict[int, int] = {
    number: struct.calcsize(">" + wire_codes(singles([number]))) for number in (*Packet, *GROUPS)
}
"""Bytes of data of every packet and group id."""


@lru_cache(maxsize=256)
def _reply_layout(ids: tuple[int, ...]) -> tuple[tuple[Packet, ...], struct.Struct]:
    packets = singles(ids)
    return packets, struct.Struct(">" + wire_codes(packets))


def encode_packets(
    ids: Iterable[int], values: Mapping[Packet, int], unlimited: Packet | None = None
) -> bytes:
    """The bare data of `ids`, as a base replies to Sensors or Query List.

    The packet `unlimited` may have any value that fits its bytes, as the mode of some firmware has.

    Raises:
        ValueError: an id is unknown, or a value is outside the range of its packet.
    """
    packets, layout = _reply_layout(tuple(ids))
    return layout.pack(*within_ranges(packets, values, unlimited))


def within_ranges(
    packets: Iterable[Packet], values: Mapping[Packet, int], unlimited: Packet | None = None
) -> list[int]:
    """The values of `packets`, in order.

    Raises:
        ValueError: one is outside the range of its packet, which is not the `unlimited` one.
    """
    chosen = []
    for packet in packets:
        value, layout = values[packet], LAYOUTS[packet]
        if not layout.low <= value <= layout.high and packet is not unlimited:
            span = f"{layout.low} to {layout.high}"
            raise ValueError(f"{packet.name} (packet {packet}) = {value} is not in {span}")
        chosen.append(value)
    return chosen


def out_of_range(values: Mapping[Packet, int]) -> tuple[Packet, ...]:
    """The packets whose values the manual does not allow; mostly none."""
    odd = []
    for packet, value in values.items():
        layout = LAYOUTS[packet]
        if not layout.low <= value <= layout.high:
            odd.append(packet)
    return tuple(odd)


def nearest_allowed(packet: Packet, value: int) -> int:
    """The allowed value that says most of what another one does.

    Of bits the known ones stay, a state that is not known is none, and numbers are limited.
    """
    layout = LAYOUTS[packet]
    if packet in _BITS:
        return value & layout.high
    if packet == Packet.CHARGING_STATE and value > layout.high:
        return 0
    return min(max(value, layout.low), layout.high)


class BumpsAndWheelDrops(IntFlag):
    """Packet 7 (page 23)."""

    BUMP_RIGHT = 1
    BUMP_LEFT = 2
    WHEEL_DROP_RIGHT = 4
    WHEEL_DROP_LEFT = 8


class Overcurrents(IntFlag):
    """Packet 14 (page 24)."""

    SIDE_BRUSH = 1
    MAIN_BRUSH = 4
    RIGHT_WHEEL = 8
    LEFT_WHEEL = 16


class Buttons(IntFlag):
    """Packet 18 and the argument of the Buttons command (pages 17, 27)."""

    CLEAN = 1
    SPOT = 2
    DOCK = 4
    MINUTE = 8
    HOUR = 16
    DAY = 32
    SCHEDULE = 64
    CLOCK = 128


class ChargingState(IntEnum):
    """Packet 21 (page 28)."""

    NOT_CHARGING = 0
    RECONDITIONING = 1
    FULL_CHARGING = 2
    TRICKLE = 3
    WAITING = 4
    FAULT = 5


class ChargingSources(IntFlag):
    """Packet 34 (page 29)."""

    INTERNAL_CHARGER = 1
    HOME_BASE = 2


class LightBumper(IntFlag):
    """Packet 45 (page 31); bit 6 is reserved."""

    LEFT = 1
    FRONT_LEFT = 2
    CENTER_LEFT = 4
    CENTER_RIGHT = 8
    FRONT_RIGHT = 16
    RIGHT = 32


class Stasis(IntFlag):
    """Packet 58 (page 38)."""

    TOGGLING = 1
    DISABLED = 2


class DockBeam(IntFlag):
    """Beams of a dock at an infrared receiver: packets 17, 52 and 53 (manual, pages 26 to 27).

    For a robot that faces the dock, the green beam is on the left and the red one on the right; the
    force field surrounds the dock.
    """

    FORCE_FIELD = 1
    GREEN = 4
    RED = 8
