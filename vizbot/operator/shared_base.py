"""A base that the robot's program, a person at the wheel, and everybody's stop share."""

from __future__ import annotations

import threading
from typing import Self

from vizbot.core.errors import DeviceError
from vizbot.core.interfaces import Base
from vizbot.core.types import STOP, BaseState, Feedback, Twist
from vizbot.operator.wheel import Wheel


class SharedBase:
    """A `Base`: whoever drives by hand comes before the program, and stop before both.

    Attributes:
        state: What the base said last; None before it was read.
    """

    def __init__(self, base: Base, wheel: Wheel, stopped: threading.Event) -> None:
        """Share a base.

        Args:
            base: Stays its owner's to close.
            wheel: Says who drives by hand.
            stopped: While it is set nothing is driven.
        """
        self._base = base
        self._wheel = wheel
        self._stopped = stopped
        self._lock = threading.RLock()
        self.state: BaseState | None = None

    def drive(self, twist: Twist) -> None:
        """As the base, unless somebody has stopped the robot or drives by hand."""
        with self._lock:
            if not self._stopped.is_set() and self._wheel.holder is None:
                self._base.drive(twist)

    def hold(self) -> None:
        """Drive what is told by hand, or rest where the robot was stopped; call it all the time."""
        with self._lock:
            twist = STOP if self._stopped.is_set() else self._wheel.twist()
            if twist is None:
                return
            try:
                self._base.drive(twist)
            except DeviceError:
                return  # whoever reads the base is told, too

    def rest(self) -> None:
        """Stop the wheels now."""
        with self._lock:
            self._base.drive(STOP)

    def resume(self) -> None:
        """As the base."""
        with self._lock:
            self._base.resume()

    def dock(self) -> None:
        """As the base."""
        with self._lock:
            self._base.dock()

    def show(self, feedback: Feedback) -> None:
        """As the base."""
        with self._lock:
            self._base.show(feedback)

    def read(self) -> BaseState:
        """As the base."""
        with self._lock:
            self.state = self._base.read()
            return self.state

    def close(self) -> None:
        """Nothing: its owner closes the base."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()
