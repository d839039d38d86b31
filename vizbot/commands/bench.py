"""`vizbot bench`: run a benchmark, print its tables, keep what is finished."""

from __future__ import annotations

import json
from pathlib import Path

import typer

from drivers.sequence import parse_intrinsics
from vizbot.bench import multi, objectnav, retrieval, slam, slam_homes
from vizbot.bench.board import Board, Outcome
from vizbot.bench.fingerprint import Fingerprint
from vizbot.bench.scoreboard import write_page
from vizbot.bench.worlds import FIRST_HOME
from vizbot.config import Config, load_config
from vizbot.core.errors import ConfigError

SCOREBOARD = Path("docs/scoreboard")
"""Where the finished episodes of the robot as it is are kept."""
SLAM_HOMES = Path("docs/slam")
"""Where the results of laps are kept."""
TRAJECTORIES = Path("runs/slam")
"""Where trajectories of recordings are written."""
BENCHES = {bench.NAME: bench.run for bench in (objectnav, multi, retrieval)}


def run(
    *,
    name: str,
    seeds: str | None,
    quick: bool,
    rows: str | None,
    clip: str | None,
    config_path: Path | None,
    out: Path | None,
    as_json: bool,
) -> None:
    """Run what is missing of a benchmark and print it; the whole board also writes its page.

    Raises:
        VizbotError: an argument cannot be used, or a world cannot be built.
    """
    if name not in BENCHES:
        raise ConfigError(f"unknown benchmark {name!r}; use {', '.join([*BENCHES, slam.NAME])}")
    if rows is not None and name != objectnav.NAME:
        raise ConfigError(f"--rows are of {objectnav.NAME}, not of {name}; leave them out")
    config = load_config(config_path)
    if clip is not None:
        config = config.model_copy(update={"clip": clip})
    if out is None and (clip is not None or config_path is not None):
        raise ConfigError("results with --clip or --config are kept apart; give a folder by --out")
    homes = _seeds(seeds)
    if out is None and homes is not None and min(homes) < FIRST_HOME:
        raise ConfigError(
            f"home {min(homes)} of --seeds is a training home (benchmark homes begin at"
            f" {FIRST_HOME}) and no part of the scoreboard; give a folder by --out"
        )
    made = Fingerprint.taken(config.clip)
    if not made.clean:
        typer.echo(f"the sources are not those of a commit: results say {made.commit!r}", err=True)
    board = Board(config, out or SCOREBOARD, made, homes, quick, _rows(rows, config))
    outcome = BENCHES[name](board)
    _print(outcome, as_json)
    if board.full:
        typer.echo(f"written: {write_page(board)}", err=True)


def run_slam(
    *,
    sequence: Path,
    stride: int,
    vocabulary: Path | None,
    intrinsics: str | None,
    quick: bool,
    config_path: Path | None,
    out: Path | None,
    as_json: bool,
) -> None:
    """Compare pose estimators on a recording; `quick` times ours once instead of five times.

    Raises:
        VizbotError: the recording, the vocabulary or a setting cannot be used.
    """
    asked = slam.SlamBench(
        sequence,
        None if intrinsics is None else parse_intrinsics(intrinsics),
        stride,
        vocabulary,
        load_config(config_path).perception.slam,
        out or TRAJECTORIES / sequence.resolve().name,
        1 if quick else slam.RUNS,
    )
    _print(slam.run(asked), as_json)


def run_slam_in_homes(
    *, seeds: str | None, quick: bool, config_path: Path | None, out: Path | None, as_json: bool
) -> None:
    """Follow the robot through laps of simulated homes, with all sensors and without some.

    Raises:
        VizbotError: an argument cannot be used, or a home cannot be simulated.
    """
    if out is None and config_path is not None:
        raise ConfigError("results with --config are kept apart; give a folder by --out")
    config = load_config(config_path)
    _print(slam_homes.run(_seeds(seeds), quick, config, out or SLAM_HOMES), as_json)


def refuse(name: str, arguments: dict[str, object]) -> None:
    """Arguments that a benchmark has no use for must not be given.

    Raises:
        ConfigError: one is.
    """
    for argument, value in arguments.items():
        if value is not None:
            raise ConfigError(f"{argument} {value} is not for {name}; leave it out")


def _print(outcome: Outcome, as_json: bool) -> None:
    if as_json:
        content = {"name": outcome.name, "rows": outcome.rows, "summary": outcome.summary}
        typer.echo(json.dumps(content))
    else:
        typer.echo(outcome.text)


def _seeds(text: str | None) -> tuple[int, ...] | None:
    if text is None:
        return None
    parts = text.split(",")
    if not all(part.isascii() and part.isdigit() for part in parts):
        raise ConfigError(f"--seeds {text!r} are no seeds; give numbers, for example 1000,1001")
    return tuple(int(part) for part in parts)


def _rows(text: str | None, config: Config) -> tuple[str, ...] | None:
    if text is None:
        return None
    known = [variant.name for variant in objectnav.variants(config)]
    rows = tuple(part.strip() for part in text.split(","))
    for row in rows:
        if row not in known:
            raise ConfigError(f"unknown row {row!r}; use {', '.join(known)}")
    return rows
