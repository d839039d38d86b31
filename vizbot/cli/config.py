"""`vizbot config`: its options; the work is in `vizbot.commands.config`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vizbot.commands.options import ConfigOption

config_app = typer.Typer(help="Show settings, or write a settings file.", no_args_is_help=True)


@config_app.command("init", epilog="Example: vizbot config init --out robot.toml")
def config_init(
    out: Annotated[Path, typer.Option("--out", help="Write the settings into this file.")] = Path(
        "robot.toml"
    ),
    every: Annotated[
        bool, typer.Option("--all", help="Write advanced settings, too, as comments.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
) -> None:
    """Write a settings file with the serial port and the camera that are plugged in."""
    from vizbot.commands.config.commands import init

    init(out, every=every, force=force)


@config_app.command("show", epilog="Example: vizbot config show")
def config_show(config: ConfigOption = None) -> None:
    """Print the settings in use as TOML; which file they are from goes to standard error."""
    from vizbot.commands.config.commands import show

    show(config)


@config_app.command("schema", epilog="Example: vizbot config schema --markdown")
def config_schema(
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Print the page docs/settings.md instead.")
    ] = False,
) -> None:
    """Print every setting with description, unit, default and bounds, as a JSON schema."""
    from vizbot.commands.config.commands import schema

    schema(markdown=markdown)
