"""What keys do while somebody drives by hand: without I/O, at times that are given."""

from __future__ import annotations

from collections.abc import Sequence

from vizbot.core.types import STOP, Twist
from vizbot.operator.teleop.held_keys import HeldKeys
from vizbot.operator.teleop.key_parser import Event, FocusLost, KeyboardFlags, KeyEvent, Stroke

STEPS = 9
FIRST_STEP = 4
_LINEAR, _ANGULAR = 0.05, 0.2
"""Speed of one step [m/s, rad/s]."""
_TOUCH_STEP = 2
"""Fastest step of a key that is not yet known to be held: the wheels must come to rest in time."""

_AHEAD, _BACK = frozenset({"up", "w"}), frozenset({"down", "s"})
_LEFT, _RIGHT = frozenset({"left", "a"}), frozenset({"right", "d"})
_DRIVES = _AHEAD | _BACK | _LEFT | _RIGHT

_EVENT_TYPES, _ALL_KEYS = 2, 8
_RELEASE_FLAGS = _EVENT_TYPES | _ALL_KEYS
"""Progressive enhancements of kitty's protocol that make a terminal report releases of letters."""


class KeyBindings:
    """Turns key events into twists and requests.

    Attributes:
        step: Speed step, 1 to `STEPS`.
        keys: The keys that drive.
        resumes: Whether the driver wants the base to obey again; reset by whoever asks the base.
        leaves: Whether the driver wants to stop driving.
        interrupts: Whether that was by Ctrl-C.
    """

    def __init__(self) -> None:
        self.step = FIRST_STEP
        self.keys = HeldKeys()
        self.resumes = self.leaves = self.interrupts = False

    def take(self, events: Sequence[Event], now: float) -> None:
        """Take events in their order, all of one time [s]."""
        for event in events:
            match event:
                case FocusLost():
                    self.keys.let_go()
                case KeyboardFlags(flags):
                    self.keys.expect_releases(flags & _RELEASE_FLAGS == _RELEASE_FLAGS)
                case KeyEvent(key, stroke) if key in _DRIVES:
                    self.keys.strike(key, stroke, now)
                case KeyEvent(key, stroke, text) if stroke is not Stroke.RELEASE:
                    # Keys that only act are known by what they type: + is not on every keyboard
                    # a key of its own.
                    self._act((text or key).lower())

    def twist(self, now: float) -> Twist:
        """The twist of the held keys; opposite ones cancel, and positive turns are to the left."""
        held = self.keys.held(now)
        ahead = bool(held & _AHEAD) - bool(held & _BACK)
        left = bool(held & _LEFT) - bool(held & _RIGHT)
        if not ahead and not left:
            return STOP
        step = self.step if self.keys.steady(now) else min(self.step, _TOUCH_STEP)
        return Twist(ahead * step * _LINEAR, left * step * _ANGULAR)

    @property
    def speed(self) -> float:
        """Speed ahead at the present step [m/s]."""
        return self.step * _LINEAR

    def _act(self, key: str) -> None:
        match key:
            case " ":
                self.keys.let_go()
            case "+" | "=":
                self.step = min(self.step + 1, STEPS)
            case "-" | "_":
                self.step = max(self.step - 1, 1)
            case "r":
                self.keys.let_go()
                self.resumes = True
            case "q" | "escape":
                self.keys.let_go()
                self.leaves = True
            case "ctrl+c":
                self.keys.let_go()
                self.leaves = self.interrupts = True
            case _ if len(key) == 1 and "1" <= key <= "9":
                self.step = int(key)
