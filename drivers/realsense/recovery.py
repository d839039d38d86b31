"""Decides what to do about a camera that gives no frames, and when, without touching it."""

from __future__ import annotations

from enum import Enum

_SILENCE = 2.0
"""Time without frames before the first step [s]."""
_FIRST_PAUSE, _LAST_PAUSE = 0.25, 2.0
"""Pauses, each double the last, between attempts with a missing or failing camera [s]."""
_RESET_TIME = 3.0
"""Time after a reset until the camera is back on the bus; it may stay listed at first [s]."""


class RecoveryStep(Enum):
    """The next step of recovery."""

    WAIT = "nothing yet"
    LET_GO = "letting go of streams whose camera has gone"
    OPEN = "opening its streams anew"
    RESET = "a hardware reset"
    GIVE_UP = "nothing any more"


class StreamRecovery:
    """One period without frames, up to the next frame or to giving up.

    The streams are reopened first; if that brings no frames, or fails twice, the camera is reset,
    and so on in turns. A camera that is not listed is waited for.
    """

    def __init__(self, since: float, limit: float, patience: float, now: float) -> None:
        """Start a period.

        Args:
            since: Start of the period [s].
            limit: Time after which recovery gives up [s].
            patience: Time for opened streams to bring their first frame [s].
            now: Present time [s].
        """
        self.since = since
        self.last_step: RecoveryStep | None = None
        self._limit = limit
        self._patience = patience
        self._due = max(now, since + min(_SILENCE, limit))
        self._pause = _FIRST_PAUSE
        self._opened = False
        self._failures = 0

    def lose(self, now: float) -> None:
        """Note that the streams broke, so that waiting is useless."""
        self._due = now

    def next(self, now: float, streaming: bool, listed: bool) -> RecoveryStep:
        """The step to do at `now` [s], with the camera `listed` on the bus or not."""
        if now - self.since >= self._limit:
            return RecoveryStep.GIVE_UP
        if now < self._due:
            return RecoveryStep.WAIT
        if not listed:
            self._opened, self._failures = False, 0
            self._delay(now)
            return RecoveryStep.LET_GO if streaming else RecoveryStep.WAIT
        if self._opened:
            self._opened, self._failures = False, 0
            self._due = now + _RESET_TIME
            self.last_step = RecoveryStep.RESET
        else:
            self._opened = True
            self._due = now + self._patience
            self.last_step = RecoveryStep.OPEN
        return self.last_step

    def fail(self, now: float) -> None:
        """Note that opening, the last step, has failed."""
        self._failures += 1
        self._opened = self._failures > 1
        self._delay(now)

    def _delay(self, now: float) -> None:
        self._due = now + self._pause
        self._pause = min(2 * self._pause, _LAST_PAUSE)
