"""The command line: options and one-line errors; the work is in `vizbot.commands`.

Everything heavy is imported by the command that needs it, so that `--help` answers at once.
"""

from __future__ import annotations

import logging
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from vizbot.cli.map import map_app
from vizbot.cli.options import (
    CertificateOption,
    ClipOption,
    ConfigOption,
    HostOption,
    IntrinsicsOption,
    JsonOption,
    KeyOption,
    MapOption,
    PortOption,
    RerunOption,
    SpeechOption,
)
from vizbot.cli.remote import explore as explore_remotely
from vizbot.cli.remote import goal, status, stop, teleop, voice
from vizbot.cli.stub import stub_app
from vizbot.core.errors import VizbotError
from vizbot.core.interrupts import ending_on_signals, is_interrupt
from vizbot.operator.client.endpoint import PORT, SPEECH

app = typer.Typer(
    help="A Roomba with an RGB-D camera that maps a home and goes to what is asked for.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.add_typer(map_app, name="map")
app.add_typer(stub_app, name="stub")
app.command("goal")(goal)
app.command("explore")(explore_remotely)
app.command("stop")(stop)
app.command("status")(status)
app.command("teleop")(teleop)
app.command("voice")(voice)

_UsageError: Any = typer.BadParameter.__base__
"""Typer carries its own click and does not name this class of it."""


@app.command("dry-run")
def dry_run(
    goals: Annotated[
        list[str] | None, typer.Argument(metavar="TEXT...", help="What to go to, in this order.")
    ] = None,
    camera: Annotated[str, typer.Option(help="sim, realsense, or a recording's path.")] = "sim",
    base: Annotated[
        str | None, typer.Option(help="sim, roomba or none; none is the default of recordings.")
    ] = None,
    world: Annotated[
        str,
        typer.Option(
            help="Seed of a simulated home, office, a Sweet Home 3D file (.sh3d),"
            " JAR/NAME of one in sweethome3d.jar, or an MJCF file."
        ),
    ] = "0",
    map_folder: MapOption = None,
    explore: Annotated[
        bool,
        typer.Option(
            "--explore",
            help="Drive until nothing is left to see; each TEXT is then looked up on the map,"
            " not driven to.",
        ),
    ] = False,
    clip: ClipOption = None,
    config: ConfigOption = None,
    intrinsics: IntrinsicsOption = None,
    faults: Annotated[
        str | None,
        typer.Option(
            metavar="LIST",
            help="What goes wrong, for example bump@20,camera-frozen@40+3,lost-bytes~2 (twice a"
            " minute); `list` says what there is.",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="The run's folder; runs/TIME if not given.")
    ] = None,
    serve: Annotated[
        bool, typer.Option("--serve", help="Let people ask and drive by hand, until Ctrl-C.")
    ] = False,
    host: HostOption = "127.0.0.1",
    port: PortOption = PORT,
    certificate: CertificateOption = None,
    key: KeyOption = None,
    speech: SpeechOption = SPEECH,
    rerun: RerunOption = False,
    as_json: JsonOption = False,
) -> None:
    """Rehearse the whole job with any mix of real and simulated devices."""
    if faults == "list":
        from vizbot.commands.faults import show

        show()
        return
    from vizbot.commands.dry_run import run
    from vizbot.operator.client.endpoint import Service

    success = run(
        goals=goals or [],
        explore=explore,
        camera=camera,
        base=base,
        world=world,
        map_folder=map_folder,
        clip=clip,
        config_path=config,
        intrinsics=intrinsics,
        faults=faults,
        out=out,
        serve_at=Service(host, port, certificate, key, speech) if serve else None,
        rerun=rerun,
        as_json=as_json,
    )
    raise typer.Exit(0 if success else 1)


@app.command()
def launch(
    map_folder: MapOption = None,
    clip: ClipOption = None,
    config: ConfigOption = None,
    out: Annotated[
        Path | None, typer.Option(help="The run's folder; runs/TIME if not given.")
    ] = None,
    host: HostOption = "127.0.0.1",
    port: PortOption = PORT,
    certificate: CertificateOption = None,
    key: KeyOption = None,
    speech: SpeechOption = SPEECH,
    rerun: RerunOption = False,
    force: Annotated[
        bool, typer.Option("--force", help="Launch even if the doctor finds something bad.")
    ] = False,
) -> None:
    """Run on the robot, with goals from `vizbot goal` or typed one a line; Ctrl-C ends it."""
    from vizbot.commands.launch import run
    from vizbot.operator.client.endpoint import Service

    run(
        map_folder=map_folder,
        clip=clip,
        config_path=config,
        out=out,
        serve_at=Service(host, port, certificate, key, speech),
        rerun=rerun,
        force=force,
    )


@app.command("doctor")
def doctor(
    clip: ClipOption = None, config: ConfigOption = None, as_json: JsonOption = False
) -> None:
    """Check every device and say what is wrong and how to mend it; nothing moves."""
    from vizbot.commands.doctor import run

    run(config, clip, as_json)


@app.command("calibrate")
def calibrate(
    config: ConfigOption = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Settings file to write, which keeps what else is in it; --config if not given."
        ),
    ] = None,
    camera: Annotated[str, typer.Option(help="realsense or sim.")] = "realsense",
    base: Annotated[str, typer.Option(help="roomba or sim.")] = "roomba",
    world: Annotated[str, typer.Option(help="For what is simulated, as in dry-run.")] = "office",
    yes: Annotated[bool, typer.Option("--yes", help="Start without asking.")] = False,
) -> None:
    """Measure wheels and mount: the robot turns on the spot and drives 1.5 m ahead and back."""
    from vizbot.commands.calibrate import run

    run(config, out, camera, base, world, yes)


@app.command("bench")
def run_bench(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="objectnav, multi, retrieval, slam or faults.")
    ],
    sequence: Annotated[
        Path | None,
        typer.Argument(metavar="[SEQ]", help="slam: a TUM folder; else simulated homes."),
    ] = None,
    seeds: Annotated[
        str | None, typer.Option(help="Homes, for example 1000,1001; else those of the scoreboard.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="A smoke test of under 45 minutes on two cores.")
    ] = False,
    rows: Annotated[
        str | None, typer.Option(help="objectnav: rows to drive, for example default; else all.")
    ] = None,
    hours: Annotated[
        float | None,
        typer.Option(help="slam: drive in one home for so long; does the cost stay?", min=0.001),
    ] = None,
    stride: Annotated[
        int | None, typer.Option(help="slam: use every so many frames.", min=1)
    ] = None,
    vocabulary: Annotated[
        Path | None,
        typer.Option(help="slam: ORBvoc.txt, for ORB-SLAM3 as a peer (pip install pyorbslam3)."),
    ] = None,
    intrinsics: IntrinsicsOption = None,
    clip: ClipOption = None,
    config: ConfigOption = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Folder of the results; else one in docs/results/rows, or runs/slam with SEQ."
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Run a benchmark of the paper, or of pose estimation; what is finished is kept."""
    from vizbot.commands.bench import BenchOptions, run

    options = BenchOptions(
        sequence=sequence,
        seeds=seeds,
        quick=quick,
        rows=rows,
        hours=hours,
        stride=stride,
        vocabulary=vocabulary,
        intrinsics=intrinsics,
        clip=clip,
        config_path=config,
        out=out,
    )
    run(name, options, as_json)


def main() -> None:
    """Entry point: what goes wrong is one line on standard error, and exit code 1."""
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s: %(message)s")
    try:
        with ending_on_signals():
            code = app(standalone_mode=False)
    except _UsageError as error:
        message = error.format_message().strip()
        if message:  # without arguments the help itself has been shown
            # A parser that misses an option's value does not know whose option it is.
            command = error.ctx.command_path if error.ctx else "vizbot"
            typer.echo(f"vizbot: {message} See: {command} --help", err=True)
        sys.exit(1)
    except (VizbotError, OSError) as error:
        typer.echo(f"vizbot: {error}", err=True)
        sys.exit(1)
    except (KeyboardInterrupt, typer.Abort, SystemError, ImportError) as error:
        if not isinstance(error, typer.Abort) and not is_interrupt(error):
            raise
        code = 130
    if code == 130:  # which Typer makes of an interrupt inside a command
        typer.echo("vizbot: interrupted", err=True)
    sys.exit(code)
