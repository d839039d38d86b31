"""`vizbot stub`: simulated devices for other people's programs."""

from __future__ import annotations

import math
import threading
from pathlib import Path

from drivers.roomba.packets import Buttons
from sim_stubs.realsense.footage import record_footage
from sim_stubs.roomba.base import SimulatedRoomba, run_on_wall_clock
from sim_stubs.roomba.dock import SimulatedDock
from sim_stubs.world.body import FreeFloor
from sim_stubs.world.world_name import open_world
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.files import require_writable
from vizbot.core.geometry import planar
from vizbot.core.program.interrupts import ended_by_interrupt
from vizbot.operator.printing import echo
from vizbot.operator.typed_lines import typed_lines
from vizbot.rehearsal.config import RehearsalConfig

_LONGEST = 3600.0
"""Longest recording [s]."""
_DOCK_AHEAD = 2.0
"""Distance from the simulated Roomba to its dock [m]."""


def roomba() -> None:
    """Serve a simulated Roomba on an endless empty floor and print its port; Ctrl-C ends it."""
    dock = SimulatedDock(planar(_DOCK_AHEAD, 0.0, math.pi))
    with SimulatedRoomba(FreeFloor(), dock=dock) as stub:
        echo(stub.path)
        echo(
            f"A simulated Roomba listens there at 115200 baud, {_DOCK_AHEAD} m before its dock. "
            "Enter presses its Clean button, Ctrl-C ends it.",
            err=True,
        )
        threading.Thread(target=_press_clean, args=(stub,), daemon=True).start()
        with ended_by_interrupt():
            run_on_wall_clock(stub, threading.Event())


def realsense(world: str, out: Path, seconds: float) -> None:
    """Record a simulated RealSense on a robot that turns on the spot; print the file's name.

    Raises:
        ConfigError: there is no such world, or the file cannot be written.
        DeviceError: the machine cannot render.
    """
    if out.suffix != ".db3":
        raise ConfigError(f"--out {out}: the SDK records .db3 files; give the name of one")
    if out.exists():
        raise ConfigError(f"--out {out}: is there already; remove it, or give another name")
    if not out.absolute().parent.is_dir():
        raise ConfigError(f"--out {out}: its folder is not there; make it first")
    require_writable(out)
    if not 0.0 < seconds <= _LONGEST:
        raise ConfigError(
            f"--seconds {seconds:g}: a recording takes some time, {_LONGEST:g} seconds at most;"
            " give 10, say"
        )
    rehearsal = RehearsalConfig()
    with open_world(world, rehearsal.world, Config().mount.T_base_cam) as home:
        if home.notice:
            echo(home.notice, err=True)
        wheel_base = rehearsal.world.wheel_base
        frames = record_footage(home, wheel_base, rehearsal.sim_camera, out, seconds)
    echo(out)
    echo(
        f"{frames} frames with their IMU, for --camera {out} and for any RealSense program.",
        err=True,
    )


def _press_clean(stub: SimulatedRoomba) -> None:
    for _ in typed_lines():
        stub.press(Buttons.CLEAN)
