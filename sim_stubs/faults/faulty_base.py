"""A simulated Roomba with faults of cable, firmware, battery and power."""

from __future__ import annotations

import errno
from collections.abc import Callable

import numpy as np

from drivers.roomba.commands import Command, CommandParser
from drivers.roomba.packets import (
    BumpsAndWheelDrops,
    Buttons,
    ChargingSources,
    Overcurrents,
    Packet,
)
from drivers.roomba.serial_port import SerialPort
from sim_stubs.faults.catalogue import CABLE_OUT, FaultSchedule
from sim_stubs.faults.faulty_body import FaultyBody
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.roomba.dock import SimulatedDock
from sim_stubs.world.body import Body
from vizbot.core.closeable import Closeable
from vizbot.core.errors import DeviceError
from vizbot.core.geometry import planar
from vizbot.core.types import SE3, BaseMode

_BYTES = ("corrupt-bytes", "lost-bytes", "duplicated-bytes")
_SHARE = 0.01
"""Share of the bytes that a bad line changes."""
_JUMP = 10_000
_OUT_OF_SIGHT = SimulatedDock(planar(1000.0, 1000.0, 0.0))
_BUMPER = BumpsAndWheelDrops.BUMP_LEFT | BumpsAndWheelDrops.BUMP_RIGHT
_EMPTY_MAH, _CAPACITY_MAH = 130, 2600


class FaultyLine:
    """A serial line that corrupts, loses and repeats bytes.

    Attributes:
        was_clear: Whether the last bytes of the base arrived unchanged.
        sent: The last bytes of the program, before the line changed them.
    """

    def __init__(self, schedule: FaultSchedule, seed: int) -> None:
        """`seed` draws the bytes that are changed."""
        self._schedule = schedule
        self._rng = np.random.default_rng((seed, 7))
        self._commands = CommandParser()
        self.was_clear = False
        self.sent: tuple[Command, ...] = ()

    def to_robot(self, sent: bytes) -> bytes:
        """Bytes that arrive at the base."""
        self.sent = tuple(self._commands.feed(sent))
        return self._disturbed(sent)

    def to_host(self, sent: bytes) -> bytes:
        """Bytes that arrive at the host."""
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


def cable_is_out(schedule: FaultSchedule) -> bool:
    """Whether the cable of the base is unplugged now."""
    return any(schedule.active(name) for name in CABLE_OUT)


class LooseCable:
    """A port whose cable is unplugged while a fault of `CABLE_OUT` is active."""

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
        """Do as the port; raise `OSError` while the cable is unplugged."""
        self._require_cable()
        return self._port.read(size)

    def write(self, sent: bytes, /) -> int | None:
        """Do as the port; raise `OSError` while the cable is unplugged."""
        self._require_cable()
        return self._port.write(sent)

    def close(self) -> None:
        """Close the port."""
        self._port.close()

    def _require_cable(self) -> None:
        if cable_is_out(self._schedule):
            raise OSError(errno.EIO, "device disconnected")


class BentContacts:
    """Contacts that report a dock, wherever the base is, while `dock-stays` is active."""

    def __init__(self, schedule: FaultSchedule) -> None:
        self._schedule = schedule

    def infrared(self, T_world_base: SE3) -> tuple[int, int, int]:
        """No beam: there is no dock."""
        return 0, 0, 0

    def touches(self, T_world_base: SE3) -> bool:
        """Whether the fault is active."""
        return self._schedule.active("dock-stays")

    def seek_speeds(self, T_world_base: SE3) -> tuple[float, float]:
        """A base that looks for a dock turns on the spot: none is in sight."""
        return (0.0, 0.0) if self.touches(T_world_base) else _OUT_OF_SIGHT.seek_speeds(T_world_base)


class FaultyRoomba(Closeable):
    """A simulated Roomba with the faults of a schedule: a `LockstepDevice`.

    Attributes:
        path: The port that a program opens.
        body: The body that it drives.
        connected: Whether a program has opened its port since the cable was last unplugged.
    """

    def __init__(
        self, body: Body, schedule: FaultSchedule, seed: int, place: Callable[[SE3], None]
    ) -> None:
        """Open a pseudo-terminal."""
        self.body = FaultyBody(body, schedule, seed, place)
        self._schedule = schedule
        self._line = FaultyLine(schedule, seed)
        self._roomba = SimulatedRoomba(self.body, dock=BentContacts(schedule), noise=self._line)
        self.path = self._roomba.path
        self._begun: dict[str, float | None] = {}
        self._sleeps = False
        self.connected = False

    @property
    def sent(self) -> tuple[Command, ...]:
        """Commands of the program in the last period, before the line changed them."""
        return self._line.sent

    @property
    def heard(self) -> bool:
        """Whether the sensor frame of this period has arrived at the program."""
        return self._line.was_clear and not cable_is_out(self._schedule)

    def lockstep_port(self, port: SerialPort) -> SerialPort:
        """Wrap the port that a driver has just opened on `path`.

        Raises:
            DeviceError: the cable is unplugged.
        """
        if cable_is_out(self._schedule):
            port.close()
            raise DeviceError(f"serial port {self.path}: no such port; plug in the base's cable")
        self.connected = True
        return LooseCable(self._roomba.lockstep_port(port), self._schedule)

    def publish(self) -> None:
        """Begin the faults that are due, then publish."""
        roomba, schedule = self._roomba, self._schedule
        self.connected &= not cable_is_out(schedule)
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
        roomba.overrides = self._falsified_values()
        self._line.was_clear = False
        roomba.publish()

    def advance(self, seconds: float) -> None:
        """Execute commands, then let `seconds` pass."""
        self._roomba.advance(seconds)

    def close(self) -> None:
        """Stop the wheels and release the pseudo-terminal; twice is fine."""
        self._roomba.close()

    def _falsified_values(self) -> dict[Packet, int]:
        """Sensor values that a fault falsifies."""
        values: dict[Packet, int] = {}
        if self._schedule.active("mode-off-by-one"):
            values[Packet.OI_MODE] = self._roomba.mode + 1
        if self._schedule.active("battery-low"):
            values[Packet.BATTERY_CHARGE] = _EMPTY_MAH
            values[Packet.BATTERY_CAPACITY] = _CAPACITY_MAH
        if self._schedule.active("virtual-wall") or self._schedule.active("wall-stays"):
            values[Packet.VIRTUAL_WALL] = 1
        if self._schedule.active("bumper-stays"):
            values[Packet.BUMPS_AND_WHEEL_DROPS] = _BUMPER
        if self._schedule.active("charger-plugged"):
            values[Packet.CHARGING_SOURCES] = ChargingSources.INTERNAL_CHARGER
        if self.body.stalls or self._schedule.active("overcurrent-stays"):
            values[Packet.OVERCURRENTS] = Overcurrents.LEFT_WHEEL
        return values

    def _begins(self, name: str) -> bool:
        began = self._schedule.began(name)
        begins = began is not None and self._begun.get(name) != began
        self._begun[name] = began
        return begins
