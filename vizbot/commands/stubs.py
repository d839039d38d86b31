"""`vizbot stub`: simulated devices for other people's programs."""

from __future__ import annotations

import math
import sys
import threading

import typer

from drivers.roomba_packets import Buttons
from sim_stubs.free_floor import FreeFloor
from sim_stubs.roomba import SimulatedRoomba
from sim_stubs.roomba_dock import Dock
from sim_stubs.roomba_wall_clock import run_on_wall_clock
from vizbot.core.geometry import planar

_DOCK_AHEAD = 2.0


def roomba() -> None:
    """Serve a simulated Roomba on an endless empty floor and print its port; Ctrl-C ends it."""
    dock = Dock(planar(_DOCK_AHEAD, 0.0, math.pi))
    with SimulatedRoomba(FreeFloor(), dock=dock) as stub:
        typer.echo(stub.path)
        typer.echo(
            f"A simulated Roomba listens there at 115200 baud, {_DOCK_AHEAD} m before its dock. "
            "Enter presses its Clean button, Ctrl-C ends it.",
            err=True,
        )
        threading.Thread(target=_press_clean, args=(stub,), daemon=True).start()
        run_on_wall_clock(stub, threading.Event())


def _press_clean(stub: SimulatedRoomba) -> None:
    for _ in sys.stdin:
        stub.press(Buttons.CLEAN)
