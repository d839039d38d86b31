"""A dataclass whose fields are the options of a command."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from vizbot.cli.flags import with_options


@dataclass(frozen=True)
class Inner:
    depth: Annotated[int, typer.Option("--how-deep", help="Metres.")] = 3


@dataclass(frozen=True)
class Options:
    place: Annotated[Path, typer.Argument(metavar="PLACE")]
    inner: Inner = field(default_factory=Inner)
    loud: Annotated[bool, typer.Option("--loud")] = False


@pytest.mark.parametrize(
    ("arguments", "options"),
    [
        (["here"], Options(Path("here"))),
        (["here", "--how-deep", "5", "--loud"], Options(Path("here"), Inner(5), True)),
    ],
)
def test_the_command_gets_every_field_nested_ones_too(arguments, options):
    taken = []
    app = typer.Typer()

    @app.command()
    @with_options(Options)
    def dive(options: Options) -> None:
        """Dive."""
        taken.append(options)

    assert CliRunner().invoke(app, arguments).exit_code == 0
    assert taken == [options]
    shown = CliRunner().invoke(app, ["--help"]).output
    assert "Dive." in shown and "PLACE" in shown and "--how-deep" in shown and "Metres." in shown
