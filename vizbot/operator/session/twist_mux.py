"""A base that the robot's program, a person at the wheel, and everybody's stop share."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Self

from vizbot.core.errors import DeviceError
from vizbot.core.interfaces import Base
from vizbot.core.types import STOP, BaseState, Feedback, Twist
from vizbot.operator.session.drive_lease import DriveLease

ROBOT, ANYBODYS_STOP = "robot", "stop"
"""Who gives commands besides those who drive by hand."""
_FRESH = 1.0
"""A state that is older tells nothing any more [s]."""


class TwistMux:
    """A `Base`: whoever drives by hand comes before the program, and stop before both.

    Attributes:
        on_drive: Told who has given each command that the base was sent, and the command; by any
            thread, one at a time.
    """

    def __init__(
        self,
        base: Base,
        lease: DriveLease,
        stopped: threading.Event,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """Share a base.

        Args:
            base: Stays its owner's to close.
            lease: Says who drives by hand.
            stopped: While it is set nothing is driven.
            now: Time of the wall clock [s].
        """
        self._base = base
        self._lease = lease
        self._stopped = stopped
        self._now = now
        self._lock = threading.RLock()
        self._hand: str | None = None
        self.on_drive: Callable[[str, Twist], None] = lambda who, twist: None
        self._resumes = False
        self._docks = self._parked = False
        self._shows: Feedback | None = None
        self._told: tuple[float, BaseState] | None = None

    @property
    def state(self) -> BaseState | None:
        """What the base said last; None where that is too long ago."""
        told = self._told
        return told[1] if told is not None and self._now() - told[0] <= _FRESH else None

    def drive(self, twist: Twist) -> None:
        """As the base, unless somebody has stopped the robot or drives by hand."""
        with self._lock:
            if not self._stopped.is_set() and self._lease.holder is None:
                self._drive(ROBOT, twist)

    def hold(self) -> None:
        """Drive what is told by hand, or rest where the robot was stopped; call it all the time."""
        with self._lock:
            before, self._hand = self._hand, self._lease.holder
            who = before if self._hand is None else self._hand
            command = None
            if self._stopped.is_set():
                command = ANYBODYS_STOP, STOP
            elif who is not None:
                command = who, self._lease.twist() or STOP  # who has let go stops the wheels
            try:
                # A base that looks for its dock obeys nothing else; one that is there charges on.
                takes_back = self._docks and command is not None
                if self._resumes or takes_back or (self._parked and self._hand is not None):
                    self._resumes = False
                    self.resume()
                if self._shows is not None:
                    feedback, self._shows = self._shows, None
                    self._base.show(feedback)
                if command is not None:
                    self._drive(*command)
            except DeviceError:
                return  # whoever reads the base is told, too

    def resume_soon(self) -> None:
        """Have `hold` ask the base to obey again."""
        self._resumes = True

    def show_soon(self, feedback: Feedback) -> None:
        """Have `hold` show it."""
        self._shows = feedback

    def rest(self) -> None:
        """Stop the wheels now."""
        with self._lock:
            if self._docks:
                self.resume()
            self._drive(ROBOT, STOP)

    def resume(self) -> None:
        """As the base."""
        with self._lock:
            self._docks = self._parked = False
            self._base.resume()

    def dock(self) -> None:
        """As the base, unless somebody has stopped the robot or drives by hand."""
        with self._lock:
            if not self._stopped.is_set() and self._lease.holder is None:
                self._docks = True
                self._base.dock()

    def show(self, feedback: Feedback) -> None:
        """As the base."""
        with self._lock:
            self._base.show(feedback)

    def read(self) -> BaseState:
        """As the base."""
        with self._lock:
            state = self._base.read()
            self._told = self._now(), state
            if self._docks and state.docked:
                self._docks, self._parked = False, True
            return state

    def close(self) -> None:
        """Nothing: its owner closes the base."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def _drive(self, who: str, twist: Twist) -> None:
        self._base.drive(twist)
        self.on_drive(who, twist)
