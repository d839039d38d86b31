"""Driving by hand, from a pseudo-terminal's keys to the wheels of a simulated base."""

import os
import select
import signal
import subprocess
import sys
import termios
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from drivers.roomba.serial_port import SerialAddress
from sim_stubs.world.body import Contacts
from tests.helpers.roomba_rig import DEADLINE, open_lockstep, resting, wait_for
from vizbot.commands import teleop as command
from vizbot.core.clock import WallClock
from vizbot.core.errors import ConfigError, DeviceError, DeviceTimeoutError
from vizbot.core.types import STOP, BaseMode
from vizbot.operator.teleop.teleop import Teleop
from vizbot.operator.teleop.terminal import ASK, Terminal

UP, DOWN = b"\x1b[A", b"\x1b[B"


class Person:
    """The other end of a terminal: types keys, and answers if it tells releases."""

    def __init__(self, telling=False):
        self._open = self.screen, self.keyboard = os.openpty()
        self.seen = b""
        self.telling = telling
        self._held = b""
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._live)
        self._thread.start()

    def _live(self):
        while not self._ended.is_set():
            if select.select([self.screen], [], [], 0.03)[0]:
                shown = os.read(self.screen, 4096)
                self.seen += shown
                if self.telling:
                    os.write(self.screen, shown.count(ASK) * b"\x1b[?27u")
            if self._held:
                os.write(self.screen, self._held)

    def type(self, keys):
        os.write(self.screen, keys)

    def hold(self, keys):
        """Have the terminal repeat `keys`; none lets go."""
        self._held = keys

    def look_away(self):
        """Read and type nothing more."""
        self._ended.set()
        self._thread.join()

    def hang_up(self):
        """Close both ends; once is enough."""
        self.look_away()
        for end in self._open:
            os.close(end)
        self._open = ()


@pytest.fixture
def person():
    someone = Person()
    yield someone
    someone.hang_up()


def open_base(stub):
    """The driver beside the test, without a process of its own, which takes a second to start."""
    return open_lockstep(SerialAddress(stub.path).open, WallClock(), silence_timeout=0.5)


def driving_by(base, person):
    """Teleop beside the test, until it ends."""

    def drive():
        with Terminal(person.keyboard) as terminal:
            Teleop(base, terminal, WallClock()).run()

    return ThreadPoolExecutor(1).submit(drive)


class Scripted:
    """A base that records what it is told and fails when it shall."""

    def __init__(self, error=None):
        self.told = []
        self.error = error

    def drive(self, twist):
        self.told.append(twist)

    def read(self):
        raise self.error or DeviceError("no base")

    def resume(self):
        self.told.append("resume")


@pytest.mark.slow
def test_an_arrow_that_is_held_rolls_and_a_terminal_that_hangs_up_stops(
    person, floor, stub, tmp_path
):
    settings = tmp_path / "robot.toml"
    settings.write_text(f'serial_port = "{stub.path}"\n[roomba]\nsilence_timeout = 0.5\n')
    command = [sys.executable, "-m", "vizbot", "teleop", "--config", str(settings)]
    program = subprocess.Popen(command, stdin=person.keyboard, stderr=subprocess.PIPE)
    try:
        wait_for(lambda: b"standing" in person.seen)
        person.hold(UP)
        wait_for(lambda: floor.wheel_travel[0] > 0.05)
        person.hold(b"")
        wait_for(lambda: resting(floor))
        rested_at = floor.wheel_travel[0]
        person.hold(UP)
        wait_for(lambda: floor.wheel_travel[0] > rested_at + 0.05)
        person.hang_up()
        _, errors = program.communicate(timeout=DEADLINE)
        wait_for(lambda: stub.mode is BaseMode.PASSIVE)
        assert resting(floor)
        assert program.returncode == 1
        assert errors.strip().splitlines()[-1].startswith(b"vizbot: the terminal is gone")
    finally:
        program.kill()


def test_where_releases_are_told_a_key_drives_until_it_goes_up(person, floor, stub):
    person.telling = True
    with open_base(stub) as base:
        driving = driving_by(base, person)
        wait_for(lambda: person.seen.count(ASK) > 2)  # it was understood
        pressed_at = 1.0

        def rolls_on():
            """Whether one press does; if this machine is so busy that it stops, it is repeated."""
            nonlocal pressed_at
            if resting(floor):
                pressed_at = floor.wheel_travel[0]
                person.type(b"\x1b[119;;119u")
            return floor.wheel_travel[0] > pressed_at + 0.2  # longer than any key counts as held

        wait_for(rolls_on)
        person.type(b"\x1b[119;1:3u")
        wait_for(lambda: resting(floor))
        person.type(b"\x1b[119;;119u")
        wait_for(lambda: not resting(floor))
        person.telling = False  # the way back is cut: a release would not come
        wait_for(lambda: resting(floor))
        person.telling = True
        person.type(b"\x1b[113;;113u")
        assert driving.exception(DEADLINE) is None


def test_at_an_edge_it_says_so_and_backs_off_when_asked(person, floor, stub):
    with open_base(stub) as base:
        driving = driving_by(base, person)
        person.hold(UP)
        wait_for(lambda: floor.wheel_travel[0] > 0.02)
        floor.contacts = Contacts(cliffs=(False, True, False, False))
        wait_for(lambda: b"stopped at an edge: press r" in person.seen)
        assert resting(floor)
        person.hold(b"")
        person.type(b"r")
        wait_for(lambda: b"standing | edge front left" in person.seen)
        edge = floor.wheel_travel[0]
        person.hold(DOWN)
        wait_for(lambda: floor.wheel_travel[0] < edge - 0.02)
        person.type(b"\x1b[99;5u")
        assert isinstance(driving.exception(DEADLINE), KeyboardInterrupt)


@pytest.mark.parametrize("by_key", [True, False], ids=["key", "signal"])
def test_ctrl_c_is_how_one_stops_to_drive(person, signals, monkeypatch, command_line, by_key):
    class Wheels(Scripted):
        def drive(self, twist):
            super().drive(twist)
            if len(self.told) == 2:
                person.type(b"\x1b[99;5u") if by_key else signal.raise_signal(signal.SIGINT)

    wheels = Wheels(DeviceTimeoutError("silent"))
    monkeypatch.setattr(command, "_STANDARD_INPUT", person.keyboard)
    monkeypatch.setattr(command, "open_base", lambda *_: wheels)
    code, _, err = command_line("teleop", "--base", "sim")
    assert not code and "interrupted" not in err
    assert wheels.told[-1] == STOP


def test_an_error_restores_the_terminal_and_stops_the_wheels(person):
    before = termios.tcgetattr(person.keyboard)
    base = Scripted(DeviceError("the base is gone"))
    assert str(driving_by(base, person).exception(DEADLINE)) == "the base is gone"
    assert termios.tcgetattr(person.keyboard) == before
    assert base.told[-1] == STOP
    wait_for(lambda: person.seen.rstrip().endswith(b"\x1b[<u"))


def test_a_silent_base_is_told_of_and_drives_on_only_when_asked_again(person):
    base = Scripted(DeviceTimeoutError("port: no answer; check its cable"))
    driving = driving_by(base, person)
    wait_for(lambda: b"check its cable" in person.seen)
    person.type(UP)
    wait_for(lambda: any(twist.linear > 0 for twist in base.told))
    wait_for(lambda: base.told[-1] == STOP)
    person.type(b"q")
    assert driving.exception(DEADLINE) is None


def test_a_terminal_that_takes_nothing_more_does_not_hold_up_the_wheels(person):
    with Terminal(person.keyboard) as terminal:
        person.look_away()  # nobody reads
        for _ in range(1000):
            terminal.show("a line")
        person.type(UP)
        wait_for(lambda: terminal.read(0.1) == UP)
        os.read(person.screen, 65536)


def test_no_terminal_is_one_line(tmp_path):
    with (tmp_path / "keys").open("w") as file, pytest.raises(ConfigError, match="ssh -t"):
        Terminal(file.fileno())
