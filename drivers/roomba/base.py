"""The Roomba as a `Base`.

`control` decides which bytes are sent, `service` owns the port, and this class is what the rest of
the robot drives. It was written against the manual and `sim_stubs.roomba.base` and was never tried
on a real base.
"""

from __future__ import annotations

import math

from drivers.roomba.config import RoombaConfig
from drivers.roomba.service import Drive, Link, Resume, SeekDock, Show, Trouble
from drivers.roomba.state import with_contacts
from drivers.roomba.stream import PERIOD
from vizbot.core.closeable import Closeable
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.interfaces import Clock
from vizbot.core.types import BaseState, Feedback, Twist


class Roomba(Closeable):
    """A Create 2 or 600-series Roomba in Safe (or Full) mode."""

    def __init__(self, link: Link, clock: Clock, config: RoombaConfig) -> None:
        """Wait until the base streams and is in Safe (or Full) mode.

        `link` leads to the service that owns the port; it is closed with the base, and when this
        fails.

        Raises:
            DeviceError: nothing on the port answers like a Roomba, or the base stays in another
                mode.
        """
        self._link = link
        self._clock = clock
        self._config = config
        self._state: BaseState | None = None
        self._unread: BaseState | None = None
        self._trouble = Trouble("")
        self._closed = False
        try:
            self._await_mode()
        except BaseException:
            self.close()
            raise

    def drive(self, twist: Twist) -> None:
        """Hold `twist`, same curvature if too fast, until the next call.

        It has no effect while the base is in another mode or cannot be reached.

        Raises:
            DeviceError: the base is gone for good or closed.
            ValueError: the twist is not finite.
        """
        if not (math.isfinite(twist.linear) and math.isfinite(twist.angular)):
            raise ValueError(f"{twist} is not finite")
        self._receive()
        self._require_open()
        self._link.send(Drive(twist, self._clock.now()))

    def read(self) -> BaseState:
        """Return the newest odometry, and every contact since the call before.

        Raises:
            DeviceTimeoutError: the base is silent or unplugged; the service looks for it.
            DeviceError: the base is gone for good or closed.
        """
        self._receive()
        self._require_open()
        if self._trouble.message:
            raise DeviceTimeoutError(self._trouble.message)
        state, limit = self._state, self._config.silence_timeout
        if state is None or self._clock.now() - state.stamp > limit + 1e-9:
            message = f"{self._link.name}: no answer from the base for {limit} s"
            raise DeviceTimeoutError(f"{message}; check its cable and battery, press Clean")
        unread, self._unread = self._unread, None
        return unread or state

    def resume(self) -> None:
        """Stop the wheels and request Safe mode, after a cliff or a wheel drop ended it.

        `read().mode` shows whether the base has followed.

        Raises:
            DeviceError: the base is gone for good or closed.
        """
        self._require_open()
        self._link.send(Resume())

    def dock(self) -> None:
        """Have the base look for its dock by itself; it ignores drive() until resume().

        Raises:
            DeviceError: the base is gone for good or closed.
        """
        self._require_open()
        self._link.send(SeekDock())

    def show(self, feedback: Feedback) -> None:
        """Light the LEDs and play a song.

        Raises:
            DeviceError: the base is gone for good or closed.
        """
        self._require_open()
        self._link.send(Show(feedback))

    def close(self) -> None:
        """Stop the wheels, leave the base in Passive mode so that it can charge, free the port."""
        if not self._closed:
            self._closed = True
            self._link.close()

    def _receive(self) -> None:
        """Process the reports of the service."""
        for report in () if self._closed else self._link.receive():
            if isinstance(report, Trouble):
                self._trouble = report
                continue
            self._state = report
            before, self._unread = self._unread, report
            if before is not None:
                self._unread = with_contacts(report, before)

    def _require_open(self) -> None:
        if self._closed:
            raise DeviceError(f"{self._link.name}: the base is closed; open it again")
        if self._trouble.final:
            raise DeviceError(self._trouble.message)

    def _await_mode(self) -> None:
        deadline = self._clock.now() + self._config.start_timeout
        while self._clock.now() < deadline:
            self._receive()
            self._require_open()
            if self._state is not None and self._state.mode.obeys:
                return
            self._clock.sleep(PERIOD)
        name, state = self._link.name, self._state
        if state is None and self._trouble.message:
            raise DeviceError(self._trouble.message)
        if state is None:
            message = f"{name} is not a Roomba or is asleep: it sends no sensor frames"
            raise DeviceError(f"{message}; press Clean, then check the cable and the port's name")
        message = f"{name}: the base stays in {state.mode.name.title()} mode"
        raise DeviceError(f"{message}; {_remedy(state)}")


def _remedy(state: BaseState) -> str:
    """Remedy for a base that does not stay in Safe mode."""
    if state.on_charger:
        return "take it off its charger"
    if any(state.wheel_drops):
        return "a wheel hangs: put it on the floor"
    if any(state.cliffs):
        return "it stands at an edge: put it elsewhere"
    return "put it on the floor, off its charger, away from edges"
