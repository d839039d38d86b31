"""`vizbot stub`: simulated devices for other people's programs."""

from __future__ import annotations

import threading

import typer

from sim_stubs.free_floor import FreeFloor
from sim_stubs.roomba import SimulatedRoomba, run_on_wall_clock


def roomba() -> None:
    """Serve a simulated Roomba on an endless empty floor and print its port; Ctrl-C ends it."""
    with SimulatedRoomba(FreeFloor()) as stub:
        typer.echo(stub.path)
        typer.echo("A simulated Roomba listens there at 115200 baud; Ctrl-C ends it.", err=True)
        run_on_wall_clock(stub, threading.Event())
