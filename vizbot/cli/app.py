"""The command line: options and one-line errors; the work is in `vizbot.commands`.

Everything heavy is imported by the command that needs it, so that `--help` answers at once.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer

from vizbot import __version__
from vizbot.cli.calibrate import calibrate_app
from vizbot.cli.config import config_app
from vizbot.cli.flags import with_options
from vizbot.cli.logs import show_events, show_warnings
from vizbot.cli.map import map_app
from vizbot.cli.remote import explore as explore_remotely
from vizbot.cli.remote import goal, say, status, stop, teleop, voice
from vizbot.cli.standard_error import lose_what_cannot_be_written
from vizbot.commands.options import (
    ClipOption,
    ConfigOption,
    DryRunOptions,
    JsonOption,
    LaunchOptions,
    VerboseOption,
)
from vizbot.core.errors import ConfigError, VizbotError
from vizbot.core.program.garbage import collecting_afterwards, keep_freed_memory
from vizbot.core.program.interrupts import ending_on_signals, is_interrupt
from vizbot.core.program.threads import keep_a_core_free, let_threads_sleep
from vizbot.operator.printing import echo

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


Command = TypeVar("Command", bound=Callable[..., None])

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
_RUN, _ASK = "Rehearse and drive", "Ask a robot that is running"
_SET_UP, _LOOK_BACK = "Set up", "Maps and measurements"

_UsageError: Any = typer.BadParameter.__base__
"""Typer carries its own click and does not name this class of it."""


def _show_version(wanted: bool) -> None:
    if wanted:
        echo(f"vizbot {__version__}")
        raise typer.Exit


def _command(name: str, panel: str, example: str) -> Callable[[Command], Command]:
    """Add a command to a panel of the help, with an example."""
    return app.command(name, rich_help_panel=panel, epilog=f"Example: vizbot {name} {example}")


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
    """Have a Roomba with an RGB-D camera map a home and go to what you ask for."""
    if verbose:
        show_events()


@_command("dry-run", _RUN, '"yellow chair" --world 1100')
@with_options(DryRunOptions)
def dry_run(options: DryRunOptions) -> None:
    """Rehearse the whole job with any mix of real and simulated devices."""
    if options.run.verbose:
        show_events()
    if options.faults == "list":
        from vizbot.rehearsal.fault_table import show

        show()
        return
    keep_freed_memory()
    if options.base != "none":
        keep_a_core_free()
    with collecting_afterwards():
        from vizbot.commands.run_plan import plan_dry_run, world_beside

        plan = plan_dry_run(options)  # refuse impossible options before the rest is loaded
    with world_beside(plan) as world:
        with collecting_afterwards():
            from vizbot.commands.dry_run import run

        succeeded = run(plan, options, world)
    raise typer.Exit(0 if succeeded else 1)


@_command("launch", _RUN, "--clip ViT-L/14 --host 0.0.0.0")
@with_options(LaunchOptions)
def launch(options: LaunchOptions) -> None:
    """Run on the robot, with goals from `vizbot goal` or typed one a line; Ctrl-C ends it."""
    if options.run.verbose:
        show_events()
    keep_freed_memory()
    keep_a_core_free()
    with collecting_afterwards():
        from vizbot.commands.run_plan import plan_launch

        plan = plan_launch(options)
        from vizbot.commands.launch import run

    run(plan, options)


@_command("doctor", _SET_UP, "--config robot.toml")
def doctor(
    clip: ClipOption = None, config: ConfigOption = None, as_json: JsonOption = False
) -> None:
    """Check every device and say what is wrong and how to fix it; nothing moves."""
    from vizbot.commands.doctor import run

    run(config, clip, as_json)


@app.command(
    "bench",
    rich_help_panel=_LOOK_BACK,
    add_help_option=False,
    context_settings={
        "allow_extra_args": True,
        "allow_interspersed_args": False,
        "ignore_unknown_options": True,
    },
)
def run_bench(context: typer.Context) -> None:
    """Run a benchmark of the paper, or of pose estimation; finished rows are kept."""
    from vizbot.commands.bench import run

    run(context)


_command("teleop", _RUN, "--base sim")(teleop)
_command("goal", _ASK, '"yellow chair" --wait')(goal)
_command("say", _ASK, '"where is the sofa?"')(say)
_command("explore", _ASK, "--wait")(explore_remotely)
_command("stop", _ASK, "--url http://robot.local:8177")(stop)
_command("status", _ASK, "--json")(status)
_command("voice", _ASK, '--wake "hey robot"')(voice)
app.add_typer(calibrate_app, name="calibrate", rich_help_panel=_SET_UP)
app.add_typer(config_app, name="config", rich_help_panel=_SET_UP)
app.add_typer(stub_app, name="stub", rich_help_panel=_SET_UP)
app.add_typer(map_app, name="map", rich_help_panel=_LOOK_BACK)


def _require_utf8(arguments: Sequence[str]) -> None:
    """Refuse arguments that cannot be written into files of the run.

    Raises:
        ConfigError: an argument is not UTF-8.
    """
    for argument in arguments:
        try:
            argument.encode()
        except UnicodeEncodeError as error:
            raise ConfigError(f"{argument!a} is not UTF-8; write it in UTF-8") from error


def _usage(error: Any) -> str:
    """What is wrong with the words of a command, in a sentence; empty where the help was shown.

    Typer proposes options that are alike by their dashes alone, and reports pydantic's words about
    a value without the value.
    """
    message = str(error.format_message()).strip()
    if proposed := getattr(error, "possibilities", None):
        names = [each.strip("-") for each in proposed]
        meant = get_close_matches(getattr(error, "option_name", "").strip("-"), names)
        alike = ", ".join(f"--{each}" for each in meant)
        message = f"{error.message}." + (f" Did you mean {alike}?" if alike else "")
    elif type(error.__cause__).__name__ == "ValidationError":
        from vizbot.core.settings import causes

        wrong = causes(error.__cause__.errors())[0]
        message = f"{error.param.opts[0]} {wrong['input']}: {wrong['msg'].rstrip('.')}."
    return message if not message or message[-1] in ".?" else f"{message}."


def main() -> None:
    """Entry point: what goes wrong is one line on standard error, and exit code 1."""
    let_threads_sleep()
    lose_what_cannot_be_written()
    show_warnings()
    try:
        _require_utf8(sys.argv)
        with ending_on_signals():
            code = app(standalone_mode=False, prog_name="vizbot")
    except _UsageError as error:
        if message := _usage(error):  # without arguments the help itself has been shown
            # A parser that misses an option's value does not know whose option it is.
            command = error.ctx.command_path if error.ctx else "vizbot"
            echo(f"vizbot: {message} See: {command} --help", err=True)
        sys.exit(1)
    except (VizbotError, OSError) as error:
        echo(f"vizbot: {' '.join(str(error).splitlines())}", err=True)
        sys.exit(1)
    except BaseException as error:
        if not isinstance(error, typer.Abort) and not is_interrupt(error):
            raise
        code = 130
    if code == 130:  # which Typer makes of an interrupt inside a command
        echo("vizbot: interrupted", err=True)
    sys.exit(code)
