"""Songs of the simulated Roomba: silent, but they last as long as the notes say."""

from __future__ import annotations

from drivers.roomba.packets import Packet

_TICKS_PER_SECOND = 64


class Songs:
    """The five slots, and the song that is playing."""

    def __init__(self) -> None:
        self.slots: dict[int, tuple[tuple[int, int], ...]] = {}
        """Note and duration [1/64 s] of every song that was defined."""
        self._selected = 0
        self._left = 0.0

    def define(self, slot: int, *notes: int) -> None:
        """Fill a slot with notes and durations in turns."""
        self.slots[slot] = tuple(zip(notes[::2], notes[1::2], strict=True))

    def play(self, slot: int) -> None:
        """Play the song of a slot; an empty slot ends at once."""
        self._selected = slot
        notes = self.slots.get(slot, ())
        self._left = sum(duration for _, duration in notes) / _TICKS_PER_SECOND

    def advance(self, seconds: float) -> None:
        """Play on for `seconds`."""
        self._left = max(0.0, self._left - seconds)

    def packets(self) -> dict[Packet, int]:
        """Packets 36 and 37 as they stand."""
        return {Packet.SONG_NUMBER: self._selected, Packet.SONG_PLAYING: int(self._left > 0)}
