"""The serial line of the simulated Roomba: a pseudo-terminal, in lockstep or on the wall clock."""

from __future__ import annotations

import os
import select
import time
import tty
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol

from drivers.roomba.serial_port import SerialPort, WriteTimeout
from vizbot.core.errors import DeviceError

_DELIVERY_TIMEOUT = 10.0
"""Longest wall time of a delivery by the kernel [s], which takes microseconds."""


class BytesLostError(TimeoutError):
    """The machine lost bytes of a simulated line in lockstep, or was too slow by far.

    It says nothing about the robot: what was driven until then counts for nothing.
    """


@dataclass(slots=True)
class _UnderWay:
    """Bytes that one end has sent and the other end has not read."""

    to_robot: int = 0
    to_host: int = 0


class LineNoise(Protocol):
    """Noise on a serial line."""

    def to_robot(self, sent: bytes) -> bytes:
        """Bytes that arrive at the robot."""
        ...

    def to_host(self, sent: bytes) -> bytes:
        """Bytes that arrive at the host."""
        ...


class SerialLine:
    """The robot's end of a pseudo-terminal.

    The kernel delivers bytes at any time. In lockstep both ends therefore count bytes: `receive`
    waits for every byte that the port wrapped by `lockstep_port` has sent, and that port for every
    byte sent here. Without such a port, bytes are read as they come, from any program.
    """

    def __init__(self, noise: LineNoise | None = None) -> None:
        """Open it.

        Raises:
            DeviceError: the system has no pseudo-terminal left, or none at all.
        """
        self._noise = noise
        try:
            self._robot, host = os.openpty()
            self.path = os.ttyname(host)
        except OSError as error:
            raise DeviceError(
                f"no pseudo-terminal for the simulated base: {error.strerror}; in a container or a"
                " chroot mount /dev/pts"
            ) from error
        tty.setraw(host)
        # Without an end of its own on the host's side, a poll shows whether a program listens.
        os.close(host)
        os.set_blocking(self._robot, False)
        self._poll = select.poll()
        self._poll.register(self._robot, select.POLLIN)
        self._counted: _UnderWay | None = None

    def send(self, sent: bytes) -> None:
        """Send to the host; bytes are lost, as on a real line, where no program reads."""
        if any(event & select.POLLHUP for _, event in self._poll.poll(0)):
            return
        if self._noise is not None:
            sent = self._noise.to_host(sent)
        try:
            written = os.write(self._robot, sent)
        except BlockingIOError:
            return
        if self._counted is not None:
            self._counted.to_host += written

    def receive(self) -> bytes:
        """Bytes that the host has sent since the last call."""
        received = self._received()
        return received if self._noise is None else self._noise.to_robot(received)

    def lockstep_port(self, port: SerialPort) -> SerialPort:
        """Wrap the port that a driver has just opened on `path`, so that both ends count."""
        self._counted = _UnderWay()
        return _LockstepPort(port, self._counted)

    def close(self) -> None:
        """Release the pseudo-terminal; twice is fine."""
        if self._robot >= 0:
            os.close(self._robot)
            self._robot = -1

    def _received(self) -> bytes:
        if self._counted is None:
            return self._read(4096)
        received = b""
        deadline = time.monotonic() + _DELIVERY_TIMEOUT
        while len(received) < self._counted.to_robot:
            arrived = self._read(self._counted.to_robot - len(received))
            received += arrived
            if not arrived:
                self._poll.poll(100)
            if time.monotonic() > deadline:
                raise BytesLostError(f"{self.path}: bytes were lost on their way to the robot")
        self._counted.to_robot = 0
        return received

    def _read(self, size: int) -> bytes:
        try:
            return os.read(self._robot, size)
        except OSError:
            # Nothing is there, or nobody: an end that was never opened reads as an I/O error.
            return b""


class _LockstepPort:
    """A serial port whose reads return exactly what the robot has sent, and at once."""

    def __init__(self, port: SerialPort, counted: _UnderWay) -> None:
        self._port = port
        self._counted = counted

    @property
    def name(self) -> str | None:
        return self._port.name

    @property
    def in_waiting(self) -> int:
        return self._counted.to_host

    def read(self, size: int = 1, /) -> bytes:
        size = min(size, self._counted.to_host)
        received = b""
        deadline = time.monotonic() + _DELIVERY_TIMEOUT
        while len(received) < size:
            received += self._port.read(size - len(received))
            if time.monotonic() > deadline:
                raise BytesLostError(f"{self.name}: bytes were lost on their way from the robot")
        self._counted.to_host -= size
        return received

    def write(self, sent: bytes, /) -> int | None:
        with suppress(WriteTimeout):  # the machine was slow: a pseudo-terminal has taken it all
            self._port.write(sent)
        self._counted.to_robot += len(sent)
        return len(sent)

    def close(self) -> None:
        self._port.close()
