"""Lights and songs by which the base tells a person what it does (manual, pages 16, 19 and 20).

No byte behind an opcode is an opcode: one that the line loses starts nothing.
"""

from __future__ import annotations

from drivers.roomba.commands import Leds, Opcode, encode
from vizbot.core.types import Feedback

_GREEN, _ORANGE, _RED = 0, 64, 255
_BRIGHT = 255
_SHORT, _LONG = 12, 24
"""Durations of notes [1/64 s]."""

_LIGHTS = {
    Feedback.LISTENING: (Leds.SPOT, _GREEN),
    Feedback.FOUND: (Leds.DEBRIS, _GREEN),
    Feedback.NOT_FOUND: (Leds(0), _ORANGE),
    Feedback.STUCK: (Leds.CHECK_ROBOT, _RED),
    Feedback.DOUBT: (Leds.SPOT, _ORANGE),
}
"""LEDs that are lit, and the colour of the power LED."""
_SONGS = {
    Feedback.LISTENING: ((76, _SHORT),),
    Feedback.FOUND: ((67, _SHORT), (72, _SHORT), (76, _LONG)),
    Feedback.NOT_FOUND: ((67, _SHORT), (62, _LONG)),
    Feedback.STUCK: ((50, _SHORT), (50, _SHORT), (50, _LONG)),
    Feedback.DOUBT: ((67, _SHORT), (74, _SHORT)),
}
"""Notes (MIDI numbers) and durations, in slots by their order."""


def songs() -> bytes:
    """Commands that put the songs into their slots; a base that was reset has forgotten them."""
    return b"".join(
        encode(Opcode.SONG, slot, *(number for note in notes for number in note))
        for slot, notes in enumerate(_SONGS.values())
    )


def shown(feedback: Feedback) -> bytes:
    """Commands that light the LEDs and play the song."""
    leds, colour = _LIGHTS[feedback]
    lights = encode(Opcode.LEDS, leds, colour, _BRIGHT)
    return lights + encode(Opcode.PLAY, list(_SONGS).index(feedback))
