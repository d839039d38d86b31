"""A simulated Roomba with a bad cable, bad firmware, a bad battery, and a bad night's sleep."""

from __future__ import annotations

import errno
from collections.abc import Callable
from typing import Self

import numpy as np

from drivers.roomba.commands import Command, CommandParser
from drivers.roomba.packets import Buttons, ChargingSources, Overcurrents, Packet
from drivers.roomba.serial_port import SerialPort
from sim_stubs.faults.catalogue import FaultSchedule
from sim_stubs.faults.faulty_body import FaultyBody
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.world.body import Body
from vizbot.core.errors import DeviceError
from vizbot.core.types import SE3, BaseMode

_BYTES = ("corrupt-bytes", "lost-bytes", "duplicated-bytes")
_SHARE = 0.01
"""Of the bytes that a bad line hits."""
_JUMP = 10_000
_EMPTY_MAH, _CAPACITY_MAH = 130, 2600


class FaultyLine:
    """A serial line that spoils, loses and repeats bytes, and the base's voice on it.

    Attributes:
        was_clear: Whether what the base said last arrived as it was said.
        sent: What the program told the base last, before the line spoilt it.
    """

    def __init__(self, schedule: FaultSchedule, seed: int) -> None:
        """`seed` draws the bytes that are hit."""
        self._schedule = schedule
        self._rng = np.random.default_rng((seed, 7))
        self._commands = CommandParser()
        self.was_clear = False
        self.sent: tuple[Command, ...] = ()

    def to_robot(self, sent: bytes) -> bytes:
        """What becomes of bytes on their way to the base."""
        self.sent = tuple(self._commands.feed(sent))
        return self._disturbed(sent)

    def to_host(self, sent: bytes) -> bytes:
        """What becomes of bytes on their way from it."""
        received = b"" if self._schedule.active("stream-silent") else self._disturbed(sent)
        self.was_clear = received == sent
        return received

    def _disturbed(self, sent: bytes) -> bytes:
        received = bytearray(sent)
        for kind in _BYTES:
            if not received or not self._schedule.active(kind):
                continue
            for place in np.flatnonzero(self._rng.random(len(received)) < _SHARE)[::-1]:
                match kind:
                    case "corrupt-bytes":
                        received[place] = self._rng.integers(256)
                    case "lost-bytes":
                        del received[place]
                    case _:
                        received.insert(place, received[place])
        return bytes(received)


class LooseCable:
    """A port whose cable is out while `port-vanishes` is active."""

    def __init__(self, port: SerialPort, schedule: FaultSchedule) -> None:
        """`port` is open."""
        self._port = port
        self._schedule = schedule

    @property
    def name(self) -> str | None:
        """Path of the device."""
        return self._port.name

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read at once."""
        self._require_cable()
        return self._port.in_waiting

    def read(self, size: int = 1, /) -> bytes:
        """As the port; an `OSError` while the cable is out."""
        self._require_cable()
        return self._port.read(size)

    def write(self, sent: bytes, /) -> int | None:
        """As the port; an `OSError` while the cable is out."""
        self._require_cable()
        return self._port.write(sent)

    def close(self) -> None:
        """As the port."""
        self._port.close()

    def _require_cable(self) -> None:
        if self._schedule.active("port-vanishes"):
            raise OSError(errno.EIO, "device disconnected")


class FaultyRoomba:
    """A simulated Roomba to which happens what a schedule says: a `LockstepDevice` like it.

    Attributes:
        path: The port that a program opens to talk to it.
        body: What it drives.
        connected: Whether a program has opened its port since the cable was out last.
    """

    def __init__(
        self, body: Body, schedule: FaultSchedule, seed: int, place: Callable[[SE3], None]
    ) -> None:
        """Open a pseudo-terminal.

        Args:
            body: In its world.
            schedule: What is wrong.
            seed: Of the bytes that a bad line hits, and of where the robot is carried to.
            place: Puts it down somewhere else, at T_world_base.
        """
        self.body = FaultyBody(body, schedule, seed, place)
        self._schedule = schedule
        self._line = FaultyLine(schedule, seed)
        self._roomba = SimulatedRoomba(self.body, noise=self._line)
        self.path = self._roomba.path
        self._begun: dict[str, float | None] = {}
        self._sleeps = False
        self.connected = False

    @property
    def sent(self) -> tuple[Command, ...]:
        """What the program told it in the last period, before the line spoilt it."""
        return self._line.sent

    @property
    def heard(self) -> bool:
        """Whether what it felt in this period has arrived at the other end of its cable."""
        return self._line.was_clear and not self._schedule.active("port-vanishes")

    def lockstep_port(self, port: SerialPort) -> SerialPort:
        """Wrap the port that a driver has just opened on `path`.

        Raises:
            DeviceError: the cable is out.
        """
        if self._schedule.active("port-vanishes"):
            port.close()
            raise DeviceError(f"serial port {self.path}: no such port; plug in the base's cable")
        self.connected = True
        return LooseCable(self._roomba.lockstep_port(port), self._schedule)

    def publish(self) -> None:
        """Let happen what is due, then speak."""
        roomba, schedule = self._roomba, self._schedule
        self.connected &= not schedule.active("port-vanishes")
        if self._begins("mode-passive"):
            roomba.mode = BaseMode.PASSIVE
        if self._begins("encoder-jump"):
            roomba.jump_encoders(_JUMP)
        if self._begins("base-asleep"):
            roomba.fall_asleep()
            self._sleeps = True
        if self._sleeps and not schedule.active("base-asleep"):
            roomba.press(Buttons.CLEAN)
            self._sleeps = False
        roomba.overrides = self._told()
        self._line.was_clear = False
        roomba.publish()

    def advance(self, seconds: float) -> None:
        """Obey, then let `seconds` pass."""
        self._roomba.advance(seconds)

    def close(self) -> None:
        """Stop the wheels and release the pseudo-terminal; twice is fine."""
        self._roomba.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def _told(self) -> dict[Packet, int]:
        """Sensor values that are not what they should be."""
        told: dict[Packet, int] = {}
        if self._schedule.active("mode-off-by-one"):
            told[Packet.OI_MODE] = self._roomba.mode + 1
        if self._schedule.active("battery-low"):
            told[Packet.BATTERY_CHARGE] = _EMPTY_MAH
            told[Packet.BATTERY_CAPACITY] = _CAPACITY_MAH
        if self._schedule.active("virtual-wall"):
            told[Packet.VIRTUAL_WALL] = 1
        if self._schedule.active("charger-plugged"):
            told[Packet.CHARGING_SOURCES] = ChargingSources.INTERNAL_CHARGER
        if self.body.stalls:
            told[Packet.OVERCURRENTS] = Overcurrents.LEFT_WHEEL
        return told

    def _begins(self, name: str) -> bool:
        began = self._schedule.began(name)
        begins = began is not None and self._begun.get(name) != began
        self._begun[name] = began
        return begins
