"""Sensor stream of the Roomba Open Interface: frames with a checksum (manual, pages 21 to 22).

A frame is [19][N][id][data]...[id][data][checksum], N the bytes between N and the checksum; the low
byte of the sum of all bytes, header and checksum included, is 0. Nothing escapes a 19 in the data.

Some firmware has a bit or a state more than the manual of the 600 series, in every frame. Frames
that a spoilt line made up and that pass their checksum by chance have such values, too, but not
the same ones again and again.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache

from drivers.roomba.packets import (
    SIZES,
    Packet,
    nearest_allowed,
    out_of_range,
    singles,
    wire_codes,
    within_ranges,
)

logger = logging.getLogger(__name__)

HEADER = 19
PERIOD = 0.015
"""Time between two frames, and of the internal sensor refresh [s] (page 21)."""
_OVERHEAD = 3


@dataclass(frozen=True, slots=True)
class _FrameLayout:
    """Layout of the frames with the same ids.

    Attributes:
        packets: The packets whose data the frames hold, in order.
        data: All data of a frame; other bytes are padding.
        places: Position of every id in a frame.
        ids: Every id.
    """

    packets: tuple[Packet, ...]
    data: struct.Struct
    places: tuple[int, ...]
    ids: bytes


@lru_cache(maxsize=256)
def _frame_layout(ids: tuple[int, ...]) -> _FrameLayout:
    places, position, codes = [], 2, ">xx"
    for number in ids:
        places.append(position)
        codes += "x" + wire_codes(singles([number]))
        position += 1 + SIZES[number]
    return _FrameLayout(singles(ids), struct.Struct(codes + "x"), tuple(places), bytes(ids))


def encode_sensor_frame(
    ids: Iterable[int], values: Mapping[Packet, int], unlimited: Packet | None = None
) -> bytes:
    """One frame with packets or groups `ids`; `unlimited` has any value that fits its bytes.

    Raises:
        ValueError: an id is unknown, a value is out of range, or the frame holds over 255 bytes.
    """
    layout = _frame_layout(tuple(ids))
    frame = bytearray(layout.data.pack(*within_ranges(layout.packets, values, unlimited)))
    frame[:2] = bytes([HEADER, len(frame) - _OVERHEAD])
    for position, number in zip(layout.places, layout.ids, strict=True):
        frame[position] = number
    frame[-1] = -sum(frame) % 256
    return bytes(frame)


def encoded_size(ids: Iterable[int]) -> int:
    """Bytes of a frame with the packets or groups `ids`."""
    return _OVERHEAD + sum(1 + SIZES[id_] for id_ in ids)


class StreamParser:
    """Finds frames in the bytes of the line, and synchronises again after garbage.

    A header counts only if it starts a whole frame: known ids, their lengths, the sum. Otherwise
    the search continues at the byte after it, so that garbage costs only the frames it hit. A
    corrupt frame passes by chance, once in 256 times where ids and lengths still match.
    """

    def __init__(self, ids: Iterable[int] | None = None) -> None:
        """Expect frames with exactly the packets `ids`, or any frame.

        With `ids` a false header is dropped as soon as it differs from the requested frames,
        instead of after up to 258 bytes.
        """
        self._expected = None if ids is None else _frame_layout(tuple(ids))
        self._buffer = bytearray()

    def feed(self, received: bytes) -> list[dict[Packet, int]]:
        """Values of the frames that `received` completes, oldest first."""
        self._buffer += received
        frames: list[dict[Packet, int]] = []
        while (header := self._buffer.find(HEADER)) >= 0:
            del self._buffer[:header]
            ids = self._frame_ids()
            if ids is None:
                return frames
            layout = _frame_layout(ids)
            if ids:
                values = layout.data.unpack_from(self._buffer)
                frames.append(dict(zip(layout.packets, values, strict=True)))
            del self._buffer[: layout.data.size if ids else 1]
        self._buffer.clear()
        return frames

    def _frame_ids(self) -> tuple[int, ...] | None:
        """Ids of the frame at the start of the buffer: () if there is none, None if incomplete."""
        buffer, expected = self._buffer, self._expected
        if len(buffer) < 2:
            return None
        size = buffer[1] + _OVERHEAD
        if expected is not None:
            if size != expected.data.size:
                return ()
            if len(buffer) >= size:
                found_ids = bytes(map(buffer.__getitem__, expected.places))
                sound = found_ids == expected.ids and sum(buffer[:size]) % 256 == 0
                return tuple(expected.ids) if sound else ()
        ids: list[int] = []
        position = 2
        while position < size - 1:
            if position >= len(buffer):
                return None
            found = buffer[position]
            if found not in SIZES or (expected is not None and expected.ids[len(ids)] != found):
                return ()
            ids.append(found)
            position += 1 + SIZES[found]
        if position != size - 1:
            return ()
        if len(buffer) < size:
            return None
        return tuple(ids) if sum(buffer[:size]) % 256 == 0 else ()


_FRAMES = 5
"""Frames in a row with the same odd packets from which on they are the base's own."""


class OddValues:
    """Learns which packets of a base have values outside the manual, and replaces those values."""

    def __init__(self, name: str) -> None:
        """`name` of the port, for messages."""
        self._name = name
        self._known: set[Packet] = set()
        self._last: tuple[Packet, ...] = ()
        self._in_a_row = 0

    def corrected(self, values: Mapping[Packet, int]) -> Mapping[Packet, int] | None:
        """The values of a frame within the manual's ranges; None for a frame to be dropped."""
        odd = out_of_range(values)
        self._in_a_row = self._in_a_row + 1 if odd == self._last else 1
        self._last = odd
        if not odd:
            return values
        unknown = [packet for packet in odd if packet not in self._known]
        if Packet.OI_MODE in odd or (unknown and self._in_a_row < _FRAMES):
            logger.debug("%s: dropped an impossible sensor frame: %s", self._name, values)
            return None
        for packet in unknown:
            logger.warning(
                "%s: this base sends %d as %s (packet %d), which its manual does not have;"
                " %d is taken for it",
                self._name,
                values[packet],
                packet.name.lower().replace("_", " "),
                packet,
                nearest_allowed(packet, values[packet]),
            )
        self._known.update(unknown)
        return {**values, **{packet: nearest_allowed(packet, values[packet]) for packet in odd}}
