"""Serial ports: the interface that the driver uses, and how to open one."""

from __future__ import annotations

import errno
import os
import termios
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from stat import S_ISCHR
from typing import Protocol

import serial
from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo

from vizbot.core.errors import DeviceError

_NO_PORT = "not a serial port; name the base's port, such as /dev/ttyUSB0"

WriteTimeout = serial.SerialTimeoutException
"""A write took too long; some of its bytes may have gone out."""


class SerialPort(Protocol):
    """The part of `serial.Serial` that the driver uses."""

    @property
    def name(self) -> str | None:
        """Path of the device."""
        ...

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read at once."""
        ...

    def read(self, size: int = 1, /) -> bytes:
        """Up to `size` bytes; fewer after the port's timeout."""
        ...

    def write(self, sent: bytes, /) -> int | None:
        """Send every byte."""
        ...

    def close(self) -> None:
        """Release the port."""
        ...


def open_serial(path: str) -> SerialPort:
    """Open the port of a Roomba: 115200 baud, 8N1, for us alone.

    Raises:
        DeviceError: there is no such port, or it cannot be used.
    """
    require_port(path)
    try:
        port: SerialPort = serial.Serial(
            path, 115200, timeout=0.02, write_timeout=0.1, exclusive=True
        )
    except (OSError, ValueError, termios.error) as error:
        raise DeviceError(f"serial port {path}: {_refusal(error)}") from error
    return port


def require_port(path: str) -> None:
    """Check beforehand whether there is a port; it is not opened, which some adapters notice.

    Raises:
        DeviceError: there is no such port, or it is the terminal of this program, to which a
            pseudo-terminal's number goes once its stub has ended.
    """
    try:
        device = Path(path).stat()
    except (OSError, ValueError) as error:
        raise DeviceError(f"serial port {path}: {_refusal(error)}") from error
    if not S_ISCHR(device.st_mode):
        raise DeviceError(f"serial port {path}: {_NO_PORT}")
    if device.st_rdev in _own_terminals():
        raise DeviceError(f"serial port {path}: this program's own terminal; {_NO_PORT}")


def _own_terminals() -> set[int]:
    """Device numbers of the terminals on this program's standard streams."""
    found = set[int]()
    for stream in range(3):
        with suppress(OSError):  # it is closed
            if os.isatty(stream):
                found.add(os.fstat(stream).st_rdev)
    return found


def serial_adapters() -> list[str]:
    """Paths of the serial ports on USB; none is opened.

    Raises:
        DeviceError: the ports cannot be listed.
    """
    ports = _ports("the serial ports")
    return sorted(port.device for port in ports if _identity(port) is not None)


class SerialAddress:
    """The port of a serial device, also after it was plugged in elsewhere."""

    def __init__(self, path: str) -> None:
        """Take the device at `path` now, or, if there is none, the one there when it is opened.

        Raises:
            DeviceError: the ports cannot be listed.
        """
        self._path = path
        self._identity = _identity_at(path, _ports(f"serial port {path}"))

    def open(self) -> SerialPort:
        """Open the port of the device, by its USB identity once that is known.

        An adapter without a serial number is identified by its USB socket.

        Raises:
            DeviceError: the device is not found, another one is at its path, or it cannot be used.
        """
        ports = _ports(f"serial port {self._path}")
        if self._identity is not None:
            found = [port.device for port in ports if _identity(port) == self._identity]
            if not found:
                raise DeviceError(
                    f"serial port {self._path}: the device that was there is gone; plug it in"
                    " again, where it was"
                )
            self._path = found[0]
        opened = open_serial(self._path)
        self._identity = _identity_at(self._path, ports) or self._identity
        return opened


def _ports(wanted: str) -> list[ListPortInfo]:
    try:
        return list(list_ports.comports())
    except Exception as error:  # a device that vanishes while it is listed raises many errors
        raise DeviceError(f"{wanted}: {error}; plug it in again") from error


def _identity_at(path: str, ports: Sequence[ListPortInfo]) -> tuple[object, ...] | None:
    """USB identity of the device at a path; None if there is no USB device."""
    try:
        device = os.path.realpath(path)
    except ValueError:  # no path at all, which opening it reports
        return None
    return next((_identity(port) for port in ports if port.device == device), None)


def _identity(port: ListPortInfo) -> tuple[object, ...] | None:
    """Properties of a USB device that stay when its cable is moved; None for other ports."""
    if port.vid is None:
        return None
    return port.vid, port.pid, port.serial_number or port.location


def _refusal(error: Exception) -> str:
    reason = error.errno if isinstance(error, OSError) else None
    if reason in (errno.ENOENT, errno.ENODEV, errno.ENXIO):
        ports = ", ".join(sorted(port.device for port in list_ports.comports())) or "none"
        return f"no such port (found: {ports}); plug in the base's cable or name another port"
    if reason in (errno.EACCES, errno.EPERM):
        return "permission denied; run `sudo usermod -aG dialout $USER` and log in again"
    if reason in (errno.EAGAIN, errno.EBUSY):
        return "used by another program; end that program or name another port"
    return _NO_PORT
