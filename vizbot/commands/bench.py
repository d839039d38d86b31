"""`vizbot bench`: run a benchmark, print its tables, keep what is finished."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from benchmarks.claims import pages
from benchmarks.episodes.episode import Home
from benchmarks.episodes.homes import FIRST_HOME
from benchmarks.fast_world import bench as fast_world
from benchmarks.faults import bench as faults
from benchmarks.faults.page import faults_page
from benchmarks.harness.bench_plan import (
    ENCODER_ROWS,
    QUICK_SHARE_ROWS,
    SEARCHED,
    UNATTENDED,
    BenchPlan,
    BenchResult,
)
from benchmarks.harness.fingerprint import Fingerprint
from benchmarks.loop import bench as loop
from benchmarks.objectnav import absent, multi_goal, retrieval, single_goal
from benchmarks.objectnav.search_page import write_search_page
from benchmarks.planner import bench as planner
from benchmarks.planner.page import planner_page
from benchmarks.questions import bench as questions
from benchmarks.slam import homes as slam_homes
from benchmarks.slam import hours as slam_hours
from benchmarks.slam import recordings as slam
from drivers.tum_sequence import parse_intrinsics
from sim_stubs.world.world_spec import is_bare, require_world, seed_of
from vizbot.commands.options import BenchOptions
from vizbot.config import Config, load_config
from vizbot.core.errors import ConfigError
from vizbot.core.files import require_folder, write_whole
from vizbot.operator.printing import echo

RUNS = Path("runs/bench")
"""Results that no folder was named for; those that are published lie in `pages.ROWS`."""
SCOREBOARD = RUNS / "scoreboard"
"""Finished episodes of the robot as it is."""
QUICK_SHARE = SCOREBOARD.with_name(QUICK_SHARE_ROWS)
"""Finished episodes of quick runs in homes of development, kept apart from those of the board."""
FAULTS = RUNS / "faults"
"""Results of drives and missions with faults."""
SLAM = RUNS / "slam"
"""Results of laps and of hours in one home."""
BARE = RUNS / "bare"
"""Finished episodes in homes with bare walls."""
OTHERS = RUNS / "others"
"""Finished episodes in homes drawn by others."""
PLANNER = RUNS / "planner"
"""Times of planners."""
FAST_WORLD = Path("runs/fast_world")
"""Views and walks of the fast world, which are no results."""
QUESTIONS = RUNS / "questions"
"""Answers of the maps of recordings."""
TRAJECTORIES = Path("runs/slam")
"""Trajectories of recordings."""
BENCHES = {
    single_goal.NAME: single_goal.run_single_goal,
    multi_goal.NAME: multi_goal.run_multi_goal,
    retrieval.NAME: retrieval.run_retrieval,
    absent.NAME: absent.run_absent,
}
"""Benchmarks of the scoreboard."""
NAMES = (*BENCHES, slam.NAME, questions.NAME, planner.NAME, loop.NAME, faults.NAME)
"""All benchmarks."""


def run(options: BenchOptions) -> None:
    """Run a benchmark and refuse arguments that are not for it.

    Raises:
        VizbotError: an argument cannot be used, or a world cannot be built.
    """
    if options.against is not None and options.name != loop.NAME:
        raise ConfigError(f"--against {options.against} is for loop alone; leave it out")
    if options.goals is not None:
        if options.name != single_goal.NAME or options.fast:
            raise ConfigError(
                f"--goals {options.goals} is for {single_goal.NAME} without --fast; leave it out"
            )
        if options.quick:
            raise ConfigError(f"--quick chooses its goals; leave out --goals {options.goals}")
    if options.fast and options.name != single_goal.NAME:
        raise ConfigError(f"--fast is for {single_goal.NAME} alone; leave it out")
    if options.method is not None and options.name not in (single_goal.NAME, multi_goal.NAME):
        raise ConfigError(
            f"--method {options.method} is for {single_goal.NAME} and {multi_goal.NAME}; leave it"
            " out"
        )
    scaled = (single_goal.NAME, retrieval.NAME, absent.NAME)
    if options.encoder_scale is not None and options.name not in scaled:
        raise ConfigError(
            f"--encoder-scale {options.encoder_scale} is for {', '.join(scaled)}; leave it out"
        )
    own_rows = {"--method": options.method, "--encoder-scale": options.encoder_scale}
    named = [f"{option} {value}" for option, value in own_rows.items() if value is not None]
    named += [] if options.rows is None else [f"--rows {options.rows}"]
    if len(named) > 1:
        raise ConfigError(f"{named[0]} is a row of its own; leave out {' and '.join(named[1:])}")
    _require_out(options.out)
    if options.check or options.figures:
        _run_figures(options)
    elif not options.name:
        raise ConfigError(f"which benchmark? use {', '.join(NAMES)}")
    elif options.fast:
        _run_fast(options)
    elif options.name == faults.NAME:
        _run_faults(options)
    elif options.name == slam.NAME:
        _run_slam(options)
    elif options.name == questions.NAME:
        _run_questions(options)
    elif options.name == planner.NAME:
        _run_planner(options)
    elif options.name == loop.NAME:
        _run_loop(options)
    else:
        _run_scoreboard(options)


def _require_out(out: Path | None) -> None:
    """Refuse a folder that results cannot be written to before they are made."""
    if out is None:
        return
    try:
        require_folder(out)
    except OSError as error:
        raise ConfigError(f"--out {out}: {error.strerror}; give another folder") from error


_GIVEN_AS = {"name": "NAME", "sequence": "SEQ", "as_json": "--json"}
"""What a person gives where the name of an option's field does not say it."""


def _run_figures(options: BenchOptions) -> None:
    """Draw what is made of kept rows, and hold every figure against the rows."""
    alone = BenchOptions(check=options.check, figures=options.figures)
    other = [
        _GIVEN_AS.get(name, f"--{name.replace('_', '-')}")
        for name, value in asdict(options).items()
        if value != getattr(alone, name)
    ]
    if other:
        raise ConfigError(f"--check and --figures stand alone; leave out {', '.join(other)}")
    if options.figures:
        for path in pages.write_pages():
            echo(f"written: {path}", err=True)
    if not options.check:
        return
    problems = pages.problems()
    for problem in problems:
        echo(problem)
    if problems:
        raise ConfigError(f"{len(problems)} figures or pages are not what the kept rows say")
    echo("what README and pages claim is what the kept rows say")


def _run_faults(options: BenchOptions) -> None:
    """Run drives and missions with faults; all of them also write their page."""
    _refuse(options.name, {"SEQ": options.sequence, "--hours": options.hours})
    _refuse(options.name, {"--rows": options.rows, "--worlds": options.worlds})
    _refuse(options.name, _of_recordings(options))
    _refuse(options.name, {"--clip": options.clip, "--config": options.config})
    homes = _seeds(options.seeds) or faults.HOMES
    faults.require_homes(homes)
    out = options.out or FAULTS
    drives = faults.FaultBench(homes, options.quick, out)
    result = faults.run_faults(drives)
    _print(result, options.as_json)
    if drives == faults.FaultBench(faults.HOMES, False, out):
        page = pages.page_of(out)
        write_whole(page, faults_page(out, page).encode())
        echo(f"written: {page}", err=True)


def _run_questions(options: BenchOptions) -> None:
    """Ask the map of a recording."""
    name = options.name
    _refuse(name, {"--seeds": options.seeds, "--rows": options.rows, "--hours": options.hours})
    _refuse(name, {"--quick": options.quick or None, "--worlds": options.worlds})
    _refuse(name, _of_recordings(options) | {"--questions": None})
    if options.sequence is None or options.questions is None:
        raise ConfigError("questions need a recording and --questions FILE.toml")
    if options.out is None and options.config is not None:
        raise ConfigError("results with --config are kept apart; give a folder by --out")
    config, out = load_config(options.config, options.clip), options.out or QUESTIONS
    _print(
        questions.run_questions(options.sequence, options.questions, config, out), options.as_json
    )


def _run_planner(options: BenchOptions) -> None:
    """Time planners; a whole run also writes its page."""
    name = options.name
    _refuse(name, {"SEQ": options.sequence, "--seeds": options.seeds, "--rows": options.rows})
    _refuse(name, {"--hours": options.hours, "--worlds": options.worlds})
    _refuse(name, _of_recordings(options))
    _refuse(name, {"--clip": options.clip, "--config": options.config})
    out = options.out or (None if options.quick else PLANNER)
    _print(planner.run_planner(options.quick, out), options.as_json)
    if out is not None and not options.quick:
        page = pages.page_of(out)
        write_whole(page, planner_page(out, page).encode())
        echo(f"written: {page}", err=True)


def _run_loop(options: BenchOptions) -> None:
    """Time the ticks of rehearsals."""
    name = options.name
    _refuse(name, {"SEQ": options.sequence, "--seeds": options.seeds, "--rows": options.rows})
    _refuse(name, {"--hours": options.hours, "--worlds": options.worlds, "--out": options.out})
    _refuse(name, _of_recordings(options))
    _refuse(name, {"--clip": options.clip, "--config": options.config})
    plan = loop.LoopBench.quick if options.quick else loop.LoopBench
    _print(loop.run_loop(plan(options.against)), options.as_json)


def _run_slam(options: BenchOptions) -> None:
    """Run pose estimation on a recording, for hours in one home, or on laps in several."""
    _refuse(options.name, {"--rows": options.rows, "--clip": options.clip})
    _refuse(options.name, {"--worlds": options.worlds})
    _refuse(options.name, {"--questions": options.questions})
    config, out = load_config(options.config), options.out
    if options.sequence is not None:
        _print(slam.run_slam(_slam_bench(options.sequence, options, config)), options.as_json)
        return
    _refuse("slam without SEQ", _of_recordings(options))
    if out is None and options.config is not None:
        raise ConfigError("results with --config are kept apart; give a folder by --out")
    homes = _seeds(options.seeds)
    if options.hours is not None:
        _refuse("slam --hours", {"--quick": options.quick or None})
        home, *others = homes or (FIRST_HOME,)
        if others:
            raise ConfigError(
                f"--hours are driven in one home; give one of --seeds {options.seeds}"
            )
        driven = slam_hours.run_slam_hours(home, options.hours, config, out or SLAM)
        _print(driven, options.as_json)
        return
    result = slam_homes.run_slam_homes(homes, options.quick, config, out or SLAM)
    _print(result, options.as_json)


def _slam_bench(sequence: Path, options: BenchOptions, config: Config) -> slam.SlamBench:
    _refuse("slam with SEQ", {"--seeds": options.seeds, "--hours": options.hours})
    return slam.SlamBench(
        sequence,
        None if options.intrinsics is None else parse_intrinsics(options.intrinsics),
        options.stride or 1,
        options.vocabulary,
        config.perception.slam,
        options.out or TRAJECTORIES / sequence.resolve().name,
        1 if options.quick else slam.RUNS,
    )


def _run_scoreboard(options: BenchOptions) -> None:
    """Run a benchmark of the scoreboard; the whole scoreboard also writes its page."""
    name, clip, out = options.name, options.clip, options.out
    rows = _asked_rows(options)
    _refuse(name, {"SEQ": options.sequence, "--hours": options.hours, **_of_recordings(options)})
    if name not in BENCHES:
        raise ConfigError(f"unknown benchmark {name!r}; use {', '.join(NAMES)}")
    config, seeds = _unattended(options), _seeds(options.seeds)
    if out is None and (clip is not None or options.config is not None):
        raise ConfigError("results with --clip or --config are kept apart; give a folder by --out")
    homes: tuple[Home, ...] | None = seeds
    if options.worlds is not None:
        homes, rows = _worlds(options), rows or single_goal.DEFAULT
        out = out or (BARE if all(map(is_bare, homes)) else OTHERS)
    elif out is None and seeds is not None and min(seeds) < FIRST_HOME:
        raise ConfigError(
            f"home {min(seeds)} of --seeds is a training home (benchmark homes begin at"
            f" {FIRST_HOME}) and no part of the scoreboard; give a folder by --out"
        )
    driven = _rows(name, rows, config)
    fingerprint = Fingerprint.taken(config.clip)
    if not fingerprint.clean:
        echo(f"the sources are not those of a commit: results say {fingerprint.commit!r}", err=True)
    folder = out or (QUICK_SHARE if options.quick else SCOREBOARD)
    plan = BenchPlan(config, folder, fingerprint, homes, options.quick, driven, options.goals)
    result = BENCHES[name](plan)
    _print(result, options.as_json)
    if plan.full:
        page = pages.page_of(folder)
        if write_search_page(folder, page):
            echo(f"written: {page}", err=True)


def _asked_rows(options: BenchOptions) -> str | None:
    """Names of the rows that are asked for; each method and each scale of an encoder has one."""
    if options.encoder_scale is not None:
        return ENCODER_ROWS[options.encoder_scale]
    return single_goal.DEFAULT if options.method == "belief" else options.rows or options.method


def _run_fast(options: BenchOptions) -> None:
    """Compare rules of the search in the fast world, in homes of development."""
    _refuse("--fast", {"SEQ": options.sequence, "--hours": options.hours})
    _refuse("--fast", {"--worlds": options.worlds, **_of_recordings(options)})
    config, seeds = _unattended(options), _seeds(options.seeds)
    for seed in seeds or ():
        if not fast_world.is_of_development(seed):
            raise ConfigError(
                f"home {seed} of --seeds is none of development, which --fast is for; give homes"
                " from 0 to 999 or from 1100 to 1199"
            )
    rows = _known_rows(_asked_rows(options), [rule.name for rule in fast_world.rules(config)])
    made = Fingerprint.taken(config.clip)
    folder = options.out or FAST_WORLD
    plan = BenchPlan(config, folder, made, seeds, options.quick, rows)
    _print(fast_world.run_fast(plan), options.as_json)


def _unattended(options: BenchOptions) -> Config:
    """The settings of a robot that nobody stands beside, unless a file says otherwise."""
    config = load_config(options.config) if options.config is not None else UNATTENDED
    if options.clip is None:
        return config
    return config.model_copy(update={"clip": options.clip})


def _of_recordings(options: BenchOptions) -> dict[str, object]:
    """The arguments that are for recordings alone."""
    return {
        "--stride": options.stride,
        "--vocabulary": options.vocabulary,
        "--intrinsics": options.intrinsics,
        "--questions": options.questions,
    }


def _refuse(name: str, arguments: Mapping[str, object]) -> None:
    """Raise an error for the first of these arguments that was given."""
    for argument, value in arguments.items():
        if value is not None:
            raise ConfigError(f"{argument} {value} is not for {name}; leave it out")


def _print(result: BenchResult, as_json: bool) -> None:
    if as_json:
        content = {"name": result.name, "rows": result.rows, "summary": result.summary}
        echo(json.dumps(content))
    else:
        echo(result.text)


def _seeds(text: str | None) -> tuple[int, ...] | None:
    if text is None:
        return None
    parts = text.split(",")
    if not all(part.isascii() and part.isdigit() for part in parts):
        raise ConfigError(f"--seeds {text!r} are no seeds; give numbers, for example 1000,1001")
    return tuple(int(part) for part in parts)


def _worlds(options: BenchOptions) -> tuple[str, ...]:
    """The homes of --worlds, which only objectnav drives in: with bare walls, or in files.

    Those of ours without a modifier are named by --seeds. Results of the two kinds are kept apart.
    """
    if options.name != single_goal.NAME or options.seeds is not None:
        raise ConfigError(
            f"--worlds {options.worlds} are for {single_goal.NAME} without --seeds; leave them out"
        )
    assert options.worlds is not None
    worlds = tuple(options.worlds.split(","))
    for world in worlds:
        require_world(world)
        if seed_of(world) is not None and not is_bare(world):
            raise ConfigError(f"home {world} of --worlds has a seed alone; give it by --seeds")
    ours = [world for world in worlds if is_bare(world)]
    if ours and len(ours) < len(worlds) and options.out is None:
        raise ConfigError(
            f"--worlds {options.worlds}: results in bare homes and in those of others are kept"
            " apart; give a folder by --out"
        )
    return worlds


def _rows(name: str, text: str | None, config: Config) -> tuple[str, ...] | None:
    if text is None:
        return None
    if name == retrieval.NAME:
        if text not in ENCODER_ROWS.values():
            raise ConfigError(f"--rows {text} is not for {name}; leave it out")
        return (text,)
    if name == absent.NAME:
        return _known_rows(text, [*absent.ROWS, SEARCHED])
    variants = multi_goal.variants if name == multi_goal.NAME else single_goal.variants
    return _known_rows(text, [variant.name for variant in variants(config)])


def _known_rows(text: str | None, known: list[str]) -> tuple[str, ...] | None:
    """The rows that `text` names; None for all of them."""
    if text is None:
        return None
    rows = tuple(part.strip() for part in text.split(","))
    for row in rows:
        if row not in known:
            raise ConfigError(f"unknown row {row!r}; use {', '.join(known)}")
    return rows
