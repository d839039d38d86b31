"""Values that the manual does not allow, of a base that sends them in every frame.

Some firmware has a bit or a state more than the manual of the 600 series. Frames that a spoilt line
made up and that pass their checksum by chance have such values, too, but not the same ones again
and again.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping

from drivers.roomba.packets import Packet, nearest_allowed, out_of_range

logger = logging.getLogger(__name__)

_FRAMES = 5
"""Frames in a row with the same odd packets from which on they are the base's own."""


class OddValues:
    """Learns which packets of a base have values of their own, and replaces those values."""

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
