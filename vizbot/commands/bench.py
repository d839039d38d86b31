"""`vizbot bench`: run a benchmark, print its tables, keep what is finished."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import typer

from drivers.tum_sequence import parse_intrinsics
from vizbot.bench.episodes.homes import FIRST_HOME
from vizbot.bench.faults import bench as faults
from vizbot.bench.harness.bench_plan import UNATTENDED, BenchPlan, BenchResult
from vizbot.bench.harness.fingerprint import Fingerprint
from vizbot.bench.objectnav import multi_goal, retrieval, single_goal
from vizbot.bench.objectnav.scoreboard import write_scoreboard_page
from vizbot.bench.slam import homes as slam_homes
from vizbot.bench.slam import hours as slam_hours
from vizbot.bench.slam import recordings as slam
from vizbot.config import Config, load_config
from vizbot.core.errors import ConfigError

RESULTS = Path("docs/results")
"""The folder of the published pages."""
SCOREBOARD, SCOREBOARD_PAGE = RESULTS / "rows/scoreboard", RESULTS / "scoreboard.md"
"""Finished episodes of the robot as it is, and the page that shows them."""
SCOREBOARD_PICTURES = RESULTS / "pictures/scoreboard"
"""Pictures on the page of the scoreboard."""
FAULTS, FAULTS_PAGE = RESULTS / "rows/faults", RESULTS / "faults.md"
"""Results of drives and missions with faults, and the page that shows them."""
SLAM_HOMES = RESULTS / "rows/slam"
"""Results of laps."""
TRAJECTORIES = Path("runs/slam")
"""Trajectories of recordings."""
BENCHES = {
    single_goal.NAME: single_goal.run_single_goal,
    multi_goal.NAME: multi_goal.run_multi_goal,
    retrieval.NAME: retrieval.run_retrieval,
}
"""Benchmarks of the scoreboard."""


def run(
    *,
    name: str,
    sequence: Path | None,
    seeds: str | None,
    quick: bool,
    rows: str | None,
    hours: float | None,
    stride: int | None,
    vocabulary: Path | None,
    intrinsics: str | None,
    clip: str | None,
    config_path: Path | None,
    out: Path | None,
    as_json: bool,
) -> None:
    """Run a benchmark and refuse arguments that are not for it.

    Raises:
        VizbotError: an argument cannot be used, or a world cannot be built.
    """
    of_recordings = {"--stride": stride, "--vocabulary": vocabulary, "--intrinsics": intrinsics}
    if name == faults.NAME:
        _refuse(name, {"SEQ": sequence, "--hours": hours, "--rows": rows, **of_recordings})
        _refuse(name, {"--clip": clip, "--config": config_path})
        homes = _seeds(seeds) or faults.HOMES
        faults.require_homes(homes)
        drives = faults.FaultBench(homes, quick, out or FAULTS)
        result = faults.run_faults(drives)
        _print(result, as_json)
        if drives == faults.FaultBench(faults.HOMES, False, FAULTS):
            faults.write_faults_page(FAULTS_PAGE, drives.folder, result)
            typer.echo(f"written: {FAULTS_PAGE}", err=True)
        return
    if name != slam.NAME:
        _refuse(name, {"SEQ": sequence, "--hours": hours, **of_recordings})
        _run_scoreboard(name, seeds, quick, rows, clip, config_path, out, as_json)
        return
    _refuse(name, {"--rows": rows, "--clip": clip})
    config = load_config(config_path)
    if sequence is not None:
        _refuse("slam with SEQ", {"--seeds": seeds, "--hours": hours})
        recording = None if intrinsics is None else parse_intrinsics(intrinsics)
        asked = slam.SlamBench(
            sequence,
            recording,
            stride or 1,
            vocabulary,
            config.perception.slam,
            out or TRAJECTORIES / sequence.resolve().name,
            1 if quick else slam.RUNS,
        )
        _print(slam.run_slam(asked), as_json)
        return
    _refuse("slam without SEQ", of_recordings)
    if hours is not None:
        _refuse("slam --hours", {"--quick": quick or None, "--out": out})
        home, *others = _seeds(seeds) or (FIRST_HOME,)
        if others:
            raise ConfigError(f"--hours are driven in one home; give one of --seeds {seeds}")
        _print(slam_hours.run_slam_hours(home, hours, config), as_json)
        return
    if out is None and config_path is not None:
        raise ConfigError("results with --config are kept apart; give a folder by --out")
    _print(slam_homes.run_slam_homes(_seeds(seeds), quick, config, out or SLAM_HOMES), as_json)


def _run_scoreboard(
    name: str,
    seeds: str | None,
    quick: bool,
    rows: str | None,
    clip: str | None,
    config_path: Path | None,
    out: Path | None,
    as_json: bool,
) -> None:
    """Run a benchmark of the scoreboard; the whole scoreboard also writes its page."""
    if name not in BENCHES:
        raise ConfigError(
            f"unknown benchmark {name!r}; use {', '.join([*BENCHES, slam.NAME, faults.NAME])}"
        )
    if rows is not None and name != single_goal.NAME:
        raise ConfigError(f"--rows are of {single_goal.NAME}, not of {name}; leave them out")
    config = load_config(config_path) if config_path is not None else UNATTENDED
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
    fingerprint = Fingerprint.taken(config.clip)
    if not fingerprint.clean:
        typer.echo(
            f"the sources are not those of a commit: results say {fingerprint.commit!r}", err=True
        )
    plan = BenchPlan(config, out or SCOREBOARD, fingerprint, homes, quick, _rows(rows, config))
    result = BENCHES[name](plan)
    _print(result, as_json)
    if plan.full:
        page = SCOREBOARD_PAGE if out is None else out.with_suffix(".md")
        write_scoreboard_page(plan, page, SCOREBOARD_PICTURES if out is None else out)
        typer.echo(f"written: {page}", err=True)


def _refuse(name: str, arguments: Mapping[str, object]) -> None:
    """Raise an error for the first of these arguments that was given."""
    for argument, value in arguments.items():
        if value is not None:
            raise ConfigError(f"{argument} {value} is not for {name}; leave it out")


def _print(result: BenchResult, as_json: bool) -> None:
    if as_json:
        content = {"name": result.name, "rows": result.rows, "summary": result.summary}
        typer.echo(json.dumps(content))
    else:
        typer.echo(result.text)


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
    known = [variant.name for variant in single_goal.variants(config)]
    rows = tuple(part.strip() for part in text.split(","))
    for row in rows:
        if row not in known:
            raise ConfigError(f"unknown row {row!r}; use {', '.join(known)}")
    return rows
