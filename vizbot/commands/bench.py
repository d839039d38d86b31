"""`vizbot bench`: run a benchmark, print its tables, keep what is finished."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
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


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchOptions:
    """What `vizbot bench` was given; None for an option that was not.

    Attributes:
        sequence: Folder of a recording in TUM layout.
        seeds: Seeds of homes, separated by commas.
        quick: Whether to run only a small part, as a smoke test.
        rows: Names of rows, separated by commas.
        hours: Duration of a drive in one home [h].
        stride: Step between the frames that are used.
        vocabulary: Vocabulary of ORB-SLAM3.
        intrinsics: Intrinsics and depth scale of the recording.
        clip: The encoder.
        config_path: File of the settings.
        out: Folder of the results.
    """

    sequence: Path | None = None
    seeds: str | None = None
    quick: bool = False
    rows: str | None = None
    hours: float | None = None
    stride: int | None = None
    vocabulary: Path | None = None
    intrinsics: str | None = None
    clip: str | None = None
    config_path: Path | None = None
    out: Path | None = None

    @property
    def of_recordings(self) -> dict[str, object]:
        """The options that only a recording has a use for."""
        return {
            "--stride": self.stride,
            "--vocabulary": self.vocabulary,
            "--intrinsics": self.intrinsics,
        }


def run(name: str, options: BenchOptions, as_json: bool) -> None:
    """Run a benchmark and refuse options that are not for it.

    Raises:
        VizbotError: an option cannot be used, or a world cannot be built.
    """
    if name == faults.NAME:
        _run_faults(options, as_json)
    elif name != slam.NAME:
        _run_scoreboard(name, options, as_json)
    elif options.sequence is not None:
        _run_sequence(options, options.sequence, as_json)
    else:
        _run_laps(options, as_json)


def _run_faults(options: BenchOptions, as_json: bool) -> None:
    others = {"SEQ": options.sequence, "--hours": options.hours, "--rows": options.rows}
    _refuse(faults.NAME, {**others, **options.of_recordings})
    _refuse(faults.NAME, {"--clip": options.clip, "--config": options.config_path})
    homes = _seeds(options.seeds) or faults.HOMES
    faults.require_homes(homes)
    bench = faults.FaultBench(homes, options.quick, options.out or FAULTS)
    result = faults.run_faults(bench)
    _print(result, as_json)
    if bench == faults.FaultBench(faults.HOMES, False, FAULTS):
        faults.write_faults_page(FAULTS_PAGE, bench.folder, result)
        typer.echo(f"written: {FAULTS_PAGE}", err=True)


def _run_sequence(options: BenchOptions, sequence: Path, as_json: bool) -> None:
    _refuse(slam.NAME, {"--rows": options.rows, "--clip": options.clip})
    config = load_config(options.config_path)
    _refuse("slam with SEQ", {"--seeds": options.seeds, "--hours": options.hours})
    intrinsics = options.intrinsics
    bench = slam.SlamBench(
        sequence,
        None if intrinsics is None else parse_intrinsics(intrinsics),
        options.stride or 1,
        options.vocabulary,
        config.perception.slam,
        options.out or TRAJECTORIES / sequence.resolve().name,
        1 if options.quick else slam.RUNS,
    )
    _print(slam.run_slam(bench), as_json)


def _run_laps(options: BenchOptions, as_json: bool) -> None:
    _refuse(slam.NAME, {"--rows": options.rows, "--clip": options.clip})
    config = load_config(options.config_path)
    _refuse("slam without SEQ", options.of_recordings)
    if options.hours is not None:
        _refuse("slam --hours", {"--quick": options.quick or None, "--out": options.out})
        home, *others = _seeds(options.seeds) or (FIRST_HOME,)
        if others:
            raise ConfigError(
                f"--hours are driven in one home; give one of --seeds {options.seeds}"
            )
        _print(slam_hours.run_slam_hours(home, options.hours, config), as_json)
        return
    if options.out is None and options.config_path is not None:
        raise ConfigError("results with --config are kept apart; give a folder by --out")
    homes, folder = _seeds(options.seeds), options.out or SLAM_HOMES
    _print(slam_homes.run_slam_homes(homes, options.quick, config, folder), as_json)


def _run_scoreboard(name: str, options: BenchOptions, as_json: bool) -> None:
    """Run a benchmark of the scoreboard; the whole scoreboard also writes its page."""
    _refuse(name, {"SEQ": options.sequence, "--hours": options.hours, **options.of_recordings})
    clip, config_path, out = options.clip, options.config_path, options.out
    if name not in BENCHES:
        raise ConfigError(
            f"unknown benchmark {name!r}; use {', '.join([*BENCHES, slam.NAME, faults.NAME])}"
        )
    if options.rows is not None and name != single_goal.NAME:
        raise ConfigError(f"--rows are of {single_goal.NAME}, not of {name}; leave them out")
    config = load_config(config_path) if config_path is not None else UNATTENDED
    if clip is not None:
        config = config.model_copy(update={"clip": clip})
    if out is None and (clip is not None or config_path is not None):
        raise ConfigError("results with --clip or --config are kept apart; give a folder by --out")
    homes = _seeds(options.seeds)
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
    plan = BenchPlan(
        config, out or SCOREBOARD, fingerprint, homes, options.quick, _rows(options.rows, config)
    )
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
