"""What a run keeps when it is interrupted: `python -m tests.tools.interrupted_runs --moments N`.

A short dry run gets a real signal, drawn among those that end a program, at a drawn moment between
the making of its folder and its end. Whatever the moment, metrics, report, trajectory and commands
must be there, the map as soon as a frame was mapped, and no traceback. Prints one line of JSON for
each run that lost something, and one with the count and its interval.

Each run is a process of its own, forked from one that has loaded all that a run needs.
"""

import argparse
import json
import os
import shutil
import signal
import sys
import tempfile
import time
from importlib import import_module
from pathlib import Path

import numpy as np

from benchmarks.harness.scores import Rate
from mapping import map_bundle
from mapping.tum import read_trajectory
from vizbot.cli.process import run
from vizbot.core.errors import VizbotError
from vizbot.operator.printing import echo

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
SETTINGS = "[objectnav]\nmax_steps = 16\nlook_around = false\n"
ROOM = """
<mujoco>
  <worldbody>
    <geom type="plane" size="0 0 1" rgba="0.6 0.5 0.4 1"/>
    <geom type="box" size="0.1 2 1.2" pos="2 0 1.2" rgba="0.8 0.8 0.7 1"/>
    <geom type="box" size="0.1 2 1.2" pos="-2 0 1.2" rgba="0.7 0.8 0.8 1"/>
    <geom type="box" size="2 0.1 1.2" pos="0 2 1.2" rgba="0.8 0.7 0.8 1"/>
    <geom type="box" size="2 0.1 1.2" pos="0 -2 1.2" rgba="0.7 0.7 0.8 1"/>
    <light pos="0 0 2.2"/>
    <site name="start" pos="-1 -1 0"/>
    <body name="sofa#1" pos="1.4 1.4 0.4"><geom type="box" size="0.3 0.3 0.4"/></body>
  </worldbody>
</mujoco>
"""
LOADED = (
    "drivers.roomba.base",
    "mapping.clip.embedded.encoder",
    "sim_stubs.realsense.camera",
    "sim_stubs.roomba.base",
    "sim_stubs.scoring.success",
    "sim_stubs.world.world_name",
    "vizbot.commands.dry_run",
    "vizbot.commands.run_plan",
    "vizbot.operator.report.video",
)
"""What a run imports."""
DEADLINE = 300.0
_POLL = 0.002


def start(folder):
    """Begin a dry run in a folder in a forked process; returns its id."""
    if pid := os.fork():
        return pid
    os.setsid()
    os.chdir(folder)
    for descriptor, name in ((1, "out"), (2, "err")):
        os.dup2(os.open(name, os.O_CREAT | os.O_WRONLY, 0o644), descriptor)
    Path("settings.toml").write_text(SETTINGS)
    Path("room.xml").write_text(ROOM)
    options = ["--world", "room.xml", "--config", "settings.toml", "--out", "run", "--json"]
    sys.argv = ["vizbot", "dry-run", "sofa", *options]
    run()
    raise AssertionError("it has ended the process")


def interrupted(folder, share, number, length):
    """Run and interrupt after a share of its length [s]; returns its exit code and its length [s].

    No signal is sent with `number` None. The code is None for a run that had ended before.
    """
    pid = start(folder)
    code, sent, began = None, number is None, None
    deadline = time.monotonic() + DEADLINE
    while code is None:
        ended, status = os.waitpid(pid, os.WNOHANG)
        now = time.monotonic()
        if ended:
            code = os.waitstatus_to_exitcode(status)
        elif now > deadline:
            os.kill(pid, signal.SIGKILL)
        elif began is None:
            began = now if (folder / "run/config.toml").exists() else None
        elif not sent and now >= began + share * length:
            os.kill(pid, number)
            sent = True
        time.sleep(_POLL)
    return (code if sent else None), time.monotonic() - (began or time.monotonic())


def lost(folder, code):
    """What a run that was interrupted has lost, in words; empty where it has kept all."""
    run, found = folder / "run", []
    if "Traceback" in (folder / "err").read_text():
        found.append("a traceback")
    if code not in (0, 1, 130, -signal.SIGINT, -signal.SIGTERM, -signal.SIGHUP):
        found.append(f"exit code {code}")
    if not (run / "report.html").exists():
        found.append("no report")
    try:
        metrics = json.loads((run / "metrics.json").read_text())
    except (OSError, ValueError) as error:
        return [*found, f"no metrics: {error}"]
    if code == 130 and json.loads((folder / "out").read_text()) != metrics:
        found.append("no JSON")
    try:
        poses, _ = read_trajectory(run / "trajectory.tum")
        commands = (run / "commands.csv").read_text().splitlines()
    except (OSError, VizbotError) as error:
        return [*found, f"no trajectory or commands: {error}"]
    if len(poses) != metrics["steps"] or len(commands) != 1 + metrics["steps"]:
        found.append(f"{len(poses)} poses, {len(commands) - 1} commands, {metrics['steps']} steps")
    if metrics["steps"]:
        try:
            map_bundle.load(run / "map")
        except VizbotError as error:
            found.append(f"no map: {error}; {metrics['map_error']}")
    return found


def interrupt_at(moments, seed):
    """Interrupt a run at so many drawn moments.

    Yields:
        For each what it has lost, and what was done to it.
    """
    for module in LOADED:
        import_module(module)
    rng = np.random.default_rng(seed)
    scratch = tempfile.mkdtemp()  # not as an object, which each fork would remove at its end
    try:
        whole = Path(scratch, "whole")
        whole.mkdir()
        code, length = interrupted(whole, 1.0, None, 0.0)
        assert code == 1 and not lost(whole, code), (whole / "err").read_text()
        number = 0
        while number < moments:
            folder = Path(scratch, str(number))
            folder.mkdir(exist_ok=True)
            share, ending = rng.uniform(), ENDING[rng.integers(len(ENDING))]
            code, _ = interrupted(folder, share, ending, length)
            if code is None:  # it was faster this time: another draw
                folder.rename(Path(scratch, f"ended before {number} {share}"))
                continue
            number += 1
            yield lost(folder, code), {"share": share, "signal": ending.name, "code": code}
            shutil.rmtree(folder)
    finally:
        shutil.rmtree(scratch)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--moments", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    kept, codes = 0, {}
    for what, how in interrupt_at(options.moments, options.seed):
        kept += not what
        codes[how["code"]] = codes.get(how["code"], 0) + 1
        if what:
            echo(json.dumps(how | {"lost": what}))
    rate = Rate(kept, options.moments)
    low, high = rate.interval()
    echo(
        json.dumps(
            {"moments": options.moments, "seed": options.seed, "kept": kept, "codes": codes}
            | {"interval": [round(low, 4), round(high, 4)]}
        )
    )
    sys.exit(kept < options.moments)


if __name__ == "__main__":
    main()
