"""Sensor frames of the simulated Roomba, as in the manual, except for the mode."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from drivers.roomba.packets import Packet, encode_packets, singles
from drivers.roomba.stream import HEADER


def encode_reply(ids: Iterable[int], values: Mapping[Packet, int]) -> bytes:
    """The bare data of `ids`, as `encode_packets` has it.

    The mode may be any byte: some firmware of the 600 series calls Full mode 4.

    Raises:
        ValueError: an id is unknown, or a value is outside the range of its packet.
    """
    return b"".join(
        bytes([values[packet]]) if packet is Packet.OI_MODE else encode_packets([packet], values)
        for packet in singles(ids)
    )


def encode_stream_frame(ids: Iterable[int], values: Mapping[Packet, int]) -> bytes:
    """One frame of the stream (manual, pages 21 to 22).

    Raises:
        ValueError: likewise, or the frame holds over 255 bytes.
    """
    content = b"".join(bytes([number]) + encode_reply([number], values) for number in ids)
    frame = bytes([HEADER, len(content)]) + content
    return frame + bytes([-sum(frame) % 256])
