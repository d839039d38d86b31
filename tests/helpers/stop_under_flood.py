"""How soon a stop reaches the wheels: `python -m tests.helpers.stop_under_flood`.

A robot drives a simulated Roomba through the process that owns its port, is flooded, and stopped
over and over: in turn as the console's button does it, as `vizbot stop` does, and as a sentence,
"stop". Base, robot, flood and people are processes of their own, as in a home. For each line "KIND
TRIES" that it reads it prints one of JSON: the times from the request to the speed 0 that the base
has read off its line [s], those of sentences by themselves, and what the flood did. With
`--own-network` it is behind a loopback of its own with the small buffers of a network card.
"""

import fcntl
import http.client
import json
import multiprocessing
import socket
import struct
import subprocess
import sys
import threading
import time
from contextlib import ExitStack, contextmanager, redirect_stdout

from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.reflex_process.process_link import ProcessLink
from drivers.roomba.serial_port import SerialAddress
from sim_stubs.roomba.base import SimulatedRoomba, run_on_wall_clock
from tests.helpers.beside import beside
from tests.helpers.roomba_rig import DEADLINE, Floor
from tests.helpers.served import served, step
from vizbot.commands import remote
from vizbot.core.clock import WallClock
from vizbot.core.types import Twist
from vizbot.operator.client.robot_client import RobotClient
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.twist_mux import TwistMux

AHEAD = Twist(0.2, 0.0)
GIVES_UP = 3.0
"""A stop that has had no effect for so long counts with this time [s]."""
PIPES = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
QUIET = 0.1
"""Wheels that have done the same for so long go on doing it [s]."""
_MTU = 1500
_SET_FLAGS, _SET_MTU, _UP = 0x8914, 0x8922, 0x41


class TimedFloor(Floor):
    """A floor that tells when the wheels begin to turn, as None, and when to rest, as a time."""

    def __init__(self, connection):
        super().__init__()
        self._connection = connection

    def set_wheel_speeds(self, left, right):
        turned = any(self.speeds)
        super().set_wheel_speeds(left, right)
        if any(self.speeds) != turned:
            self._connection.send(time.monotonic() if turned else None)


def run_base(connection):
    """The simulated base, until it is killed."""
    with SimulatedRoomba(TimedFloor(connection)) as stub:
        connection.send(stub.path)
        run_on_wall_clock(stub, threading.Event())


def run_robot(connection, path):
    """A robot whose program always drives ahead, and goes on after a stop where it is told to."""
    session = OperatorSession()
    session.on_step(step(0))
    config = RoombaConfig(silence_timeout=0.5)
    with Roomba(ProcessLink(SerialAddress(path).open, config), WallClock(), config) as base:
        shared = TwistMux(base, session.lease, session.stopped)

        def drive(ended):
            while not ended.wait(0.02):  # as the robot's loop does
                shared.drive(AHEAD)
                shared.hold()

        with beside(drive), served(session) as server:
            connection.send(server.url)
            while connection.recv():
                session.go_on()
                session.begin_step()
                connection.send(session.stops)


@contextmanager
def in_process(program, *arguments):
    """A program in another process; the connection to it."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=program, args=(theirs, *arguments))
    process.start()
    try:
        yield ours
    finally:
        process.terminate()
        process.join()


def heard(connection, timeout=DEADLINE):
    assert connection.poll(timeout), "it did not happen in time"
    return connection.recv()


def going_on(robot):
    """Have the robot go on; how often it was stopped until then."""
    robot.send(True)
    return heard(robot)


def newest(connection, timeout):
    """What has been sent last, once nothing more comes for so long [s]."""
    said = connection.recv()
    while connection.poll(timeout):
        said = connection.recv()
    return said


def stopping_time(base, robot, stop):
    """Time from a request until the wheels are told to rest for good [s]."""
    state, end = 0.0, time.monotonic() + DEADLINE
    while state is not None:  # until they turn, and do not rest again because the machine is slow
        assert time.monotonic() < end, "the wheels do not turn"
        going_on(robot)
        if base.poll(1.0):
            state = newest(base, QUIET)
    begun = time.monotonic()
    stopping = threading.Thread(target=stop)
    stopping.start()
    rests_since = None
    while rests_since is None and base.poll(max(0.0, begun + GIVES_UP - time.monotonic())):
        rests_since = newest(base, QUIET)  # None where they turn again after a pause of the machine
    stopping.join()
    return GIVES_UP if rests_since is None else rests_since - begun


def press_button(url):
    """Send the stop that the console's button sends."""
    connection = http.client.HTTPConnection(url.split("//")[1], timeout=GIVES_UP)
    own_page = {"Origin": url, "Sec-Fetch-Site": "same-origin", "Content-Type": "application/json"}
    connection.request("POST", "/stop", json.dumps({"who": "ann"}), own_page)
    assert json.load(connection.getresponse()) == {"stopped": True}
    connection.close()


def run_command(url):
    """Do what `vizbot stop` does."""
    with RobotClient(url, None) as client:
        remote.stop(client)


def type_stop(url):
    """Do what `vizbot say stop` does."""
    with RobotClient(url, None) as client:
        client.say("stop", "ann")


def make_own_network():
    """Bring up the loopback of this network namespace, with small buffers."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control:
        fcntl.ioctl(control, _SET_MTU, struct.pack("16sI", b"lo", _MTU))
        fcntl.ioctl(control, _SET_FLAGS, struct.pack("16sH", b"lo", _UP))


def under_flood(kind, tries, base, robot, url):
    """What became of so many stops while a flood of this kind lasted."""
    times, typed, unanswered = [], [], []

    def stop(way):
        try:
            way(url)
        except Exception as error:
            unanswered.append(repr(error))

    before = going_on(robot)
    program = [sys.executable, "-m", "tests.helpers.flood", kind, url.rsplit(":", 1)[1]]
    with subprocess.Popen(program, text=True, **PIPES) as flood:
        assert flood.stdout.readline() == "flooding\n"
        for number in range(tries):
            way = (press_button, run_command, type_stop)[number % 3]
            took = stopping_time(base, robot, lambda way=way: stop(way))
            (typed if way is type_stop else times).append(took)
        flood.stdin.close()
        opened = int(flood.stdout.readline())
    return {"times": times, "typed": typed, "unanswered": unanswered, "opened": opened,
            "stops": going_on(robot) - before}  # fmt: skip


def main(*flags):
    if "--own-network" in flags:
        make_own_network()
    with ExitStack() as opened:
        base = opened.enter_context(in_process(run_base))
        robot = opened.enter_context(in_process(run_robot, heard(base)))
        url = heard(robot)
        with RobotClient(url, None) as client:
            client.state()  # what the first request imports is loaded
        for line in sys.stdin:
            kind, tries = line.split()
            with redirect_stdout(sys.stderr):  # what commands say
                measured = under_flood(kind, int(tries), base, robot, url)
            sys.stdout.write(json.dumps(measured) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
