"""Sensor stream of the Roomba Open Interface: frames with a checksum (manual, pages 21 to 22).

A frame is [19][N][id][data]...[id][data][checksum], N the bytes between N and the checksum; the low
byte of the sum of all bytes, header and checksum included, is 0. Nothing escapes a 19 in the data.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from drivers.roomba.packets import SIZES, Packet, decode_packets, encode_packets

HEADER = 19
PERIOD = 0.015
"""Time between two frames, and of the internal sensor refresh [s] (page 21)."""
_OVERHEAD = 3


def encode_sensor_frame(ids: Iterable[int], values: Mapping[Packet, int]) -> bytes:
    """One frame with the packets or groups `ids`.

    Raises:
        ValueError: an id is unknown, a value is out of range, or the frame holds over 255 bytes.
    """
    content = b"".join(bytes([number]) + encode_packets([number], values) for number in ids)
    frame = bytes([HEADER, len(content)]) + content
    return frame + bytes([-sum(frame) % 256])


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
        self._expected = None if ids is None else tuple(ids)
        self._buffer = bytearray()

    def feed(self, received: bytes) -> list[dict[Packet, int]]:
        """Values of the frames that `received` completes, oldest first."""
        self._buffer += received
        frames: list[dict[Packet, int]] = []
        while (header := self._buffer.find(HEADER)) >= 0:
            del self._buffer[:header]
            size = self._frame_size()
            if size is None:
                return frames
            if size > 0:
                frames.append(_decode_frame(bytes(self._buffer[:size])))
            del self._buffer[: max(size, 1)]
        self._buffer.clear()
        return frames

    def _frame_size(self) -> int | None:
        """Size of the frame at the start of the buffer: 0 if there is none, None if incomplete."""
        buffer, expected = self._buffer, self._expected
        if len(buffer) < 2:
            return None
        size = buffer[1] + _OVERHEAD
        if expected is not None and size != encoded_size(expected):
            return 0
        position, index = 2, 0
        while position < size - 1:
            if position >= len(buffer):
                return None
            found = buffer[position]
            if found not in SIZES or (expected is not None and found != expected[index]):
                return 0
            position, index = position + 1 + SIZES[found], index + 1
        if position != size - 1:
            return 0
        if len(buffer) < size:
            return None
        return size if sum(buffer[:size]) % 256 == 0 else 0


def _decode_frame(frame: bytes) -> dict[Packet, int]:
    values: dict[Packet, int] = {}
    position = 2
    while position < len(frame) - 1:
        end = position + 1 + SIZES[frame[position]]
        values |= decode_packets([frame[position]], frame[position + 1 : end])
        position = end
    return values
