"""A Roomba at the robot's end of a serial line, which any program may drive.

It executes every command of the Open Interface and answers every sensor packet. Where the manual is
silent it does what a driver must be ready for: the last Drive runs on when the line falls silent,
and through Start and Stop; speeds beyond the fastest are taken for the fastest; only a button wakes
a sleeping base. Its dock charges it in Passive mode and does not end Safe mode. Not simulated:
cleaning (the base only goes to Passive mode), the 28.5 mm/s steps of the wheel controller.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from drivers.roomba.commands import Command, CommandParser, Opcode, check
from drivers.roomba.packets import (
    BumpsAndWheelDrops,
    Buttons,
    ChargingSources,
    ChargingState,
    Packet,
    encode_packets,
    singles,
)
from drivers.roomba.serial_port import SerialPort
from drivers.roomba.stream import PERIOD, encode_sensor_frame
from sim_stubs.roomba.dock import SensedDock
from sim_stubs.roomba.serial_line import LineNoise, SerialLine
from sim_stubs.roomba.wheels import Wheels, within_range
from sim_stubs.world.body import Body
from vizbot.core.closeable import Closeable
from vizbot.core.types import BaseMode

logger = logging.getLogger(__name__)

BANNER = b"\r\nr3_robot/tags/release-3.8.2\r\n"
"""Text that the base sends after a reset."""

_NEW_MODE = {
    Opcode.START: BaseMode.PASSIVE,
    Opcode.CONTROL: BaseMode.SAFE,
    Opcode.SAFE: BaseMode.SAFE,
    Opcode.FULL: BaseMode.FULL,
    Opcode.POWER: BaseMode.PASSIVE,
    Opcode.SPOT: BaseMode.PASSIVE,
    Opcode.CLEAN: BaseMode.PASSIVE,
    Opcode.MAX: BaseMode.PASSIVE,
    Opcode.SEEK_DOCK: BaseMode.PASSIVE,
    Opcode.STOP: BaseMode.OFF,
    Opcode.RESET: BaseMode.OFF,
}
_TAKES_OVER_THE_WHEELS = frozenset(
    {Opcode.POWER, Opcode.SPOT, Opcode.CLEAN, Opcode.MAX, Opcode.SEEK_DOCK, Opcode.RESET}
)
_WHEELS = frozenset({Opcode.DRIVE, Opcode.DRIVE_DIRECT, Opcode.DRIVE_PWM})
_ACTUATORS = _WHEELS | frozenset(
    {
        Opcode.MOTORS,
        Opcode.PWM_MOTORS,
        Opcode.LEDS,
        Opcode.PLAY,
        Opcode.SCHEDULING_LEDS,
        Opcode.DIGIT_LEDS_RAW,
        Opcode.DIGIT_LEDS_ASCII,
    }
)
"""Commands that the base executes only in Safe and Full mode."""
_BUTTON_PRESS = 1 / 6
"""How long the Buttons command holds a button [s] (manual, page 17)."""

_CLIFF_SIGNALS = {
    Packet.CLIFF_LEFT: Packet.CLIFF_LEFT_SIGNAL,
    Packet.CLIFF_FRONT_LEFT: Packet.CLIFF_FRONT_LEFT_SIGNAL,
    Packet.CLIFF_FRONT_RIGHT: Packet.CLIFF_FRONT_RIGHT_SIGNAL,
    Packet.CLIFF_RIGHT: Packet.CLIFF_RIGHT_SIGNAL,
}
_NOTHING = dict.fromkeys(Packet, 0)
_UNLIMITED = Packet.OI_MODE
"""Some firmware of the 600 series calls Full mode 4."""
_FLOOR_SIGNAL = 1300
_FALLS_ASLEEP = 300.0
"""Time in Passive mode without a command until the base sleeps [s] (manual, page 4)."""
_SEEKS = 60.0
"""Longest time of Seek Dock [s]."""


_TICKS_PER_SECOND = 64


_CAPACITY_MAH = 2696.0
_EMPTY_MV = 13200
_FULL_MV = 16400
_IDLE_MA = 250
_WHEEL_MA = 300
_CHARGE_MA = 1250


class Battery:
    """The battery, with the figures of a well-kept pack of the 600 series."""

    def __init__(self, charge: float = 1.0) -> None:
        """Start with a `charge` of 0 to 1."""
        self._charge_mah = charge * _CAPACITY_MAH
        self._wheel_ma = 0
        self._state = ChargingState.NOT_CHARGING

    @property
    def empty(self) -> bool:
        """Whether the battery is empty."""
        return self._charge_mah <= 0.0

    def advance(self, seconds: float, wheels_turn: bool, on_charger: bool) -> None:
        """Discharge or charge for `seconds`."""
        self._wheel_ma = _WHEEL_MA if wheels_turn else 0
        full = self._charge_mah >= _CAPACITY_MAH
        self._state = ChargingState.NOT_CHARGING
        if on_charger:
            self._state = ChargingState.WAITING if full else ChargingState.FULL_CHARGING
        charge = self._charge_mah + self._current_ma * seconds / 3600
        self._charge_mah = min(max(0.0, charge), _CAPACITY_MAH)

    def packets(self) -> dict[Packet, int]:
        """Packets 21 to 26, 54 and 55 as they stand."""
        fraction = self._charge_mah / _CAPACITY_MAH
        return {
            Packet.CHARGING_STATE: self._state,
            Packet.VOLTAGE: round(_EMPTY_MV + fraction * (_FULL_MV - _EMPTY_MV)),
            Packet.CURRENT: self._current_ma,
            Packet.TEMPERATURE: 25,
            Packet.BATTERY_CHARGE: round(self._charge_mah),
            Packet.BATTERY_CAPACITY: round(_CAPACITY_MAH),
            Packet.LEFT_MOTOR_CURRENT: self._wheel_ma,
            Packet.RIGHT_MOTOR_CURRENT: self._wheel_ma,
        }

    @property
    def _current_ma(self) -> int:
        """Current into the battery [mA]."""
        if self._state is ChargingState.FULL_CHARGING:
            return _CHARGE_MA
        if self._state is ChargingState.WAITING:
            return 0
        return -(_IDLE_MA + 2 * self._wheel_ma)


class Songs:
    """The five slots, and the song that is playing."""

    def __init__(self) -> None:
        self.slots: dict[int, tuple[tuple[int, int], ...]] = {}
        """Note and duration [1/64 s] of every song that was defined."""
        self._selected = 0
        self._left = 0.0

    def define(self, slot: int, *notes: int) -> None:
        """Fill a slot with notes and durations in turns."""
        self.slots[slot] = tuple(zip(notes[::2], notes[1::2], strict=True))

    def play(self, slot: int) -> None:
        """Play the song of a slot; an empty slot ends at once."""
        self._selected = slot
        notes = self.slots.get(slot, ())
        self._left = sum(duration for _, duration in notes) / _TICKS_PER_SECOND

    def advance(self, seconds: float) -> None:
        """Play on for `seconds`."""
        self._left = max(0.0, self._left - seconds)

    def packets(self) -> dict[Packet, int]:
        """Packets 36 and 37 as they stand."""
        return {Packet.SONG_NUMBER: self._selected, Packet.SONG_PLAYING: int(self._left > 0)}


class SimulatedRoomba(Closeable):
    """The base: a `LockstepDevice` with a body in some world.

    Attributes:
        path: The port that a program opens.
        mode: Open Interface mode; Off at the start.
        overrides: Sensor values that replace what the world gives: infrared, charger, faults.
        settings: Newest arguments of each command that only sets something (LEDs, brushes,
            display, schedule, baud code, ...), while it holds.
        songs: The defined songs.
        asleep: Whether it sleeps, in which it neither sends nor receives until a button is
            pressed.
    """

    def __init__(
        self,
        body: Body,
        encoder_counts: tuple[int, int] = (0, 0),
        dock: SensedDock | None = None,
        charge: float = 1.0,
        noise: LineNoise | None = None,
    ) -> None:
        """Open a pseudo-terminal.

        Args:
            body: Body of the robot in its world.
            encoder_counts: First counts of the left and right encoder, -32768 to 32767.
            dock: Dock in that world.
            charge: Charge of the battery, 0 to 1.
            noise: Noise on its serial line.
        """
        self.mode = BaseMode.OFF
        self.overrides: dict[Packet, int] = {}
        self.settings: dict[Opcode, tuple[int, ...]] = {}
        self.songs = Songs()
        self.asleep = False
        self._body = body
        self._dock = dock
        self._seeks_for = 0.0
        self._idle_for = 0.0
        self._wheels = Wheels(body, encoder_counts)
        self._battery = Battery(charge)
        self._commands = CommandParser()
        self._streamed: tuple[int, ...] = ()
        self._streaming = False
        self._pressed = 0
        self._pressed_for = 0.0
        self._line = SerialLine(noise)
        self.path = self._line.path

    def lockstep_port(self, port: SerialPort) -> SerialPort:
        """Wrap the port that a driver has just opened on `path`.

        The kernel delivers bytes on a pseudo-terminal when it likes; through the wrapped port every
        byte arrives before time goes on, in both directions.
        """
        return self._line.lockstep_port(port)

    def publish(self) -> None:
        """Read the sensors, and send a frame if a stream was commanded."""
        self._keep_safe()
        if self._streaming and self._streamed and not self.asleep:
            frame = encode_sensor_frame(self._streamed, self._sensed(), _UNLIMITED)
            self._wheels.was_read(singles(self._streamed))
            self._line.send(frame)

    def advance(self, seconds: float) -> None:
        """Execute received commands, then let `seconds` pass."""
        self._idle_for += seconds
        for command in self._commands.feed(self._line.receive()):
            if not self.asleep:
                self._idle_for = 0.0
                self._obey(command)
        self._seek_dock(seconds)
        self._wheels.advance(seconds)
        charges = self._on_dock and not self.mode.obeys
        self._battery.advance(seconds, self._wheels.turning, charges)
        if (
            self.mode is BaseMode.PASSIVE and self._idle_for > _FALLS_ASLEEP
        ) or self._battery.empty:
            self.fall_asleep()
        self.songs.advance(seconds)
        self._pressed_for = max(0.0, self._pressed_for - seconds)
        self._keep_safe()

    def press(self, buttons: Buttons) -> None:
        """Press buttons for a moment, which wakes a base with any charge left."""
        self._pressed, self._pressed_for = int(buttons), _BUTTON_PRESS
        if not self._battery.empty:
            self.asleep, self._idle_for = False, 0.0

    def fall_asleep(self) -> None:
        """Stop, and neither send nor receive."""
        self._wheels.stop()
        self.asleep, self._streaming, self.mode = True, False, BaseMode.OFF

    def jump_encoders(self, counts: int) -> None:
        """Add counts to both encoders without motion."""
        self._wheels.jump(counts)

    def close(self) -> None:
        """Stop the wheels and release the pseudo-terminal; twice is fine."""
        self._wheels.stop()
        self._line.close()

    def _keep_safe(self) -> None:
        """Leave Safe mode on one of its three events (manual, page 7)."""
        if self.mode is not BaseMode.SAFE:
            return
        contacts = self._body.contacts
        cliff = any(contacts.cliffs) and self._wheels.stops_for_cliffs
        charger = self.overrides.get(Packet.CHARGING_SOURCES, 0) != 0
        if cliff or any(contacts.wheel_drops) or charger:
            self._wheels.stop()
            self.mode = BaseMode.PASSIVE

    @property
    def _on_dock(self) -> bool:
        return self._dock is not None and self._dock.touches(self._body.T_world_base)

    def _seek_dock(self, seconds: float) -> None:
        """Drive onto the dock after Seek Dock."""
        if self._seeks_for <= 0.0:
            return
        self._seeks_for -= seconds
        if self._dock is None or self._on_dock or self._seeks_for <= 0.0:
            self._seeks_for = 0.0
            self._wheels.stop()
        else:
            self._wheels.turn(*self._dock.seek_speeds(self._body.T_world_base))

    def _obey(self, command: Command) -> None:
        opcode, arguments = command.opcode, command.arguments
        if self.mode is BaseMode.OFF and opcode not in (Opcode.START, Opcode.RESET):
            return
        if opcode in _ACTUATORS and self.mode is BaseMode.PASSIVE:
            return
        if opcode in _WHEELS:
            command = within_range(command)
        try:
            check(command)
        except ValueError as error:
            logger.warning("%s: ignored a command: %s", self.path, error)
            return
        match opcode:
            case _ if opcode in _WHEELS:
                self._wheels.obey(command)
            case Opcode.SENSORS | Opcode.QUERY_LIST:
                reply = encode_packets(arguments, self._sensed(), _UNLIMITED)
                self._wheels.was_read(singles(arguments))
                self._line.send(reply)
            case Opcode.STREAM:
                self._streamed, self._streaming = arguments, True
            case Opcode.PAUSE_RESUME_STREAM:
                self._streaming = arguments == (1,)
            case Opcode.SONG:
                self.songs.define(*arguments)
            case Opcode.PLAY:
                self.songs.play(*arguments)
            case Opcode.BUTTONS:
                self.press(Buttons(arguments[0]))
            case _ if opcode in _NEW_MODE:
                self._enter(opcode)
            case _:
                self.settings[opcode] = arguments

    def _enter(self, opcode: Opcode) -> None:
        self.mode = _NEW_MODE[opcode]
        self._seeks_for = _SEEKS if opcode is Opcode.SEEK_DOCK else 0.0
        if opcode in _TAKES_OVER_THE_WHEELS:
            self._wheels.stop()
        if self.mode in (BaseMode.SAFE, BaseMode.FULL):
            self.settings.pop(Opcode.LEDS, None)
        if self.mode is BaseMode.OFF:
            self._streamed, self._streaming = (), False
        if opcode is Opcode.RESET:
            self._line.send(BANNER)

    def _sensed(self) -> dict[Packet, int]:
        contacts = self._body.contacts
        left_drops, right_drops = contacts.wheel_drops
        touched = (contacts.bump_right, contacts.bump_left, right_drops, left_drops)
        bumps = sum(bit for bit, felt in zip(BumpsAndWheelDrops, touched, strict=True) if felt)
        values = _NOTHING | self._wheels.packets() | self._battery.packets()
        values |= self.songs.packets()
        if self._dock is not None:
            infrared = self._dock.infrared(self._body.T_world_base)
            values |= dict(
                zip((Packet.IR_OMNI, Packet.IR_LEFT, Packet.IR_RIGHT), infrared, strict=True)
            )
            values[Packet.CHARGING_SOURCES] = ChargingSources.HOME_BASE if self._on_dock else 0
        values[Packet.BUMPS_AND_WHEEL_DROPS] = bumps
        values[Packet.BUTTONS] = self._pressed if self._pressed_for > 0 else 0
        values[Packet.OI_MODE] = self.mode
        values[Packet.STREAM_PACKET_COUNT] = min(108, len(self._streamed))
        values[Packet.STASIS] = int(self._wheels.advancing)
        for (cliff, signal), seen in zip(_CLIFF_SIGNALS.items(), contacts.cliffs, strict=True):
            values[cliff] = int(seen)
            values[signal] = 0 if seen else _FLOOR_SIGNAL
        return values | self.overrides


def run_on_wall_clock(roomba: SimulatedRoomba, stopped: threading.Event) -> None:
    """Run the base in real time, a frame every 15 ms, until `stopped` is set."""
    before = time.monotonic()
    while not stopped.wait(PERIOD):
        now = time.monotonic()
        roomba.advance(now - before)
        roomba.publish()
        before = now


@contextmanager
def on_wall_clock(roomba: SimulatedRoomba) -> Iterator[SimulatedRoomba]:
    """Run the base in a thread beside the caller, and close it at the end."""
    stopped = threading.Event()
    thread = threading.Thread(target=run_on_wall_clock, args=(roomba, stopped), daemon=True)
    with roomba:
        thread.start()
        try:
            yield roomba
        finally:
            stopped.set()
            thread.join()
