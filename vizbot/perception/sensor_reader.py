"""Reads camera and base, and keeps the robot at rest while either of them is silent."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.interfaces import Base, Devices
from vizbot.core.program.interrupts import raise_held_interrupt
from vizbot.core.types import STOP, BaseState, RGBDFrame

log = logging.getLogger(__name__)

_WAKE_UP_TIME = 1.0
"""A base that answers again is in a mode that drives within this time [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class SensorReading:
    """The readings that a tick begins with.

    Attributes:
        frame: Newer than all before it.
        state: What the base reports; None without a base.
    """

    frame: RGBDFrame
    state: BaseState | None


class SensorReader:
    """Reads the next frame and base state, and waits for a device that is silent for a while."""

    def __init__(self, devices: Devices, camera_patience: float, base_patience: float) -> None:
        """Read nothing yet; camera and base may be silent for as long as their patience [s]."""
        self._devices = devices
        self._camera_patience = camera_patience
        self._base_patience = base_patience
        self._camera_silent_since: float | None = None
        self._base_silent_since: float | None = None
        self._base_back_since: float | None = None

    def next(self) -> SensorReading | None:
        """The next frame and the state of the base; None at the end of a recording.

        Raises:
            DeviceTimeoutError: camera or base have been silent for too long.
            DeviceError: one of them is gone or closed.
        """
        while (frame := self._read_camera()) is not None:
            base = self._devices.base
            state = None if base is None else self._read_base(base)
            if base is None or state is not None:
                return SensorReading(frame, state)
        return None

    def _read_camera(self) -> RGBDFrame | None:
        """The next frame, as soon as there is one; None at the end of a recording.

        A held interrupt may end the run here, where nothing is half done.
        """
        while True:
            raise_held_interrupt()
            try:
                frame = self._devices.camera.read()
            except DeviceTimeoutError as error:
                self._wait_for_camera(error)
                continue
            if self._camera_silent_since is not None:
                silence = self._devices.clock.now() - self._camera_silent_since
                log.warning("the camera sees again after %.1f s", silence)
                self._camera_silent_since = None
            return frame

    def _wait_for_camera(self, error: DeviceTimeoutError) -> None:
        """Stop the base: there is no camera frame."""
        now = self._devices.clock.now()
        if self._devices.base is not None:
            self._devices.base.drive(STOP)
        if self._camera_silent_since is None:
            log.warning("%s; waiting for it", error)
            self._camera_silent_since = now
        if self._devices.recorded or now - self._camera_silent_since >= self._camera_patience:
            raise error

    def _read_base(self, base: Base) -> BaseState | None:
        """The state of the base; None while it is silent or, touched by nobody, wakes up."""
        now = self._devices.clock.now()
        try:
            state = base.read()
        except DeviceTimeoutError as error:
            self._wait_for_base(error, now)
            return None
        if self._base_silent_since is None:
            return state
        if self._base_back_since is None:
            self._base_back_since = now
        waking_up = now - self._base_back_since < _WAKE_UP_TIME
        if waking_up and (state.buttons or not state.mode.obeys):
            touched = state.blocked or any(state.cliffs) or any(state.wheel_drops)
            # The buttons are left out: they may have been pressed to wake it up.
            asleep = not (touched or state.maybe_moved)
            return None if asleep else replace(state, buttons=frozenset())
        log.warning("the base answers again after %.1f s", now - self._base_silent_since)
        self._base_silent_since = self._base_back_since = None
        return state

    def _wait_for_base(self, error: DeviceTimeoutError, now: float) -> None:
        """Note the silence; the driver keeps the wheels at rest meanwhile."""
        if self._base_silent_since is None:
            log.warning("%s; waiting for it", error)
            self._base_silent_since = now
        self._base_back_since = None
        if now - self._base_silent_since >= self._base_patience:
            raise error
