"""A robot does not care what the time of day is, nor that it jumps."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from mapping import map_bundle
from sim_stubs.world.body import Contacts
from tests.helpers import filmed_room
from tests.helpers.bundles import assert_same, bundle_of
from tests.helpers.roomba_rig import ASKED_EVERY, DEADLINE, rested, wait_for
from vizbot.operator.client.robot_client import RobotClient

pytestmark = pytest.mark.slow

JUMPS = """
import random, time
true, hours = time.time, random.Random(0)
time.time = lambda: true() + 3600.0 * hours.uniform(-12.0, 12.0)
time.time_ns = lambda: int(1e9 * time.time())
"""
"""For `sitecustomize`: in each Python process every reading of the time of day is another one."""
SOON = 0.5
"""From the cause until the wheels are told to rest for good [s]."""
QUIET = 1.0
"""Wheels that have rested for so long stay at rest [s]."""
LIFTED = Contacts(wheel_drops=(True, True))


@pytest.fixture
def launched(stub, tmp_path):
    """A robot in a program of its own, with its reflexes in others, whose clocks all jump."""
    (tmp_path / "sitecustomize.py").write_text(JUMPS)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    (tmp_path / "robot.toml").write_text(filmed_room.settings(stub.path))
    with subprocess.Popen(
        [sys.executable, *filmed_room.LAUNCH, "--config", "robot.toml"],
        stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        cwd=tmp_path, env=environment,
    ) as program:  # fmt: skip
        try:
            yield program
        finally:
            program.kill()


def assert_rests_after(act, floor):
    began = time.monotonic()
    act()
    wait_for(lambda: rested(floor, QUIET), pause=0.01)
    assert floor.rest_since - began < SOON


def test_a_robot_whose_clocks_jump_by_hours_stops_in_time_and_keeps_its_map(
    launched, floor, tmp_path
):
    began = time.monotonic()
    url = next(line for line in launched.stderr if "http://" in line)
    with RobotClient("http://" + url.split("http://")[1].split()[0], None) as robot:

        def search():
            robot.ask(["red lamp"], at_once=True)
            wait_for(lambda: any(floor.speeds), pause=0.01)

        wait_for(lambda: robot.state()["step"] is not None, ASKED_EVERY)
        search()
        assert_rests_after(lambda: launched.send_signal(signal.SIGSTOP), floor)
        launched.send_signal(signal.SIGCONT)
        wait_for(lambda: any(floor.speeds), pause=0.01)
        assert_rests_after(lambda: robot.stop("ann"), floor)
        search()
        assert_rests_after(lambda: setattr(floor, "contacts", LIFTED), floor)
        # It stops first and reports second.
        wait_for(lambda: robot.state()["goals"][-1]["outcome"] == "gave_up")
    launched.send_signal(signal.SIGTERM)
    launched.communicate(timeout=DEADLINE)
    assert launched.returncode == 0
    stamps = map_bundle.load(tmp_path / "run/map").trajectory.stamps
    assert len(stamps) > 1 and np.diff(stamps).min() > 0.0
    assert np.ptp(stamps) < time.monotonic() - began
    times = [line[:19] for line in (tmp_path / "run/vizbot.log").read_text().splitlines()]
    assert times != sorted(times)  # or the clock did not jump


def test_a_map_replaces_one_of_a_later_date(tmp_path):
    for year in (2100, 1970):
        bundle = replace(bundle_of(year), created=datetime(year, 1, 1, tzinfo=UTC))
        map_bundle.save(bundle, tmp_path / "home")
        assert_same(map_bundle.load(tmp_path / "home"), bundle)
