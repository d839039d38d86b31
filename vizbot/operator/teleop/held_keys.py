"""Which keys are held now, as far as a terminal tells: no I/O, and no time but what is given."""

from __future__ import annotations

import math
from collections import deque

from vizbot.operator.teleop.key_parser import Stroke

FIRST_LAPSE = 0.525
"""A key repeats for the first time up to half a second after it went down, so it counts as held for
so long [s]. What it does meanwhile must end within the rest of 0.6 s."""
LAPSE = 0.35
"""A key that repeats does so every 30 to 50 ms; over a network it may come late. It counts as held
for so long after the last repeat [s]."""
_REPEATS = 0.12
"""No finger comes down again so soon [s]: that is the terminal's repeat."""
_LIVE = 0.015
"""Repeats that come as they are made are at least so far apart [s]."""
_FLOOD, _FLOOD_WITHIN = 12, 0.1
"""No terminal repeats more often than so many times within so long [s]: these were held up on the
way, and tell of the past."""
SILENCE = 0.14
"""A terminal that reports releases is asked all the time, and answers; one that was not heard for
so long [s] is lost, and with it the release that may have come."""


class HeldKeys:
    """Remembers what went down and has not gone up.

    Attributes:
        releases: Whether the terminal tells when a key goes up. Elsewhere only one key is held at a
            time, for only the last one repeats.
    """

    def __init__(self) -> None:
        """No key is held, and no release is expected to be told."""
        self.releases = False
        self._lapses: dict[str, float] = {}
        self._latest, self._struck_at = "", -math.inf
        self._strokes: deque[float] = deque(maxlen=_FLOOD)
        self._steady_until = -math.inf
        self._heard_at = -math.inf

    def expect_releases(self, releases: bool) -> None:
        """Whether the terminal tells them; what was held until it changed is let go."""
        if releases != self.releases:
            self.releases = releases
            self.let_go()

    def hear(self, now: float) -> None:
        """The terminal has sent something, whatever it was."""
        self._heard_at = now

    def strike(self, key: str, stroke: Stroke, now: float) -> None:
        """A key went down, repeated or went up.

        Args:
            key: Its name.
            stroke: What it did. Where releases are told, a key that was let go for another reason
                is held again once it goes down or repeats twice as it does now, not in the past.
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
        """No key is held any more; those that are must go down, or repeat, to be."""
        self._lapses.clear()
        self._latest, self._steady_until = "", -math.inf

    def held(self, now: float) -> frozenset[str]:
        """Names of the keys that are held; those that have lapsed are forgotten."""
        if self.releases and now - self._heard_at >= SILENCE:
            self.let_go()
        self._lapses = {key: lapse for key, lapse in self._lapses.items() if now < lapse}
        return frozenset(self._lapses)

    def steady(self, now: float) -> bool:
        """Whether a key is known to be held, and not only to have been touched."""
        return self.releases or now < self._steady_until

    def changes_at(self, now: float) -> float:
        """When a key lapses, or is steady no more, if nothing comes in [s]; may be infinite."""
        ends = [*self._lapses.values(), self._steady_until]
        if self.releases and self._lapses:
            ends.append(self._heard_at + SILENCE)
        return min((end for end in ends if end > now), default=math.inf)

    def _floods(self, now: float) -> bool:
        """Whether strokes come faster than any terminal makes them."""
        full = len(self._strokes) == _FLOOD
        oldest = self._strokes[0] if full else -math.inf
        self._strokes.append(now)
        return now - oldest < _FLOOD_WITHIN

    def _count(self, key: str, gap: float, now: float) -> None:
        """A key went down, or repeated: nobody knows which. `gap` is since its last stroke [s]."""
        again = key in self._lapses and now < self._lapses[key]
        repeats = again and gap < _REPEATS
        was_steady = again and now < self._steady_until
        # One that has repeated and now comes late may have been let go and pressed again.
        self._lapses = {key: now + (LAPSE if repeats else FIRST_LAPSE)}
        self._steady_until = now + LAPSE if repeats or was_steady else -math.inf
