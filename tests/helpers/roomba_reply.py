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
