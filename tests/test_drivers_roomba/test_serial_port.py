"""A serial device is found again by its USB identity, and no other is taken for it."""

import os
import pickle
import subprocess
import sys
from types import SimpleNamespace

import pytest

from drivers.roomba import serial_port
from drivers.roomba.serial_port import SerialAddress
from vizbot.core.errors import DeviceError


@pytest.fixture
def plugged(monkeypatch):
    """USB adapters by path: serial number, and socket."""
    adapters = {}

    def listed():
        return [
            SimpleNamespace(device=path, vid=1, pid=2, serial_number=number, location=socket)
            for path, (number, socket) in adapters.items()
        ]

    monkeypatch.setattr(serial_port.list_ports, "comports", listed)
    monkeypatch.setattr(serial_port, "open_serial", lambda path: path)
    return adapters


@pytest.mark.parametrize("opened_before", [True, False])
def test_a_device_that_comes_back_at_another_path_is_found_even_by_who_has_not_opened_it(
    plugged, opened_before
):
    plugged["/dev/ttyUSB0"] = ("roomba", "1-1")
    address = SerialAddress("/dev/ttyUSB0")
    if opened_before:
        assert address.open() == "/dev/ttyUSB0"
    plugged["/dev/ttyUSB1"] = plugged.pop("/dev/ttyUSB0")
    plugged["/dev/ttyUSB0"] = ("lidar", "1-2")
    handed_on = address if opened_before else pickle.loads(pickle.dumps(address))
    assert handed_on.open() == "/dev/ttyUSB1"


@pytest.mark.parametrize(
    ("ours", "other", "back", "said"),
    [
        (("roomba", "1-1"), ("lidar", "1-1"), ("roomba", "1-3"), "plug it in again"),
        ((None, "1-1"), (None, "1-2"), (None, "1-1"), "where it was"),
    ],
    ids=["by its number", "without a number by its socket"],
)
def test_another_device_at_its_path_is_not_opened(plugged, ours, other, back, said):
    plugged["/dev/ttyUSB0"] = ours
    address = SerialAddress("/dev/ttyUSB0")
    address.open()
    plugged["/dev/ttyUSB0"] = other
    with pytest.raises(DeviceError, match=said):
        address.open()
    plugged["/dev/ttyUSB1"] = back
    assert address.open() == "/dev/ttyUSB1"


@pytest.mark.parametrize("path", ["a\0b", "", 5000 * "a", "/dev/null", "/dev/full", "/tmp"])
def test_a_path_that_is_no_serial_port_is_one_line(path):
    with pytest.raises(DeviceError, match=r"^serial port .*; "):
        SerialAddress(path).open()


def test_the_terminal_of_the_program_itself_is_no_port_and_nothing_is_written_to_it():
    ours, theirs = os.openpty()
    program = "import sys, drivers.roomba.serial_port as port; port.open_serial(sys.argv[1])"
    ended = subprocess.run(
        [sys.executable, "-c", program, os.ttyname(theirs)],
        stdin=theirs, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    os.set_blocking(ours, False)
    with pytest.raises(BlockingIOError):
        os.read(ours, 1)
    assert "this program's own terminal; not a serial port; name the base's port" in ended.stderr
    for end in (ours, theirs):
        os.close(end)
