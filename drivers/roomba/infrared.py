"""Infrared characters that the Roomba receives: packets 17, 52 and 53 (manual, pages 26 to 27)."""

from __future__ import annotations

from enum import IntEnum, IntFlag

VIRTUAL_WALL = 162
"""Character of the 600-series virtual wall."""


class RemoteControl(IntEnum):
    """Keys of the remote controls."""

    LEFT = 129
    FORWARD = 130
    RIGHT = 131
    SPOT = 132
    MAX = 133
    SMALL = 134
    MEDIUM = 135
    CLEAN = 136
    STOP = 137
    POWER = 138
    ARC_LEFT = 139
    ARC_RIGHT = 140
    STOP_DRIVING = 141
    DOWNLOAD = 142
    SEEK_DOCK = 143


class DockBeam(IntFlag):
    """What a dock shines at the receiver.

    Seen by a robot that faces the dock, green is on its left and red on its right; the force field
    surrounds the dock.
    """

    FORCE_FIELD = 1
    GREEN = 4
    RED = 8


class WallBeam(IntEnum):
    """What an auto-on virtual wall shines at the receiver."""

    FENCE = 0
    FORCE_FIELD = 1
    GREEN = 2
    RED = 3


def dock_beams(character: int) -> DockBeam | None:
    """Beams of a 600-series (160 to 173) or Discovery dock (240 to 254); None if neither sent it.

    The character is 160 + 8 red + 4 green + 1 field, or 240 + 8 red + 4 green + 2 field.
    """
    for first, field in ((160, 1), (240, 2)):
        bits = character - first
        if 0 <= bits < 16 and bits & ~(8 | 4 | field) == 0:
            return DockBeam(bits & 12) | (DockBeam.FORCE_FIELD if bits & field else DockBeam(0))
    return None


def auto_virtual_wall(character: int) -> tuple[int, WallBeam] | None:
    """Id (1 to 10; 11 is unbound) and beam of an auto-on virtual wall; None if none sent it.

    The bits are 0LLLL0BB: L the id, B the beam.
    """
    wall = character >> 3
    if character & 0b100 or not 1 <= wall <= 11:
        return None
    return wall, WallBeam(character & 0b11)
