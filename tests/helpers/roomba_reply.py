"""What a base replies, read as a program reads it that follows the manual."""

import struct
from collections.abc import Iterable

from drivers.roomba.packets import DockBeam, Packet, singles, wire_codes


def decode_packets(ids: Iterable[int], reply: bytes) -> dict[Packet, int]:
    """Values in a reply to Sensors or Query List: the bare data of `ids`, in order.

    Raises:
        ValueError: an id is unknown, or the reply is not as long as `ids` make it.
    """
    packets = singles(ids)
    layout = struct.Struct(">" + wire_codes(packets))
    if len(reply) != layout.size:
        raise ValueError(f"reply of {len(reply)} bytes where {layout.size} are due")
    return dict(zip(packets, layout.unpack(reply), strict=True))


def dock_beams(character: int) -> DockBeam | None:
    """Beams of a 600-series (160 to 173) or Discovery dock (240 to 254); None if it is of neither.

    The character is 160 + 8 red + 4 green + 1 field, or 240 + 8 red + 4 green + 2 field.
    """
    for first, field in ((160, 1), (240, 2)):
        bits = character - first
        if 0 <= bits < 16 and bits & ~(8 | 4 | field) == 0:
            return DockBeam(bits & 12) | (DockBeam.FORCE_FIELD if bits & field else DockBeam(0))
    return None


REPLIES = {
    "R10": (2, [172, 1, 255, 136, 0, 45], {17: 172, 18: 1, 19: -120, 20: 45}),
    "R11": (
        3,
        [2, 63, 72, 4, 210, 25, 9, 196, 11, 184],
        {21: 2, 22: 16200, 23: 1234, 24: 25, 25: 2500, 26: 3000},
    ),
    "R12": (
        3,
        [0, 59, 96, 251, 46, 251, 7, 8, 10, 40],
        {21: 0, 22: 15200, 23: -1234, 24: -5, 25: 1800, 26: 2600},
    ),
    "R13": (
        106,
        [0, 10, 0, 200, 15, 255, 0, 0, 1, 44, 4, 210],
        {46: 10, 47: 200, 48: 4095, 49: 0, 50: 300, 51: 1234},
    ),
    "R14": (107, [1, 44, 255, 211, 0, 0, 0, 12, 1], {54: 300, 55: -45, 56: 0, 57: 12, 58: 1}),
}
"""Vectors of the fact sheet: the packet that is asked for, its bytes, and their values."""
