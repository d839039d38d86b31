"""Serial ports that cannot be opened: one line each, with the remedy."""

import errno
from pathlib import Path

import pytest
import serial

from drivers.serial_port import open_serial
from sim_stubs.free_floor import FreeFloor
from sim_stubs.roomba import SimulatedRoomba
from vizbot.core.errors import DeviceError


def open_files():
    return len(list(Path("/proc/self/fd").iterdir()))


def test_a_missing_port_names_the_ports_that_there_are(monkeypatch):
    ports = [serial.tools.list_ports_common.ListPortInfo("/dev/ttyUSB7")]
    monkeypatch.setattr("drivers.serial_port.list_ports.comports", lambda: ports)
    with pytest.raises(DeviceError, match=r"/dev/ttyNONE: no such port \(found: /dev/ttyUSB7\)"):
        open_serial("/dev/ttyNONE")
    monkeypatch.setattr("drivers.serial_port.list_ports.comports", lambda: [])
    with pytest.raises(DeviceError, match=r"found: none"):
        open_serial("/dev/ttyNONE")


@pytest.mark.parametrize("path", ["/dev/null", "/tmp", __file__])
def test_a_file_that_is_no_serial_port_is_refused(path):
    before = open_files()
    with pytest.raises(DeviceError, match="not a serial port"):
        open_serial(path)
    assert open_files() == before


def test_a_port_without_permission_names_the_group(monkeypatch):
    def refuse(*args, **settings):
        raise serial.SerialException(errno.EACCES, "could not open port")

    monkeypatch.setattr("drivers.serial_port.serial.Serial", refuse)
    with pytest.raises(DeviceError, match="dialout"):
        open_serial("/dev/ttyUSB0")


def test_a_port_in_use_is_refused():
    with SimulatedRoomba(FreeFloor()) as stub:
        port = open_serial(stub.path)
        with pytest.raises(DeviceError, match="used by another program"):
            open_serial(stub.path)
        port.close()
