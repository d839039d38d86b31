"""What ends the program stops the wheels first: interrupts, kill, a dropped terminal."""

import signal
import subprocess
import sys
from functools import partial

import pytest

from sim_stubs.roomba.base import SimulatedRoomba, run_on_wall_clock
from sim_stubs.world.body import FreeFloor
from tests.helpers.beside import beside
from tests.helpers.roomba_rig import DEADLINE, wait_for
from vizbot.core.types import BaseMode

pytestmark = pytest.mark.slow

PROGRAM = """
import sys
from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.reflex_process.process_link import ProcessLink
from drivers.roomba.serial_port import SerialAddress
from vizbot.cli import app as cli
from vizbot.core.clock import WallClock
from vizbot.core.types import Twist

@cli.app.command()
def roll(port: str) -> None:
    clock, config = WallClock(), RoombaConfig(silence_timeout=0.5)
    with Roomba(ProcessLink(SerialAddress(port).open, config), clock, config) as base:
        while True:
            base.drive(Twist(0.2, 0.0))
            clock.sleep(0.02)

sys.argv = ["vizbot", "roll", sys.argv[1]]
cli.main()
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops_the_wheels_and_leaves_the_base_in_passive_mode(number):
    floor, command = FreeFloor(), [sys.executable, "-c", PROGRAM]
    with SimulatedRoomba(floor) as stub:
        with beside(partial(run_on_wall_clock, stub)):
            program = subprocess.Popen([*command, stub.path], stderr=subprocess.PIPE)
            try:
                wait_for(lambda: floor.wheel_travel[0] > 0.02)
                program.send_signal(number)
                program.send_signal(number)  # an impatient second one changes nothing
                _, errors = program.communicate(timeout=DEADLINE)
                wait_for(lambda: stub.mode is BaseMode.PASSIVE)
                travel = floor.wheel_travel
                assert program.returncode == 130
                assert b"Traceback" not in errors
            finally:
                program.kill()
        stub.advance(1.0)
        assert floor.wheel_travel == pytest.approx(travel, abs=0.02)
