"""Options that several benchmarks share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.episodes.episode import EncoderScale
from mapping.clip.fitted.calibration import read_calibration
from vizbot.commands.options import ClipOption, JsonOption
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.files import require_folder
from vizbot.core.method import Method

SeedsOption = Annotated[
    str | None,
    typer.Option(
        "--seeds", help="Drive in these homes, for example 1000,1001; else those of the board."
    ),
]
QuickOption = Annotated[
    bool, typer.Option("--quick", help="Run a small part, in homes of development, for no claim.")
]
RowsOption = Annotated[
    str | None, typer.Option("--rows", help="Drive these rows, for example default; else all.")
]
MethodOption = Annotated[
    Method | None, typer.Option("--method", help="Drive the row of this method.")
]
EncoderScaleOption = Annotated[
    EncoderScale | None,
    typer.Option(
        "--encoder-scale",
        help="Drive the row with cosines like CLIP's, with offsets, or of an unknown scale.",
    ),
]
UseOption = Annotated[
    Path | None,
    typer.Option(
        "--use",
        metavar="FILE",
        help="Take the belief's numbers from this file of `vizbot calibrate encoder`; else those"
        " that come along, whatever this user has fitted.",
    ),
]
SettingsOption = Annotated[
    Path | None,
    typer.Option(
        "--config",
        help="Read settings from this TOML file; else the defaults: results depend on no file"
        " that a user happens to have.",
    ),
]
OutOption = Annotated[
    Path | None,
    typer.Option(
        "--out",
        help="Keep the results in this folder; else in one in runs. Published: docs/results/rows.",
    ),
]


@dataclass(frozen=True, slots=True)
class BoardOptions:
    """Options of every benchmark of the board."""

    seeds: SeedsOption = None
    quick: QuickOption = False
    rows: RowsOption = None
    clip: ClipOption = None
    use: UseOption = None
    config: SettingsOption = None
    out: OutOption = None
    as_json: JsonOption = False


def with_calibration(config: Config, file: Path | None) -> Config:
    """The settings with the numbers of --use, which are read beforehand.

    Raises:
        ConfigError: the file, or the one that the settings name, cannot be used.
    """
    if file is not None:
        config = config.model_copy(update={"clip_calibration": str(file)})
    if config.clip_calibration:
        read_calibration(Path(config.clip_calibration))
    return config


def folder_for(out: Path | None, default: Path) -> Path:
    """The folder of --out, else the default.

    Raises:
        ConfigError: results cannot be written to it, which is said before they are made.
    """
    if out is None:
        return default
    try:
        require_folder(out)
    except OSError as error:
        raise ConfigError(f"--out {out}: {error.strerror}; give another folder") from error
    return out


def seeds_of(text: str | None) -> tuple[int, ...] | None:
    """The homes of --seeds; None without it.

    Raises:
        ConfigError: they are no numbers.
    """
    if text is None:
        return None
    parts = text.split(",")
    if not all(part.isascii() and part.isdigit() for part in parts):
        raise ConfigError(f"--seeds {text!r} are no seeds; give numbers, for example 1000,1001")
    return tuple(int(part) for part in parts)
