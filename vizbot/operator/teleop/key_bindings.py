"""What the keys of a person who drives by hand mean: no I/O, and no time but what is given."""

from __future__ import annotations

from collections.abc import Sequence

from vizbot.core.types import STOP, Twist
from vizbot.operator.teleop.held_keys import HeldKeys
from vizbot.operator.teleop.key_parser import Event, FocusLost, KeyboardFlags, KeyEvent, Stroke

STEPS = 9
FIRST_STEP = 4
_LINEAR, _ANGULAR = 0.05, 0.2
"""Of one speed step [m/s, rad/s]."""
_TOUCH_STEP = 2
"""Until a key is known to be held it drives no faster: the wheels must come to rest in time."""

_AHEAD, _BACK = frozenset({"up", "w"}), frozenset({"down", "s"})
_LEFT, _RIGHT = frozenset({"left", "a"}), frozenset({"right", "d"})
_DRIVES = _AHEAD | _BACK | _LEFT | _RIGHT

_EVENT_TYPES, _ALL_KEYS = 2, 8
_TELLS_RELEASES = _EVENT_TYPES | _ALL_KEYS
"""Progressive enhancements of kitty's protocol without which letters are not reported going up."""


class KeyBindings:
    """Turns key events into what the base shall do.

    Attributes:
        step: Speed step, 1 to `STEPS`.
        keys: Those that drive.
        resumes: The person wants the base to obey again; whoever asks it takes this back.
        leaves: The person wants to stop driving.
        interrupts: By Ctrl-C.
    """

    def __init__(self) -> None:
        """Stand still, at a walking child's pace once a key is held."""
        self.step = FIRST_STEP
        self.keys = HeldKeys()
        self.resumes = self.leaves = self.interrupts = False

    def take(self, events: Sequence[Event], now: float) -> None:
        """Events in the order in which they came, at a time [s]."""
        for event in events:
            match event:
                case FocusLost():
                    self.keys.let_go()
                case KeyboardFlags(flags):
                    self.keys.expect_releases(flags & _TELLS_RELEASES == _TELLS_RELEASES)
                case KeyEvent(key, stroke) if key in _DRIVES:
                    self.keys.strike(key, stroke, now)
                case KeyEvent(key, stroke, text) if stroke is not Stroke.RELEASE:
                    # Keys that only act are known by what they type: + is not on every keyboard
                    # a key of its own.
                    self._act((text or key).lower())

    def twist(self, now: float) -> Twist:
        """What the held keys ask for; opposite ones cancel, and turning is to the robot's left."""
        held = self.keys.held(now)
        ahead = bool(held & _AHEAD) - bool(held & _BACK)
        left = bool(held & _LEFT) - bool(held & _RIGHT)
        if not ahead and not left:
            return STOP
        step = self.step if self.keys.steady(now) else min(self.step, _TOUCH_STEP)
        return Twist(ahead * step * _LINEAR, left * step * _ANGULAR)

    @property
    def speed(self) -> float:
        """Ahead, at the present step [m/s]."""
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
