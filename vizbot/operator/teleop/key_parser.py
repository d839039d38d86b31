"""Parses what a terminal sends for keys, from bytes to events: without I/O, at given times.

Plain terminals send a character, or an escape sequence for an arrow, when a key goes down and again
while it repeats. Those that speak the keyboard protocol of kitty (its document "Comprehensive
keyboard handling in terminals": event types, all keys as escape codes) report repeats and releases.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import IntEnum

PATIENCE = 0.1
"""Longest wait for the rest of a sequence [s]: an Esc without a rest is the key itself."""

_CSI = re.compile(rb"\x1b\[(?:\[[ -~]|([0-?]{0,64})([@-~]))")
"""Control sequence: parameters and final byte; without them F1 to F5 of the Linux console."""
_CSI_BEGUN = re.compile(rb"\x1b\[(?:\[|[0-?]{0,64})\Z")
_SS3 = re.compile(rb"\x1bO([@-~])")
_BROKEN = re.compile(rb"\x1b(?:\[[0-?]{0,64}|O)")
_ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}
_CODES = {27: "escape", 57417: "left", 57418: "right", 57419: "up", 57420: "down"}
"""Names of keys that type nothing; the arrows of the number pad have codes of their own."""
_SHIFT, _LOCKS = 1, 64 + 128
_CONTROL = 4


class Stroke(IntEnum):
    """What a key does; the numbers are those of kitty's event types."""

    PRESS = 1
    REPEAT = 2
    RELEASE = 3


@dataclass(frozen=True, slots=True)
class KeyEvent:
    """A key went down, repeated or went up.

    Attributes:
        key: `up`, `down`, `left`, `right`, `escape`, `ctrl+c`, or what it types without Shift; the
            same when it goes up.
        stroke: What the key did; plain terminals send repeats as presses.
        text: What it types now; empty if nothing, or not reported.
    """

    key: str
    stroke: Stroke = Stroke.PRESS
    text: str = ""


@dataclass(frozen=True, slots=True)
class KeyboardFlags:
    """The terminal's answer to the question which key events it reports.

    Attributes:
        flags: Progressive enhancements of kitty's protocol that are in force.
    """

    flags: int


@dataclass(frozen=True, slots=True)
class FocusLost:
    """The terminal's window gets no more keys, nor the releases of those that are held."""


Event = KeyEvent | KeyboardFlags | FocusLost


class KeyParser:
    """Turns a stream of bytes into events, wherever it is cut."""

    def __init__(self) -> None:
        self._pending = b""
        self._since = 0.0

    def feed(self, received: bytes, now: float) -> list[Event]:
        """Events that are complete with `received`, oldest first.

        Args:
            received: Bytes that came in since the last call. Call it without any, too, since only
                time shows whether an Esc stands alone.
            now: Time [s].
        """
        events: list[Event] = []
        if self._pending and now - self._since >= PATIENCE:
            if self._pending == b"\x1b":
                events.append(KeyEvent("escape"))
            self._pending = b""
        stream, at = self._pending + received, 0
        while at < len(stream):
            event, length = _first(stream[at : at + 80])
            if length == 0:
                break
            if event is not None:
                events.append(event)
            at += length
        if received:
            self._pending, self._since = stream[at:], now
        return events


def _first(stream: bytes) -> tuple[Event | None, int]:
    """The event at the beginning of the stream, if any, and its length; 0 while incomplete."""
    if stream[0] != 0x1B:
        return _typed(stream[0]), 1
    if stream in (b"\x1b", b"\x1bO") or _CSI_BEGUN.match(stream):
        return None, 0
    if found := _CSI.match(stream):
        parameters, final = found.groups(b"")
        return _control_event(parameters.decode(), final.decode()), found.end()
    if found := _SS3.match(stream):
        arrow = _ARROWS.get(found[1].decode())
        return None if arrow is None else KeyEvent(arrow), found.end()
    if broken := _BROKEN.match(stream):
        return None, broken.end()
    # Alt with a key looks the same as Esc and a key at once: who wants to leave must be understood.
    return KeyEvent("escape"), 1


def _typed(byte: int) -> KeyEvent | None:
    if byte == 0x03:
        return KeyEvent("ctrl+c")
    if 0x20 <= byte < 0x7F:
        return KeyEvent(chr(byte).lower(), text=chr(byte))
    return None


def _control_event(parameters: str, final: str) -> Event | None:
    """The event of a control sequence, if it is of use here."""
    if final == "O" and not parameters:
        return FocusLost()
    if final == "u" and parameters.startswith("?"):
        return KeyboardFlags(_number(parameters[1:], 0))
    if final != "u" and final not in _ARROWS:
        return None
    codes, strokes, texts, *_ = [*parameters.split(";"), "", "", ""]
    modifiers, _, kind = strokes.partition(":")
    stroke = _number(kind, Stroke.PRESS)
    key = _ARROWS[final] if final != "u" else _key(_number(codes.partition(":")[0], 0))
    if key is None or stroke not in tuple(Stroke):
        return None
    others = (_number(modifiers, 1) - 1) & ~(_SHIFT | _LOCKS)
    if others and stroke != Stroke.RELEASE:  # a key that was held is let go with Alt, too
        return KeyEvent("ctrl+c", Stroke(stroke)) if (key, others) == ("c", _CONTROL) else None
    text = _key(_number(texts, 0)) or ""
    return KeyEvent(key, Stroke(stroke), text)


def _key(code: int) -> str | None:
    """Name of a Unicode code point, or of a key that has none."""
    if code in _CODES:
        return _CODES[code]
    return chr(code).lower() if 0x20 <= code < 0x7F else None


def _number(digits: str, otherwise: int) -> int:
    return int(digits) if digits.isdecimal() else otherwise
