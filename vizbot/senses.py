"""Frames and states that can be believed; while there are none, the robot is at rest."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.types import STOP, BaseState, RGBDFrame
from vizbot.patience import Patience
from vizbot.rig import Devices

log = logging.getLogger(__name__)

_CLOCKS_APART = 1.0
"""A camera whose clock gains so much on ours between two frames has been set anew [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Sensed:
    """What a tick begins with.

    Attributes:
        frame: Newer than any before, by a clock that never jumps.
        state: What the base feels; None without a base.
    """

    frame: RGBDFrame
    state: BaseState | None


class Senses:
    """Reads camera and base, and waits for either when it is silent."""

    def __init__(self, devices: Devices, patience: float) -> None:
        """Wait for up to `patience` [s] at a time."""
        self._devices = devices
        self._limit = patience
        self._base = Patience(patience)
        self._unseen_since: float | None = None
        self._last: tuple[float, float] | None = None
        self._set_back = 0.0

    def next(self) -> Sensed | None:
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
                return Sensed(frame, state)

    def _see(self) -> RGBDFrame | None:
        """The next frame, however long it takes within the patience."""
        while True:
            try:
                frame = self._devices.camera.read()
            except DeviceTimeoutError as error:
                self._wait(error)
                continue
            now = self._devices.clock.now()
            if self._unseen_since is not None:
                log.warning("the camera sees again after %.1f s", now - self._unseen_since)
                self._unseen_since = None
            if frame is None or self._devices.recorded:
                return frame
            return self._in_step(frame, now)

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

    def _in_step(self, frame: RGBDFrame, now: float) -> RGBDFrame:
        """The frame with the stamps that it would have if the camera's clock had never jumped."""
        if self._last is not None:
            stamp_before, now_before = self._last
            gained = frame.stamp - stamp_before - (now - now_before)
            if frame.stamp <= stamp_before or gained > _CLOCKS_APART:
                log.warning("the camera's clock jumped by %.1f s: going on by ours", gained)
                self._set_back += gained
        self._last = frame.stamp, now
        if self._set_back == 0.0:
            return frame
        imu = replace(
            frame.imu,
            gyro_stamps=frame.imu.gyro_stamps - self._set_back,
            accel_stamps=frame.imu.accel_stamps - self._set_back,
        )
        return replace(frame, stamp=frame.stamp - self._set_back, imu=imu)
