"""Infrared characters that the Roomba receives: packets 17, 52 and 53 (manual, pages 26 to 27)."""

from __future__ import annotations

from enum import IntFlag


class DockBeam(IntFlag):
    """Beams of a dock at the receiver.

    For a robot that faces the dock, the green beam is on the left and the red one on the right; the
    force field surrounds the dock.
    """

    FORCE_FIELD = 1
    GREEN = 4
    RED = 8


def dock_beams(character: int) -> DockBeam | None:
    """Beams of a 600-series (160 to 173) or Discovery dock (240 to 254); None if it is of neither.

    The character is 160 + 8 red + 4 green + 1 field, or 240 + 8 red + 4 green + 2 field.
    """
    for first, field in ((160, 1), (240, 2)):
        bits = character - first
        if 0 <= bits < 16 and bits & ~(8 | 4 | field) == 0:
            return DockBeam(bits & 12) | (DockBeam.FORCE_FIELD if bits & field else DockBeam(0))
    return None
