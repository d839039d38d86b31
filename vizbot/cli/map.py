"""`vizbot map`: its options; the work is in `vizbot.commands.map`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vizbot.cli.options import ClipOption, ConfigOption, IntrinsicsOption, JsonOption

map_app = typer.Typer(
    help="Build maps from recordings, ask them, export them.", no_args_is_help=True
)


@map_app.command("build")
def map_build(
    sequence: Annotated[Path, typer.Argument(metavar="SEQ", help="TUM folder, .db3 or .bag.")],
    out: Annotated[Path, typer.Option(help="Where the map is written.")],
    clip: ClipOption = None,
    config: ConfigOption = None,
    intrinsics: IntrinsicsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Build a map from a recording, frame by frame as the robot would."""
    from vizbot.commands.map import build

    build(sequence, out, clip, config, intrinsics, as_json)


@map_app.command("query")
def map_query(
    folder: Annotated[Path, typer.Argument(metavar="MAP")],
    text: Annotated[str, typer.Argument(help="What to look for.")],
    clip: ClipOption = None,
    as_json: JsonOption = False,
) -> None:
    """Ask a map in words."""
    from vizbot.commands.map import query

    query(folder, text, clip, as_json)


@map_app.command("export")
def map_export(
    folder: Annotated[Path, typer.Argument(metavar="MAP")],
    form: Annotated[
        str, typer.Option("--format", help="ply (coloured cloud) or tum (trajectory).")
    ],
    out: Annotated[Path, typer.Option(help="File to write.")],
) -> None:
    """Export a map for other programs."""
    from vizbot.commands.map import export

    export(folder, form, out)


@map_app.command("info")
def map_info(
    folder: Annotated[Path, typer.Argument(metavar="MAP")], as_json: JsonOption = False
) -> None:
    """Say what a map holds."""
    from vizbot.commands.map import describe

    describe(folder, as_json)
