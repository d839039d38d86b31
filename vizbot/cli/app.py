"""The command line: options and one-line errors; the work is in `vizbot.commands`.

Everything heavy is imported by the command that needs it, so that `--help` answers at once.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from vizbot import __version__
from vizbot.cli.flags import with_options
from vizbot.cli.logs import show_events, show_warnings
from vizbot.cli.map import map_app
from vizbot.cli.remote import explore as explore_remotely
from vizbot.cli.remote import goal, status, stop, teleop, voice
from vizbot.cli.stub import stub_app
from vizbot.commands.options import (
    CalibrateOptions,
    ClipOption,
    ConfigOption,
    DryRunOptions,
    IntrinsicsOption,
    JsonOption,
    LaunchOptions,
    VerboseOption,
)
from vizbot.core.errors import VizbotError
from vizbot.core.interrupts import ending_on_signals, is_interrupt

app = typer.Typer(
    no_args_is_help=True,
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


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"vizbot {__version__}")
        raise typer.Exit


@app.callback()
def before_any_command(
    version: Annotated[
        bool,
        typer.Option(
            "--version", is_eager=True, callback=_show_version, help="Print the version and exit."
        ),
    ] = False,
    verbose: VerboseOption = False,
) -> None:
    """A Roomba with an RGB-D camera that maps a home and goes to what is asked for."""
    if verbose:
        show_events()


@app.command("dry-run")
@with_options(DryRunOptions)
def dry_run(options: DryRunOptions) -> None:
    """Rehearse the whole job with any mix of real and simulated devices."""
    if options.run.verbose:
        show_events()
    if options.faults == "list":
        from vizbot.commands.faults import show

        show()
        return
    from vizbot.commands.dry_run import run

    raise typer.Exit(0 if run(options) else 1)


@app.command("launch")
@with_options(LaunchOptions)
def launch(options: LaunchOptions) -> None:
    """Run on the robot, with goals from `vizbot goal` or typed one a line; Ctrl-C ends it."""
    if options.run.verbose:
        show_events()
    from vizbot.commands.launch import run

    run(options)


@app.command("doctor")
def doctor(
    clip: ClipOption = None, config: ConfigOption = None, as_json: JsonOption = False
) -> None:
    """Check every device and say what is wrong and how to mend it; nothing moves."""
    from vizbot.commands.doctor import run

    run(config, clip, as_json)


@app.command("calibrate")
@with_options(CalibrateOptions)
def calibrate(options: CalibrateOptions) -> None:
    """Measure wheels and mount: the robot turns on the spot and drives 1.5 m ahead and back."""
    from vizbot.commands.calibrate import run

    run(options)


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
    from vizbot.commands.bench import run

    run(
        name=name,
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
        as_json=as_json,
    )


def main() -> None:
    """Entry point: what goes wrong is one line on standard error, and exit code 1."""
    show_warnings()
    try:
        with ending_on_signals():
            code = app(standalone_mode=False, prog_name="vizbot")
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
