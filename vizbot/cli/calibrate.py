"""`vizbot calibrate`: its options; the work is in `vizbot.commands`."""

from __future__ import annotations

from dataclasses import dataclass

import typer

from vizbot.cli.flags import with_options
from vizbot.commands.options import CalibrateEncoderOptions, CalibrateOptions

calibrate_app = typer.Typer(
    invoke_without_command=True, epilog="Example: vizbot calibrate --out robot.toml"
)


@dataclass(frozen=True, slots=True)
class _Call:
    """Options of `vizbot calibrate`, and whether `encoder` follows."""

    context: typer.Context
    options: CalibrateOptions


@calibrate_app.callback()
@with_options(_Call)
def calibrate(call: _Call) -> None:
    """Measure wheels and mount: the robot turns on the spot and drives 1.5 m ahead and back."""
    if call.context.invoked_subcommand is not None:
        return
    from vizbot.commands.calibrate import run

    run(call.options)


@calibrate_app.command("encoder", epilog="Example: vizbot calibrate encoder --clip ViT-B/32")
@with_options(CalibrateEncoderOptions)
def calibrate_encoder(options: CalibrateEncoderOptions) -> None:
    """Fit the belief to an encoder, by views of simulated homes; nothing moves."""
    from vizbot.commands.calibrate_encoder import run

    run(options)
