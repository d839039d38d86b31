"""`vizbot map`: its options; the work is in `vizbot.commands.map`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vizbot.cli.flags import with_options
from vizbot.commands.options import JsonOption, MapArgument, MapBuildOptions, MapQueryOptions
from vizbot.core.program.garbage import collecting_afterwards

SavedName = Annotated[
    str, typer.Argument(metavar="NAME", help="Use this map, as `vizbot map list` names it.")
]

map_app = typer.Typer(
    help="Build maps from recordings; ask and export maps; list, rename and delete saved ones.",
    no_args_is_help=True,
)


@map_app.command("build", epilog="Example: vizbot map build recording --out office")
@with_options(MapBuildOptions)
def map_build(options: MapBuildOptions) -> None:
    """Build a map from a recording, frame by frame as the robot would."""
    from vizbot.commands.map import build

    build(options)


@map_app.command("query", epilog='Example: vizbot map query office "yellow chair"')
@with_options(MapQueryOptions)
def map_query(options: MapQueryOptions) -> None:
    """Ask a map in words."""
    with collecting_afterwards():
        from vizbot.commands.map import query

        query(options)


@map_app.command("export", epilog="Example: vizbot map export office --format ply --out office.ply")
def map_export(
    folder: MapArgument,
    form: Annotated[
        str,
        typer.Option(
            "--format",
            help="Write ply (coloured cloud), npz (elements), rrd (for rerun), nav2 (map.yaml and"
            " map.pgm) or tum (trajectory).",
        ),
    ],
    out: Annotated[Path, typer.Option(help="Write to this file, of nav2 into this folder.")],
    query: Annotated[
        str | None,
        typer.Option("--query", help="Give each point of a ply the probability that it is this."),
    ] = None,
    frame: Annotated[
        str, typer.Option("--frame", help="Whose trajectory a tum is: camera or base.")
    ] = "camera",
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
) -> None:
    """Export a map for other programs."""
    from vizbot.commands.map_export import MapExport, export

    export(MapExport(folder, form, out, query, frame, force))


@map_app.command("show", epilog="Example: vizbot map show office --out office-map")
def map_show(
    folder: MapArgument,
    out: Annotated[Path, typer.Option(help="Draw into this new folder: a page and map.png.")],
) -> None:
    """Draw a map from above, with its rooms."""
    from vizbot.commands.map import show

    show(folder, out)


@map_app.command("info", epilog="Example: vizbot map info office")
def map_info(folder: MapArgument, as_json: JsonOption = False) -> None:
    """Say what a map holds."""
    from vizbot.commands.map import describe

    describe(folder, as_json)


@map_app.command("list", epilog="Example: vizbot map list")
def map_list(as_json: JsonOption = False) -> None:
    """List the maps that were saved by name, newest first."""
    from vizbot.commands.map import list_saved

    list_saved(as_json)


@map_app.command("rename", epilog='Example: vizbot map rename home "ground floor"')
def map_rename(
    name: SavedName, new: Annotated[str, typer.Argument(metavar="NEW", help="Give it this name.")]
) -> None:
    """Rename a map that was saved by name."""
    from vizbot.commands.map import rename_saved

    rename_saved(name, new)


@map_app.command("delete", epilog="Example: vizbot map delete home")
def map_delete(
    name: SavedName,
    sure: Annotated[bool, typer.Option("--yes", help="Delete it without asking.")] = False,
) -> None:
    """Delete a map that was saved by name; one that a robot is in stays."""
    from vizbot.commands.map import delete_saved

    delete_saved(name, sure)
