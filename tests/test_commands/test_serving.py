"""A dry run that people ask, drive by hand, and end."""

import asyncio
import csv
import json
import signal
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest
from websockets.asyncio.client import connect

from mapping import map_bundle
from tests.helpers.roomba_rig import ASKED_EVERY, DEADLINE, wait_for
from tests.helpers.served import drive_for
from vizbot.operator.client.robot_client import RobotClient

pytestmark = pytest.mark.slow


@contextmanager
def serving(folder, *options, max_steps=8):
    """A dry run in its own program, and a client that talks to it."""
    settings = f"[objectnav]\nmax_steps = {max_steps}\nlook_around = false\n"
    (folder / "short.toml").write_text(settings)
    arguments = ["dry-run", "--serve", "--port", "0", "--world", "0", "--config", "short.toml"]
    program = subprocess.Popen(
        [sys.executable, "-m", "vizbot", *arguments, "--json", *options],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        line = next(line for line in program.stderr if line.startswith("serving at "))
        with RobotClient(line.split()[2], None) as client:
            yield program, client, line.split()[2]
    finally:
        program.kill()
        program.communicate()


@pytest.fixture
def dry_run(tmp_path):
    with serving(tmp_path, "--out", "run") as run:
        yield run


def test_driving_by_hand_maps_and_goals_are_asked_for_until_somebody_ends_it(dry_run, tmp_path):
    program, client, url = dry_run
    wait_for(lambda: client.state()["step"] is not None, ASKED_EVERY)
    assert client.state()["run"] == str(tmp_path / "run")

    async def drive():
        async with connect(url.replace("http", "ws") + "/drive?who=ann") as socket:
            await drive_for(socket, 3.0, 0.2)

    began = np.array(client.state()["position"])
    asyncio.run(asyncio.wait_for(drive(), DEADLINE))
    assert np.linalg.norm(client.state()["position"] - began) > 0.1
    [number] = client.ask(["yellow chair"])
    wait_for(lambda: client.state()["goals"][0]["outcome"] is not None, ASKED_EVERY)
    [goal] = client.state()["goals"]
    assert (goal["number"], goal["outcome"]) == (number, "gave_up")
    assert goal["reason"] == "not done within 8 steps"
    program.send_signal(signal.SIGINT)
    out, errors = program.communicate(timeout=DEADLINE)
    assert out and "Traceback" not in errors, errors
    result = json.loads(out)
    assert program.returncode == 1 and not result["success"]
    assert [each["outcome"] for each in result["goals"]] == ["gave_up"]
    with (tmp_path / "run/commands.csv").open() as table:
        commands = list(csv.DictReader(table))
    assert {command["by"] for command in commands} >= {"ann", "robot"}
    assert max(float(each["linear"]) for each in commands if each["by"] == "ann") == 0.2
    kept = map_bundle.load(tmp_path / "run/map")
    # The step in which it was ended may be in the map, and not in the count.
    assert kept.frames.numbers[-1] <= result["steps"]
    lines = (tmp_path / "run/trajectory.tum").read_text().splitlines()
    assert len([line for line in lines if not line.startswith("#")]) - result["steps"] in (0, 1)
    assert np.linalg.norm(np.ptp(kept.trajectory.Ts_map_cam[:, :2, 3], axis=0)) > 0.1


def test_a_run_that_begins_in_a_saved_map_finds_its_place_unasked(dry_run, tmp_path):
    program, client, _ = dry_run
    wait_for(lambda: client.state()["step"], ASKED_EVERY)
    program.send_signal(signal.SIGINT)
    program.communicate(timeout=DEADLINE)
    with serving(tmp_path, "--map", "run", "--out", "again", max_steps=100) as (again, robot, _):
        assert "turns on the spot until it knows where it is" in again.stderr.readline()
        wait_for(lambda: robot.state()["goals"][0]["outcome"] is not None, ASKED_EVERY)
        [task] = robot.state()["goals"]
        assert (task["text"], task["outcome"]) == ("find its place on the map", "located")
        assert robot.state()["tracking"] in ("tracking", "relocalised")
        again.send_signal(signal.SIGINT)
        out, errors = again.communicate(timeout=DEADLINE)
        assert again.returncode == 0 and json.loads(out)["success"], f"{errors}\n{out}"
