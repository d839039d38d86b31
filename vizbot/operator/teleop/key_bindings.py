"""What keys do while somebody drives by hand: without I/O, at times that are given."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

from vizbot.core.types import STOP, Twist
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


FIRST_LAPSE = 0.525
"""A key counts as held this long after it went down [s], since its first repeat comes up to half a
second later. What it does meanwhile must end within the rest of 0.6 s."""
LAPSE = 0.35
"""A key counts as held this long after its last repeat [s]. Repeats come every 30 to 50 ms, over a
network perhaps later."""
_REPEATS = 0.12
"""Strokes closer than this are repeats of the terminal [s]: no finger is that fast."""
_LIVE = 0.015
"""Repeats that arrive as they are made are at least this far apart [s]."""
_FLOOD, _FLOOD_WITHIN = 12, 0.1
"""Strokes, and the time within which they come [s]: no terminal repeats faster, so that these were
delayed on the way and belong to the past."""
SILENCE = 0.14
"""A terminal that reports releases is asked all the time, and answers. After this time without an
answer [s] the link is lost, and perhaps a release with it."""


class HeldKeys:
    """Remembers which keys went down and have not gone up.

    Attributes:
        releases: Whether the terminal reports when a key goes up. Elsewhere only one key is held at
            a time, since only the last one repeats.
    """

    def __init__(self) -> None:
        self.releases = False
        self._lapses: dict[str, float] = {}
        self._latest, self._struck_at = "", -math.inf
        self._strokes: deque[float] = deque(maxlen=_FLOOD)
        self._steady_until = -math.inf
        self._heard_at = -math.inf

    def expect_releases(self, releases: bool) -> None:
        """Set whether the terminal reports releases; a change lets all keys go."""
        if releases != self.releases:
            self.releases = releases
            self.let_go()

    def hear(self, now: float) -> None:
        """Note that the terminal has sent something, whatever it was."""
        self._heard_at = now

    def strike(self, key: str, stroke: Stroke, now: float) -> None:
        """Note that a key went down, repeated or went up.

        Args:
            key: Its name.
            stroke: What it did. Where releases are reported, a key that was let go for another
                reason is held again once it goes down, or repeats twice at the pace of now.
            now: Time [s].
        """
        if stroke is Stroke.RELEASE:
            self._lapses.pop(key, None)
            return
        gap = now - self._struck_at if key == self._latest else math.inf
        self._latest, self._struck_at = key, now
        if self._floods(now):
            self.let_go()
        elif not self.releases:
            self._count(key, gap, now)
        elif stroke is Stroke.PRESS or _LIVE <= gap < _REPEATS:
            self._lapses[key] = math.inf

    def let_go(self) -> None:
        """Let all keys go; those that are still held must go down again, or repeat, to count."""
        self._lapses.clear()
        self._latest, self._steady_until = "", -math.inf

    def held(self, now: float) -> frozenset[str]:
        """Names of the keys that are held at a time [s]."""
        if self.releases and now - self._heard_at >= SILENCE:
            self.let_go()
        self._lapses = {key: lapse for key, lapse in self._lapses.items() if now < lapse}
        return frozenset(self._lapses)

    def steady(self, now: float) -> bool:
        """Whether a key is known to be held, rather than only touched."""
        return self.releases or now < self._steady_until

    def changes_at(self, now: float) -> float:
        """Next time at which a key lapses or stops being steady without input [s]; perhaps inf."""
        ends = [*self._lapses.values(), self._steady_until]
        if self.releases and self._lapses:
            ends.append(self._heard_at + SILENCE)
        return min((end for end in ends if end > now), default=math.inf)

    def _floods(self, now: float) -> bool:
        """Whether strokes come faster than any terminal sends them."""
        full = len(self._strokes) == _FLOOD
        oldest = self._strokes[0] if full else -math.inf
        self._strokes.append(now)
        return now - oldest < _FLOOD_WITHIN

    def _count(self, key: str, gap: float, now: float) -> None:
        """Note a stroke that went down or repeated, `gap` after the key's last one [s]."""
        again = key in self._lapses and now < self._lapses[key]
        repeats = again and gap < _REPEATS
        was_steady = again and now < self._steady_until
        # One that has repeated and now comes late may have been let go and pressed again.
        self._lapses = {key: now + (LAPSE if repeats else FIRST_LAPSE)}
        self._steady_until = now + LAPSE if repeats or was_steady else -math.inf
