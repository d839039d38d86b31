"""Frames and states that can be believed; while there are none, the robot is at rest."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

from vizbot.core.devices import Devices
from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.interfaces import Base
from vizbot.core.types import STOP, BaseState, RGBDFrame

_WAKING = 1.0
"""A base that speaks again obeys again within so long [s]."""


class Patience:
    """Reads a base that may be silent, and gives up on one that stays so."""

    def __init__(self, limit: float) -> None:
        """Wait for up to `limit` [s] at a time."""
        self._limit = limit
        self._silent_since: float | None = None
        self._back_since: float | None = None

    def read(self, base: Base, now: float) -> BaseState | None:
        """What the base feels at `now` [s]; None while it is silent or, untouched, wakes up.

        Buttons that are pressed while it wakes up are left out: they may be what woke it.

        Raises:
            DeviceTimeoutError: it has been for too long.
            DeviceError: it is gone or closed.
        """
        try:
            state = base.read()
        except DeviceTimeoutError as error:
            if self._silent_since is None:
                log.warning("%s; waiting for it", error)
                self._silent_since = now
            self._back_since = None
            if now - self._silent_since >= self._limit:
                raise
            return None
        if self._silent_since is None:
            return state
        if self._back_since is None:
            self._back_since = now
        if (not state.mode.obeys or state.buttons) and now - self._back_since < _WAKING:
            touched = state.blocked or any(state.cliffs) or any(state.wheel_drops)
            return replace(state, buttons=frozenset()) if touched else None
        log.warning("the base answers again after %.1f s", now - self._silent_since)
        self._silent_since = self._back_since = None
        return state


log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class SensorReading:
    """What a tick begins with.

    Attributes:
        frame: Newer than any before.
        state: What the base feels; None without a base.
    """

    frame: RGBDFrame
    state: BaseState | None


class SensorReader:
    """Reads camera and base, and waits for either when it is silent."""

    def __init__(self, devices: Devices, camera_patience: float, base_patience: float) -> None:
        """Wait for the camera and for the base for up to so long at a time [s]."""
        self._devices = devices
        self._limit = camera_patience
        self._base = Patience(base_patience)
        self._unseen_since: float | None = None

    def next(self) -> SensorReading | None:
        """The next frame and what the base feels; None at the end of a recording.

        Raises:
            DeviceTimeoutError: camera or base have been silent for too long.
            DeviceError: one of them is gone or closed.
        """
        while True:
            frame = self._see()
            if frame is None:
                return None
            base = self._devices.base
            state = None if base is None else self._base.read(base, self._devices.clock.now())
            if base is None or state is not None:
                return SensorReading(frame, state)

    def _see(self) -> RGBDFrame | None:
        """The next frame, however long it takes within the patience."""
        while True:
            try:
                frame = self._devices.camera.read()
            except DeviceTimeoutError as error:
                self._wait(error)
                continue
            if self._unseen_since is not None:
                now = self._devices.clock.now()
                log.warning("the camera sees again after %.1f s", now - self._unseen_since)
                self._unseen_since = None
            return frame

    def _wait(self, error: DeviceTimeoutError) -> None:
        """Stop: the robot has its eyes closed."""
        now = self._devices.clock.now()
        if self._devices.base is not None:
            self._devices.base.drive(STOP)
        if self._unseen_since is None:
            log.warning("%s; waiting for it", error)
            self._unseen_since = now
        if self._devices.recorded or now - self._unseen_since >= self._limit:
            raise error
