"""The Roomba as a `Base`: Open Interface over a serial port, odometry, watchdog, reflexes.

Not yet tried on a real base: it was written against the manual and `sim_stubs.roomba`.
"""

from __future__ import annotations

import logging
import math
import threading
from collections.abc import Callable, Mapping
from typing import Self

from pydantic import BaseModel, Field

from drivers.reflexes import allowed
from drivers.roomba_oi import Opcode, encode
from drivers.roomba_packets import Packet, in_range
from drivers.roomba_state import base_state, why_passive
from drivers.roomba_stream import PERIOD, StreamParser
from drivers.serial_port import SerialPort, WriteTimeout, open_serial
from drivers.wheel_odometry import WheelOdometry, without_reversal
from vizbot.core.diff_drive import wheel_speeds, within_wheel_limit
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.interfaces import Clock
from vizbot.core.settings import SETTINGS
from vizbot.core.types import STOP, BaseMode, BaseState, Twist

__all__ = ["Roomba", "RoombaConfig", "SerialPort", "open_serial"]

logger = logging.getLogger(__name__)

_STREAMED = (
    Packet.BUMPS_AND_WHEEL_DROPS,
    Packet.CLIFF_LEFT,
    Packet.CLIFF_FRONT_LEFT,
    Packet.CLIFF_FRONT_RIGHT,
    Packet.CLIFF_RIGHT,
    Packet.BATTERY_CHARGE,
    Packet.BATTERY_CAPACITY,
    Packet.OI_MODE,
    Packet.LEFT_ENCODER,
    Packet.RIGHT_ENCODER,
)
_STOP_WHEELS = encode(Opcode.DRIVE_DIRECT, 0, 0)
SURE_STOP = 4 * _STOP_WHEELS
"""Works after a command cut short, too: its missing bytes are taken from the first of these."""
_WAKE_UP = encode(Opcode.START) + encode(Opcode.SAFE) + encode(Opcode.STREAM, *_STREAMED)
_RETRY_PERIOD = 0.5
"""Time that the base gets to act on `_WAKE_UP` [s]; other drivers wait as long."""


class RoombaConfig(BaseModel):
    """How the base is driven and read."""

    model_config = SETTINGS

    wheel_base: float = Field(0.235, gt=0)
    """Distance between the wheels [m]; the manual's value until calibrated."""
    wheel_scale: float = Field(1.0, gt=0)
    """Metres truly rolled for each metre that the encoders count; 1 until calibrated."""
    max_wheel_speed: float = Field(0.5, gt=0, le=0.5)
    """Fastest that a wheel is told to turn [m/s at the rim]; the base takes 0.5 at most."""
    command_timeout: float = Field(0.3, gt=0)
    """The wheels stop when no drive() came for so long [s]."""
    silence_timeout: float = Field(0.5, gt=0)
    """read() fails when no valid sensor frame came for so long [s]."""
    start_timeout: float = Field(3.0, ge=0.1)
    """The base has so long to go to Safe mode when opened [s]."""
    mode_offset: int = Field(0, ge=0, le=1)
    """1 for the 600-series firmware that reports its mode one too high."""
    resume_safe: bool = False
    """Go back to Safe mode without being asked, as soon as no wheel hangs."""


class Roomba:
    """A Create 2 or 600-series Roomba in Safe mode.

    Everything that touches the port runs in one step that the clock repeats. It reads the sensor
    stream and then writes Drive Direct: after every frame, when the wanted speeds change, and when
    the base is silent. A command that the line spoils is thus repaired 15 ms later, and a base that
    is heard no more is still told to stop.

    `drivers.reflexes` limits whatever drive() asks for.
    """

    def __init__(
        self, open_port: Callable[[], SerialPort], clock: Clock, config: RoombaConfig
    ) -> None:
        """Open the port, wake the base up, and wait until it streams and is in Safe mode.

        Raises:
            DeviceError: the port cannot be opened, nothing on it answers like a Roomba, or the base
                refuses Safe mode.
        """
        self._clock = clock
        self._config = config
        self._lock = threading.Lock()
        self._stream = StreamParser(_STREAMED)
        self._outbox = b""
        self._wanted = STOP
        self._wanted_at = clock.now()
        self._sent: tuple[int, int] | None = None
        self._odometry = WheelOdometry(config.wheel_base, config.wheel_scale)
        self._state: BaseState | None = None
        self._failure: DeviceError | None = None
        self._closed = False
        self._asked_for_safe = -math.inf
        self._stop_service: Callable[[], None] = lambda: None
        self._port = open_port()
        self._name = self._port.name or "the serial port"
        try:
            self._stop_service = clock.repeat(self._service)
            self._await_safe_mode()
        except BaseException:
            self.close()
            raise

    def drive(self, twist: Twist) -> None:
        """Hold `twist`, same curvature if too fast, until the next call.

        It has no effect while the base is not in Safe mode.

        Raises:
            DeviceError: the base is gone or closed.
            ValueError: the twist is not finite.
        """
        if not (math.isfinite(twist.linear) and math.isfinite(twist.angular)):
            raise ValueError(f"{twist} is not finite")
        limited = within_wheel_limit(twist, self._config.wheel_base, self._config.max_wheel_speed)
        with self._lock:
            self._require_open()
            self._wanted = limited
            self._wanted_at = self._clock.now()

    def read(self) -> BaseState:
        """Return the newest odometry and contacts.

        Raises:
            DeviceTimeoutError: no valid sensor frame came within the silence timeout.
            DeviceError: the base is gone or closed.
        """
        with self._lock:
            self._require_open()
            state, limit = self._state, self._config.silence_timeout
            if state is None or self._clock.now() - state.stamp > limit:
                message = f"{self._name}: no answer from the base for {limit} s"
                raise DeviceTimeoutError(f"{message}; check its cable and battery, press Clean")
            return state

    def resume(self) -> None:
        """Ask for Safe mode again, wheels stopped, after a cliff or a wheel drop ended it.

        `read().mode` tells whether the base has followed.

        Raises:
            DeviceError: the base is gone or closed.
        """
        with self._lock:
            self._require_open()
            self._ask_for_safe()

    def close(self) -> None:
        """Stop the wheels, leave the base in Passive mode so that it can charge, free the port."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            self._wanted, self._outbox = STOP, b""
        try:
            self._stop_service()
        finally:  # an interrupt, too, must not leave the wheels turning
            self._leave()

    def _leave(self) -> None:
        try:
            for _ in range(3):
                try:
                    self._port.write(SURE_STOP + encode(Opcode.START))
                except WriteTimeout:
                    continue
                return
            logger.error("%s: the line is stuck, the wheels may still turn", self._name)
        except OSError as error:
            logger.error("%s: the wheels could not be told to stop: %s", self._name, error)
        finally:
            self._port.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def _await_safe_mode(self) -> None:
        deadline = self._clock.now() + self._config.start_timeout
        while self._clock.now() < deadline:
            with self._lock:
                self._require_open()
                if self._clock.now() - self._asked_for_safe >= _RETRY_PERIOD:
                    self._ask_for_safe()
                elif self._state is not None and self._state.mode is BaseMode.SAFE:
                    return
            self._clock.sleep(PERIOD)
        if self._state is None:
            message = f"{self._name} is not a Roomba or is asleep: it sends no sensor frames"
            raise DeviceError(f"{message}; press Clean, then check the cable and the port's name")
        if self._state.mode is BaseMode.FULL:
            raise DeviceError(f"{self._name}: Safe mode is reported as Full; set mode_offset = 1")
        message = f"{self._name}: the base stays in {self._state.mode.name.title()} mode"
        raise DeviceError(f"{message}; put it on the floor, off its charger, away from edges")

    def _ask_for_safe(self) -> None:
        self._wanted = STOP
        self._outbox = _STOP_WHEELS + _WAKE_UP
        self._asked_for_safe = self._clock.now()

    def _require_open(self) -> None:
        if self._closed:
            raise DeviceError(f"{self._name}: the base is closed; open it again")
        if self._failure is not None:
            raise self._failure

    def _service(self) -> None:
        """Read what is there (the port waits up to 20 ms on the wall clock), then command."""
        if self._failure is not None:
            self._stop_after_failure()
            return
        try:
            received = self._port.read(max(1, self._port.in_waiting))
            frames = self._stream.feed(received)
            with self._lock:
                for values in frames:
                    self._observe(values)
                wheels = self._wheels()
                sent, self._outbox = self._outbox, b""
            if sent or frames or not received or wheels != self._sent:
                self._port.write(sent + encode(Opcode.DRIVE_DIRECT, *wheels))
                self._sent = wheels
        except Exception as error:
            # Nobody above this step would see an error: keep it for the next drive() or read().
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        message = f"{self._name}: the base is gone ({error}); check its cable and open it again"
        logger.info("%s", message)
        with self._lock:
            self._failure = DeviceError(message)
        self._stop_after_failure()

    def _stop_after_failure(self) -> None:
        """Stop the wheels, then end the service; a stuck line is tried again next time."""
        try:
            self._port.write(SURE_STOP)
        except WriteTimeout:
            return
        except Exception as error:  # a port that is gone or closed raises all sorts of things
            logger.debug("%s: %s", self._name, error)
        self._stop_service()

    def _observe(self, values: Mapping[Packet, int]) -> None:
        """Take in one sensor frame; one that no sound base could send is dropped."""
        mode = values[Packet.OI_MODE] - self._config.mode_offset
        if mode < 0 or not all(in_range(packet, value) for packet, value in values.items()):
            logger.debug("%s: dropped an impossible sensor frame: %s", self._name, values)
            return
        before = self._state
        T_odom_base = self._odometry.update(
            values[Packet.LEFT_ENCODER], values[Packet.RIGHT_ENCODER]
        )
        self._state = base_state(values, self._clock.now(), T_odom_base, BaseMode(mode))
        self._follow_mode(before, self._state)

    def _follow_mode(self, before: BaseState | None, state: BaseState) -> None:
        if state.mode is not BaseMode.PASSIVE:
            return
        if before is not None and before.mode is BaseMode.SAFE:
            logger.warning("%s: the base left Safe mode (%s)", self._name, why_passive(state))
        since_asked = self._clock.now() - self._asked_for_safe
        if self._config.resume_safe and not any(state.wheel_drops) and since_asked > _RETRY_PERIOD:
            logger.warning("%s: going back to Safe mode, as resume_safe says", self._name)
            self._ask_for_safe()

    def _wheels(self) -> tuple[int, int]:
        """Right and left wheel speed to command now [mm/s]."""
        now, state, config = self._clock.now(), self._state, self._config
        if self._wanted != STOP and now - self._wanted_at > config.command_timeout - 1e-9:
            logger.warning("%s: no command for %s s: stopped", self._name, config.command_timeout)
            self._wanted = STOP
        if state is None or now - state.stamp > config.silence_timeout:
            return 0, 0
        speeds = wheel_speeds(allowed(self._wanted, state), config.wheel_base)
        left, right = (_velocity_mm_s(speed / config.wheel_scale) for speed in speeds)
        told, rest = self._sent or (0, 0), self._odometry.at_rest
        right = without_reversal(right, told[0], rest[1])
        return right, without_reversal(left, told[1], rest[0])


def _velocity_mm_s(speed: float) -> int:
    return max(-500, min(500, round(1000 * speed)))
