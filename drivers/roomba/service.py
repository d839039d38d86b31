"""The owner of the base's port: reads, commands, and reopens it after its cable was pulled out."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from drivers.roomba.commands import Opcode, encode
from drivers.roomba.config import RoombaConfig
from drivers.roomba.control import RoombaControl
from drivers.roomba.drive_command import COMPLETION, SURE_STOP
from drivers.roomba.serial_port import SerialPort, WriteTimeout
from vizbot.core.interfaces import Clock
from vizbot.core.types import BaseState, Feedback, Twist

logger = logging.getLogger(__name__)

_FIRST_RETRY, _LAST_RETRY = 0.1, 0.4
"""Time until a lost port is first looked for, doubled up to the last each time [s]: the wheels may
turn on until it is back."""


_NOISE = 2000
"""Number of bytes without a sensor frame that counts as noise: half a second's at 115200 baud."""
NO_FRAMES = (
    "bytes come and make no sensor frame: the base speaks at another baud rate (19200 where Clean"
    " was held for ten seconds while it went off; take its battery out and put it back), or"
    " something else is at this port"
)


@dataclass(frozen=True, slots=True)
class Drive:
    """Hold a twist.

    Attributes:
        stamp: Time of the command [s]; the command timeout counts from there.
    """

    twist: Twist
    stamp: float


@dataclass(frozen=True, slots=True)
class Resume:
    """Stop the wheels and request Safe mode."""


@dataclass(frozen=True, slots=True)
class SeekDock:
    """Let the base look for its dock."""


@dataclass(frozen=True, slots=True)
class Show:
    """Light the LEDs and play a song."""

    feedback: Feedback


Order = Drive | Resume | SeekDock | Show


@dataclass(frozen=True, slots=True)
class Trouble:
    """The base cannot be reached.

    Attributes:
        message: The trouble and its remedy; empty once it is over.
        final: Whether the service has given up.
    """

    message: str
    final: bool = False


Report = BaseState | Trouble


@dataclass(frozen=True, slots=True, eq=False)
class Checkpoint:
    """What a service needs to go on where another one ended.

    Attributes:
        state: The last state; None before the first.
        counts: Left and right encoder at that state; None where they are not known.
        mode_offset: Offset of the mode that the firmware reports; None until it is known.
        docks: Whether the base was released to look for its dock.
    """

    name: str
    state: BaseState | None
    counts: tuple[int, int] | None
    mode_offset: int | None
    docks: bool


class Link(Protocol):
    """The connection to a `RoombaService`, which runs beside its user."""

    @property
    def name(self) -> str:
        """Of the port."""
        ...

    def send(self, order: Order) -> None:
        """Send an order to the service."""
        ...

    def receive(self) -> Sequence[Report]:
        """Reports of the service since the last call, oldest first."""
        ...

    def close(self) -> None:
        """Stop the wheels, leave the base in Passive mode, free the port; twice is fine."""
        ...


class RoombaService:
    """A base on its port; one caller at a time calls `step` over and over."""

    def __init__(
        self,
        open_port: Callable[[], SerialPort],
        now: Callable[[], float],
        config: RoombaConfig,
        last: Checkpoint | None = None,
    ) -> None:
        """Open the port; the first step wakes the base up.

        `last` is the checkpoint of a service that was killed, after which the wheels were stopped;
        then the port is opened in the first step, as after a loss.

        Raises:
            DeviceError: it cannot be opened.
        """
        self._open_port = open_port
        self._now = now
        self._config = config
        self._port: SerialPort | None = open_port() if last is None else None
        self.name = last.name if last is not None else _port_name(self._port)
        self._control = RoombaControl(self.name, config, now())
        if last is not None:
            self._control.restore(
                last.state, last.counts, last.mode_offset, now(), docks=last.docks
            )
        self._reported = self._control.state
        self._reports: list[Report] = []
        self._heard = 0
        self._lost_at = now()
        self._retry_at = self._lost_at + _FIRST_RETRY  # frames from before the stop are not read
        self._backoff = _FIRST_RETRY
        self._slept = False

    def execute(self, order: Order) -> None:
        """Carry out an order that was sent through a `Link`."""
        match order:
            case Drive(twist, stamp):
                self._control.drive(twist, stamp)
            case Resume():
                self._control.resume(self._now())
            case SeekDock():
                self._control.seek_dock(self._now())
            case Show(feedback):
                self._control.show(feedback)

    def reports(self) -> list[Report]:
        """Reports since the last call, oldest first."""
        reports, self._reports = self._reports, []
        return reports

    def checkpoint(self) -> Checkpoint:
        """What another service needs to go on from here."""
        control = self._control
        return Checkpoint(
            self.name, control.state, control.counts, control.mode_offset, control.docks
        )

    def step(self) -> bool:
        """Read the received bytes, then send commands.

        Returns:
            Whether there is a port; on the wall clock, reading from it waits for up to 20 ms.
        """
        if self._port is None:
            self._reopen()
            return self._port is not None
        try:
            received = self._port.read(max(1, self._port.in_waiting))
        except Exception as error:  # a port that is gone raises errors of many kinds
            self._lose(self._port, _gone(error))
            return True
        sent = self._control.step(received, self._now())
        try:
            if sent:
                self._port.write(sent)
        except WriteTimeout:
            logger.warning("%s: the line is stuck, the wheels may still turn", self.name)
        except Exception as error:
            self._lose(self._port, _gone(error))
        state = self._control.state
        if state is None:
            self._report_noise(len(received))
        elif state is not self._reported:
            if self._reported is None and self._heard > _NOISE:
                self._reports.append(Trouble(""))
            self._reported = state
            self._reports.append(state)
        return True

    def _report_noise(self, received: int) -> None:
        """Report once that bytes come and no frame is among them."""
        before, self._heard = self._heard, self._heard + received
        if before <= _NOISE < self._heard:
            self._reports.append(Trouble(f"{self.name}: {NO_FRAMES}"))

    def close(self) -> None:
        """Stop the wheels, leave the base in Passive mode so that it can charge, free the port."""
        port, self._port = self._port, None
        self._retry_at = float("inf")
        if port is not None:
            state = self._control.state
            stop_and_release(port, on_charger=state is not None and state.on_charger)

    @property
    def is_reconnecting(self) -> bool:
        """Whether the port is lost and looked for."""
        return self._port is None and self._retry_at < float("inf")

    def wake(self) -> None:
        """Stop the wheels after the machine was suspended, and open the port anew."""
        self._slept = True
        if self._port is not None:
            self._lose(self._port, "this machine was suspended; keep it from sleeping")

    def _lose(self, port: SerialPort, reason: str) -> None:
        """Send a last stop, and look for the port from now on."""
        try:
            port.write(SURE_STOP)
        except Exception as again:
            logger.debug("%s: %s", self.name, again)
        port.close()
        self._port, self._lost_at = None, self._now()
        self._backoff, self._retry_at = _FIRST_RETRY, self._lost_at + _FIRST_RETRY
        message = f"{self.name}: {reason}"
        logger.warning("%s", message)
        self._reports.append(Trouble(message, final=self._config.reconnect_timeout == 0))

    def _reopen(self) -> None:
        now = self._now()
        if now < self._retry_at:
            return
        try:
            self._port = self._open_port()
        except Exception as error:  # a loose plug raises errors of many kinds
            self._backoff = min(2 * self._backoff, _LAST_RETRY)
            self._retry_at = now + self._backoff
            if now - self._lost_at >= self._config.reconnect_timeout:
                self._retry_at = float("inf")
                self._reports.append(Trouble(f"{error}; then launch again", final=True))
            return
        logger.warning("%s: the base is back after %.1f s", self.name, now - self._lost_at)
        self._control.reconnect(now, slept=self._slept)
        self._slept = False
        self._reports.append(Trouble(""))


def _gone(error: Exception) -> str:
    return f"the base is gone ({error}); plug its cable in again"


def _port_name(port: SerialPort | None) -> str:
    return (port and port.name) or "the serial port"


def stop_and_release(port: SerialPort, *, on_charger: bool = False) -> None:
    """Stop the wheels, leave the base in Passive mode so that it can charge, close the port.

    Args:
        port: Of the base, in any state.
        on_charger: Whether the base charges: then it does not roll, and Safe mode would end the
            charging. Elsewhere it may roll in Passive mode, as on its way to the dock, and only
            Safe mode stops it.
    """
    by_force = b"" if on_charger else COMPLETION + encode(Opcode.SAFE) + SURE_STOP
    name = _port_name(port)
    try:
        for _ in range(3):
            try:
                # Twice: a base that is left in Safe mode drains its battery on the charger.
                port.write(SURE_STOP + by_force + 2 * encode(Opcode.START))
            except WriteTimeout:
                continue
            return
        logger.error("%s: the line is stuck, the wheels may still turn", name)
    except Exception as error:
        logger.error("%s: the wheels could not be told to stop: %s", name, error)
    finally:
        port.close()


class LockstepLink:
    """A service that makes one step in every period of a simulated clock."""

    def __init__(
        self, open_port: Callable[[], SerialPort], clock: Clock, config: RoombaConfig
    ) -> None:
        """Open the port.

        Raises:
            DeviceError: it cannot be opened.
        """
        self._service = RoombaService(open_port, clock.now, config)
        self._stop_steps = clock.repeat(self._step)

    @property
    def name(self) -> str:
        """Of the port."""
        return self._service.name

    def send(self, order: Order) -> None:
        """Send an order; the next step carries it out."""
        self._service.execute(order)

    def receive(self) -> Sequence[Report]:
        """Reports of the steps since the last call."""
        return self._service.reports()

    def close(self) -> None:
        """End the steps and the service."""
        try:
            self._stop_steps()
        finally:  # an interrupt, too, must not leave the wheels turning
            self._service.close()

    def _step(self) -> None:
        self._service.step()
