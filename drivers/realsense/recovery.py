"""What to do about a camera that gives no frames, and when; decided without touching it."""

from __future__ import annotations

from enum import Enum

_SILENCE = 2.0
"""Frames are waited for so long before anything is done [s]."""
_FIRST_PAUSE, _LAST_PAUSE = 0.25, 2.0
"""A camera that is gone, or that does not open, is tried again after pauses that double [s]."""
_RESET_TIME = 3.0
"""A camera that was reset is off the bus for a while, and may still be listed before [s]."""


class RecoveryStep(Enum):
    """What is to be done next."""

    WAIT = "nothing yet"
    LET_GO = "letting go of streams whose camera has gone"
    OPEN = "opening its streams anew"
    RESET = "a hardware reset"
    GIVE_UP = "nothing any more"


class StreamRecovery:
    """One time without frames, from its beginning to the next frame or to giving up.

    Streams are opened anew first; if that brings no frames, or fails twice, the camera is reset,
    and so on in turns. A camera that is not listed is waited for.
    """

    def __init__(self, since: float, limit: float, patience: float, now: float) -> None:
        """Begin.

        Args:
            since: Frames are waited for since then [s].
            limit: It is given up after so long [s].
            patience: Streams that are opened get so long to bring their first frame [s].
            now: Of noticing [s].
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
        """The streams broke: there is nothing to wait for."""
        self._due = now

    def next(self, now: float, streaming: bool, listed: bool) -> RecoveryStep:
        """What is to be done now; the caller does it.

        Args:
            now: Time [s].
            streaming: Whether streams are open.
            listed: Whether the camera is on the bus.
        """
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
        """Opening, which was the last step, has failed."""
        self._failures += 1
        self._opened = self._failures > 1
        self._delay(now)

    def _delay(self, now: float) -> None:
        self._due = now + self._pause
        self._pause = min(2 * self._pause, _LAST_PAUSE)
