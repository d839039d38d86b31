"""Driving by hand: keys in, twists out, until the person leaves or the terminal is gone."""

from __future__ import annotations

from contextlib import suppress
from typing import Protocol

from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.interfaces import Clock
from vizbot.core.types import STOP, BaseState, Twist
from vizbot.operator.teleop.key_bindings import KeyBindings
from vizbot.operator.teleop.key_parser import KeyboardFlags, KeyParser
from vizbot.operator.teleop.status_line import StatusLine
from vizbot.operator.teleop.terminal import ASK, Terminal

PERIOD = 0.05
"""Longest time between two commands to the base [s]."""
_STALLED = 0.3
"""Keys that waited longer than this, because the program was stalled, are let go [s]."""
_LAST_ANSWERS = 0.5
"""Longest wait for the terminal's last answers [s]: later ones would show at the shell's prompt."""


class Driven(Protocol):
    """What is driven: an open base, or something that passes the commands on.

    Each call raises a `DeviceError` where the base is gone.
    """

    def drive(self, twist: Twist) -> None:
        """Hold `twist` until the next call, or for a moment without one."""
        ...

    def read(self) -> BaseState:
        """Return the newest state, or raise a `DeviceTimeoutError` where the base is silent."""
        ...

    def resume(self) -> None:
        """Ask the base to obey again."""
        ...


class Teleop:
    """A terminal, its keys, and the base that follows them."""

    def __init__(self, base: Driven, terminal: Terminal, clock: Clock) -> None:
        """Create it; nothing moves before `run`.

        Their owners close base and terminal, which waits on `clock`, the wall clock.
        """
        self._base = base
        self._terminal = terminal
        self._clock = clock
        self._parser = KeyParser()
        self._bindings = KeyBindings()
        self._line = StatusLine()
        self._unanswered = 1  # opening the terminal asks once

    def run(self) -> None:
        """Drive until the driver leaves; the wheels are commanded to stop however it ends.

        Raises:
            DeviceError: the base or the terminal is gone.
            KeyboardInterrupt: Ctrl-C was pressed.
        """
        try:
            self._drive()
        finally:
            with suppress(DeviceError):
                self._base.drive(STOP)
        self._await_answers()
        if self._bindings.interrupts:
            raise KeyboardInterrupt

    def _drive(self) -> None:
        bindings, clock = self._bindings, self._clock
        before = due = clock.now()
        commanded = STOP
        while not bindings.leaves:
            now = clock.now()
            self._listen(min(due, bindings.keys.changes_at(now)) - now)
            now = clock.now()
            if now - before > _STALLED:
                bindings.keys.let_go()
            before = now
            if bindings.resumes:
                bindings.resumes = False
                self._base.resume()
            twist = bindings.twist(now)
            if twist == commanded and now < due:
                continue
            self._command(twist, now)
            commanded, due = twist, now + PERIOD
            if bindings.keys.releases:
                self._unanswered += 1
                self._terminal.write(ASK)

    def _listen(self, timeout: float) -> None:
        """Take what is typed within `timeout` [s], at the time when it comes."""
        received = self._terminal.read(timeout)
        if received is None:
            raise DeviceError("the terminal is gone, the wheels stand; log in and start again")
        now = self._clock.now()
        if received:
            self._bindings.keys.hear(now)
        events = self._parser.feed(received, now)
        self._unanswered -= sum(isinstance(event, KeyboardFlags) for event in events)
        self._bindings.take(events, now)

    def _command(self, twist: Twist, now: float) -> None:
        """Command the base, and show its state."""
        bindings = self._bindings
        self._base.drive(twist)
        try:
            state = self._base.read()
        except DeviceTimeoutError as error:
            bindings.keys.let_go()
            self._terminal.show(str(error))
            return
        if not state.mode.obeys:
            bindings.keys.let_go()
        self._terminal.show(self._line.text(state, twist, bindings.step, bindings.speed, now))

    def _await_answers(self) -> None:
        """Wait for the answers that the terminal still owes, where it answers at all."""
        end = self._clock.now() + _LAST_ANSWERS
        while self._bindings.keys.releases and self._unanswered > 0 and self._clock.now() < end:
            received = self._terminal.read(end - self._clock.now())
            if received is None:
                return
            events = self._parser.feed(received, self._clock.now())
            self._unanswered -= sum(isinstance(event, KeyboardFlags) for event in events)
