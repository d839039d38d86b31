"""Lights and songs of the base that show what the robot does (manual, pages 16, 19 and 20).

No data byte of these commands is an opcode: where the line loses an opcode, its data start nothing.
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
"""Lit LEDs, and the colour of the power LED, for each feedback."""
_SONGS = {
    Feedback.LISTENING: ((76, _SHORT),),
    Feedback.FOUND: ((67, _SHORT), (72, _SHORT), (76, _LONG)),
    Feedback.NOT_FOUND: ((67, _SHORT), (62, _LONG)),
    Feedback.STUCK: ((50, _SHORT), (50, _SHORT), (50, _LONG)),
    Feedback.DOUBT: ((67, _SHORT), (74, _SHORT)),
}
"""Notes (MIDI numbers) and durations; the order gives the slot of each song."""


def songs() -> bytes:
    """Commands that store the songs in their slots, which a reset of the base clears."""
    return b"".join(
        encode(Opcode.SONG, slot, *(number for note in notes for number in note))
        for slot, notes in enumerate(_SONGS.values())
    )


def show_feedback(feedback: Feedback) -> bytes:
    """Commands that light the LEDs and play the song."""
    leds, colour = _LIGHTS[feedback]
    lights = encode(Opcode.LEDS, leds, colour, _BRIGHT)
    return lights + encode(Opcode.PLAY, list(_SONGS).index(feedback))
