"""Command line of `vizbot stub`; what it does is in `vizbot.rehearsal.stub`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

stub_app = typer.Typer(help="Simulate devices for any program.", no_args_is_help=True)


@stub_app.command("roomba", epilog="Example: vizbot stub roomba")
def stub_roomba() -> None:
    """Simulate a Roomba on a serial port that any program can open; Ctrl-C ends it."""
    from vizbot.rehearsal.stub import roomba

    roomba()


@stub_app.command("realsense", epilog="Example: vizbot stub realsense --out room.db3")
def stub_realsense(
    out: Annotated[Path, typer.Option(help="Write the recording to this .db3 file.")],
    world: Annotated[str, typer.Option(help="Simulate this world, as in dry-run.")] = "0",
    seconds: Annotated[float, typer.Option(help="Record this many seconds.")] = 10.0,
) -> None:
    """Record the RealSense of a robot that turns, for any RealSense program to play."""
    from vizbot.rehearsal.stub import realsense

    realsense(world, out, seconds)
