"""A base that the program, a person who drives, and a stop by anybody share."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from vizbot.core.closeable import Closeable
from vizbot.core.errors import DeviceError
from vizbot.core.interfaces import Base
from vizbot.core.types import STOP, BaseState, Feedback, Twist
from vizbot.operator.session.drive_lease import DriveLease

ROBOT, ANYBODYS_STOP = "robot", "stop"
"""Who gives commands besides people who drive by hand."""
_FRESH, _BATTERY_FRESH = 1.0, 10.0
"""Age from which a state of the base counts as none, and from which its battery does [s]."""


class TwistMux(Closeable):
    """A `Base` whose driver by hand overrides the program, and whose stop overrides both.

    Attributes:
        on_drive: Called with who gave it and the command, for each that the base was sent; by any
            thread, one at a time.
    """

    def __init__(
        self,
        base: Base,
        lease: DriveLease,
        stopped: threading.Event,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._base = base
        self._lease = lease
        self._stopped = stopped
        self._now = now
        self._lock = threading.RLock()
        self._driver: str | None = None
        self.on_drive: Callable[[str, Twist], None] = lambda who, twist: None
        self._resume_pending = False
        self._docking = self._parked = False
        self._pending_feedback: Feedback | None = None
        self._newest: tuple[float, BaseState] | None = None

    @property
    def state(self) -> BaseState | None:
        """The newest state of the base; None where that is too old."""
        return self._state_within(_FRESH)

    @property
    def battery_state(self) -> BaseState | None:
        """The state for the battery, which may be older: a busy machine empties no battery."""
        return self._state_within(_BATTERY_FRESH)

    def _state_within(self, age: float) -> BaseState | None:
        newest = self._newest
        return newest[1] if newest is not None and self._now() - newest[0] <= age else None

    def drive(self, twist: Twist) -> None:
        """Drive, unless somebody has stopped the robot or drives by hand."""
        with self._lock:
            if not self._stopped.is_set() and self._lease.holder is None:
                self._drive(ROBOT, twist)

    def hold(self) -> None:
        """Repeat the command of the driver by hand, or of a stop; to be called all the time."""
        with self._lock:
            before, self._driver = self._driver, self._lease.holder
            who = before if self._driver is None else self._driver
            command = None
            if self._stopped.is_set():
                command = ANYBODYS_STOP, STOP
            elif who is not None:
                command = who, self._lease.twist() or STOP  # who has let go stops the wheels
            try:
                # A base that looks for its dock obeys nothing else; one that is there charges on.
                takes_back = self._docking and command is not None
                if (
                    self._resume_pending
                    or takes_back
                    or (self._parked and self._driver is not None)
                ):
                    self._resume_pending = False
                    self.resume()
                if self._pending_feedback is not None:
                    feedback, self._pending_feedback = self._pending_feedback, None
                    self._base.show(feedback)
                if command is not None:
                    self._drive(*command)
            except DeviceError:
                return  # whoever reads the base gets this error, too

    def resume_soon(self) -> None:
        """Ask the base to obey again at the next `hold`."""
        self._resume_pending = True

    def show_soon(self, feedback: Feedback) -> None:
        """Show feedback at the next `hold`."""
        self._pending_feedback = feedback

    def rest(self) -> None:
        """Stop the wheels now."""
        with self._lock:
            if self._docking:
                self.resume()
            self._drive(ROBOT, STOP)

    def resume(self) -> None:
        """Ask the base to obey again."""
        with self._lock:
            self._docking = self._parked = False
            self._base.resume()

    def dock(self) -> None:
        """Dock, unless somebody has stopped the robot or drives by hand."""
        with self._lock:
            if not self._stopped.is_set() and self._lease.holder is None:
                self._docking = True
                self._base.dock()

    def show(self, feedback: Feedback) -> None:
        """Show feedback by the base's lights and speaker."""
        with self._lock:
            self._base.show(feedback)

    def read(self) -> BaseState:
        """Read the base's newest state."""
        with self._lock:
            state = self._base.read()
            self._newest = self._now(), state
            if self._docking and state.docked:
                self._docking, self._parked = False, True
            return state

    def close(self) -> None:
        """Do nothing: the owner closes the base."""

    def _drive(self, who: str, twist: Twist) -> None:
        self._base.drive(twist)
        self.on_drive(who, twist)
