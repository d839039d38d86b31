"""Other people's programs drive the simulated base."""

import signal
import subprocess
import sys

import pytest
import serial
from pycreate2 import Create2

from sim_stubs.roomba.base import SimulatedRoomba, on_wall_clock
from sim_stubs.world.body import FreeFloor
from tests.helpers.roomba_rig import DEADLINE, wait_for
from vizbot.core.types import BaseMode

pytestmark = pytest.mark.slow


@pytest.fixture
def stub():
    with on_wall_clock(SimulatedRoomba(FreeFloor())) as stub:
        yield stub


def test_pycreate2_drives_it_and_reads_its_sensors(stub):
    floor = stub._body
    robot = Create2(stub.path)
    robot.sleep_timer = 0.05
    try:
        robot.start()
        robot.safe()
        wait_for(lambda: stub.mode is BaseMode.SAFE)
        robot.drive_direct(200, 100)
        wait_for(lambda: floor.wheel_travel[1] > 0.05)
        sensors = robot.get_sensors()
        assert sensors.open_interface_mode == BaseMode.SAFE
        assert sensors.encoder_counts_right > sensors.encoder_counts_left > 0
        assert sensors.battery_capacity >= sensors.battery_charge > 0
        assert (sensors.velocity_right, sensors.velocity_left) == (200, 100)
        robot.drive_stop()
        wait_for(lambda: not stub._wheels.turning)
        robot.led(4, 0, 127)
        robot.createSong(0, [60, 8])
        robot.playSong(0)
        wait_for(lambda: stub.songs.slots.get(0) == ((60, 8),))
        robot.stop()
        wait_for(lambda: stub.mode is BaseMode.OFF)
    finally:
        robot.close()
        robot.drive_stop = robot.led = robot.stop = lambda *_: None  # what its __del__ would send
        robot.digit_led_ascii = lambda *_: None


def test_the_command_prints_the_port_and_enter_presses_clean():
    command = [sys.executable, "-m", "vizbot", "stub", "roomba"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, text=True, **pipes) as program:
        path = program.stdout.readline().strip()
        with serial.Serial(path, 115200, timeout=DEADLINE) as port:
            port.write(bytes([128, 142, 35]))
            assert port.read(1) == bytes([BaseMode.PASSIVE])
            program.stdin.write("\n")
            program.stdin.flush()

            def clean_is_pressed():
                port.write(bytes([142, 18]))
                return port.read(1) == b"\x01"

            wait_for(clean_is_pressed)
        program.send_signal(signal.SIGINT)
        _, said = program.communicate(timeout=DEADLINE)
    assert program.returncode == 0
    assert "before its dock" in said
    assert "Traceback" not in said and "interrupted" not in said
