"""`vizbot bench`: a command for each benchmark, with its tables; what is finished is kept."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, TypeVar

import typer

from benchmarks.claims import pages
from benchmarks.encoder import bench as encoder
from benchmarks.encoder import families
from benchmarks.episodes.episode import EncoderScale, Home
from benchmarks.episodes.homes import FIRST_HOME
from benchmarks.fast_world import bench as fast_world
from benchmarks.faults import bench as faults
from benchmarks.faults.bench import faults_page
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
from benchmarks.moved import bench as moved
from benchmarks.objectnav import absent, multi_goal, retrieval, single_goal
from benchmarks.objectnav.search_page import search_page
from benchmarks.options import (
    BoardOptions,
    EncoderScaleOption,
    MethodOption,
    OutOption,
    QuickOption,
    SeedsOption,
    SettingsOption,
    UseOption,
    folder_for,
    seeds_of,
    with_calibration,
)
from benchmarks.planner import bench as planner
from benchmarks.planner.bench import planner_page
from benchmarks.questions import bench as questions
from benchmarks.slam import homes as slam_homes
from benchmarks.slam import hours as slam_hours
from benchmarks.slam import recordings as slam
from drivers.tum_sequence import parse_intrinsics
from sim_stubs.world.world_spec import is_bare, require_world, seed_of
from vizbot.cli.flags import with_options
from vizbot.commands.options import ClipOption, IntrinsicsOption, JsonOption
from vizbot.config import Config, load_config
from vizbot.core.errors import ConfigError
from vizbot.core.files import write_whole
from vizbot.operator.printing import echo

Command = TypeVar("Command", bound=Callable[..., None])

RUNS = Path("runs/bench")
"""Results that no folder was named for; those that are published lie in `pages.ROWS`."""
BOARD_ROWS = RUNS / "board"
"""Finished episodes of the robot as it is."""
QUICK_SHARE = RUNS / QUICK_SHARE_ROWS
"""Finished episodes of quick runs in homes of development, kept apart from those of the board."""
BARE, OTHERS = RUNS / "bare", RUNS / "others"
"""Finished episodes in homes with bare walls, and in homes drawn by others."""
MOVED = RUNS / "moved"
"""Answers of homes in which things moved."""
FAST_WORLD = Path("runs/fast_world")
"""Views and walks of the fast world, which are no results."""
TRAJECTORIES = Path("runs/slam")
"""Trajectories of recordings."""

app = typer.Typer(
    add_completion=False,
    pretty_exceptions_enable=False,
    epilog="Example: vizbot bench objectnav --quick",
)


def _bench(name: str, example: str) -> Callable[[Command], Command]:
    """Add a benchmark, with an example for its help."""
    return app.command(name, epilog=f"Example: vizbot bench {name} {example}")


@app.callback(invoke_without_command=True)
def before_any_bench(
    context: typer.Context,
    check: Annotated[
        bool,
        typer.Option("--check", help="Compare what README and pages claim with the kept rows."),
    ] = False,
    figures: Annotated[
        bool,
        typer.Option(
            "--figures", help="Write every table and figure of docs/results from its rows."
        ),
    ] = False,
) -> None:
    """Run a benchmark of the paper, or of pose estimation; what is finished is kept."""
    name = context.invoked_subcommand
    if name is not None and (check or figures):
        raise ConfigError(f"--check and --figures stand alone; leave out {name}")
    if name is None and not (check or figures):
        names = ", ".join(str(each.name) for each in app.registered_commands)
        raise ConfigError(f"which benchmark? use {names}")
    if figures:
        for path in pages.write_pages():
            echo(f"written: {path}", err=True)
    if check:
        problems = pages.problems()
        for problem in problems:
            echo(problem)
        if problems:
            raise ConfigError(f"{len(problems)} figures or pages are not what the kept rows say")
        echo("what README and pages claim is what the kept rows say")


@dataclass(frozen=True, slots=True)
class ObjectNavOptions:
    """Options of `vizbot bench objectnav`."""

    board: BoardOptions
    worlds: Annotated[
        str | None,
        typer.Option(
            "--worlds",
            help="Drive in these homes, as for --world: bare ones, or files drawn by others.",
        ),
    ] = None
    goals: Annotated[
        int | None,
        typer.Option("--goals", help="Drive the first N goals of each home alone.", min=1),
    ] = None
    fast: Annotated[
        bool,
        typer.Option(
            "--fast", help="Compare rules on views that are rendered once; for development."
        ),
    ] = False
    method: MethodOption = None
    encoder_scale: EncoderScaleOption = None


@_bench(single_goal.NAME, "--quick")
@with_options(ObjectNavOptions)
def run_objectnav(options: ObjectNavOptions) -> None:
    """Search for each goal that the homes have, one at a time."""
    board, goals = options.board, options.goals
    scale = None if options.fast else options.encoder_scale
    rows = _asked_rows(board.rows, options.method, scale)
    if goals is not None and (board.quick or options.fast):
        raise ConfigError(f"--quick and --fast choose their goals; leave out --goals {goals}")
    if options.fast:
        if options.worlds is not None:
            raise ConfigError(
                f"--fast is for homes of --seeds; leave out --worlds {options.worlds}"
            )
        _run_fast(board, rows, options.encoder_scale)
        return
    worlds, folder = None, None
    if options.worlds is not None:
        worlds, rows = _worlds(options.worlds, board), rows or single_goal.DEFAULT
        folder = BARE if all(map(is_bare, worlds)) else OTHERS
    # A search without a part takes one goal of five, which leaves next to none in a few homes.
    known = [
        variant.name
        for variant in single_goal.variants(_unattended(board))
        if worlds is None or variant.ablated is None
    ]
    _run_board(board, single_goal.run_single_goal, rows, known, worlds, folder, goals)


@dataclass(frozen=True, slots=True)
class MultiOptions:
    """Options of `vizbot bench multi`."""

    board: BoardOptions
    method: MethodOption = None


@_bench(multi_goal.NAME, "--quick")
@with_options(MultiOptions)
def run_multi(options: MultiOptions) -> None:
    """Search for four goals in a row."""
    rows = _asked_rows(options.board.rows, options.method, None)
    known = [variant.name for variant in multi_goal.variants(_unattended(options.board))]
    _run_board(options.board, multi_goal.run_multi_goal, rows, known)


@dataclass(frozen=True, slots=True)
class MapOptions:
    """Options of the benchmarks that ask the maps of explored homes."""

    board: BoardOptions
    encoder_scale: EncoderScaleOption = None


@_bench(retrieval.NAME, "--quick")
@with_options(MapOptions)
def run_retrieval(options: MapOptions) -> None:
    """Explore the homes and ask their maps where things are."""
    rows = _asked_rows(options.board.rows, None, options.encoder_scale)
    if rows is not None and rows not in ENCODER_ROWS.values():
        raise ConfigError(f"--rows {rows} is not for {retrieval.NAME}; leave it out")
    _run_board(options.board, retrieval.run_retrieval, rows, list(ENCODER_ROWS.values()))


@_bench(absent.NAME, "--quick")
@with_options(MapOptions)
def run_absent(options: MapOptions) -> None:
    """Ask explored homes for what they do not have."""
    rows = _asked_rows(options.board.rows, None, options.encoder_scale)
    _run_board(options.board, absent.run_absent, rows, [*absent.ROWS, SEARCHED])


@_bench(moved.NAME, "--quick")
@with_options(BoardOptions)
def run_moved(options: BoardOptions) -> None:
    """Move things between two visits, and ask the map where they are."""
    homes = seeds_of(options.seeds) or moved.HOMES
    chosen = homes[: moved.QUICK_HOMES] if options.quick else homes
    _run_board(options, moved.run_moved, options.rows, [], chosen, MOVED)


@_bench(slam.NAME, "--quick")
def run_slam(
    sequence: Annotated[
        Path | None,
        typer.Argument(metavar="[SEQ]", help="Use this TUM folder; else simulated homes."),
    ] = None,
    seeds: SeedsOption = None,
    hours: Annotated[
        float | None,
        typer.Option(
            "--hours",
            help="Drive this many hours in one home, to see whether a frame costs more.",
            min=0.001,
            max=1000.0,
        ),
    ] = None,
    stride: Annotated[
        int | None, typer.Option("--stride", help="Use every n-th frame.", min=1, max=1000)
    ] = None,
    vocabulary: Annotated[
        Path | None,
        typer.Option(
            "--vocabulary",
            help="Use this ORBvoc.txt for ORB-SLAM3 as a peer (pip install pyorbslam3).",
        ),
    ] = None,
    intrinsics: IntrinsicsOption = None,
    quick: QuickOption = False,
    config: SettingsOption = None,
    out: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Estimate poses of a recording, of laps in several homes, or of hours in one."""
    settings = load_config(config)
    if sequence is not None:
        if seeds is not None or hours is not None:
            raise ConfigError("--seeds and --hours are for simulated homes; leave them out, or SEQ")
        bench = slam.SlamBench(
            sequence,
            None if intrinsics is None else parse_intrinsics(intrinsics),
            stride or 1,
            vocabulary,
            settings.perception.slam,
            folder_for(out, TRAJECTORIES / sequence.resolve().name),
            1 if quick else slam.RUNS,
        )
        _print(slam.run_slam(bench), as_json)
        return
    if (stride, vocabulary, intrinsics) != (None, None, None):
        raise ConfigError("--stride, --vocabulary and --intrinsics are for a recording; give SEQ")
    _require_own_folder(out, config)
    homes, folder = seeds_of(seeds), folder_for(out, RUNS / "slam")
    if hours is None:
        _print(slam_homes.run_slam_homes(homes, quick, settings, folder), as_json)
        return
    home, *others = homes or (FIRST_HOME,)
    if others or quick:
        raise ConfigError(
            f"--hours are driven in one home, and whole; give one of --seeds {seeds}, no --quick"
        )
    _print(slam_hours.run_slam_hours(home, hours, settings, folder), as_json)


@_bench(questions.NAME, "walk --questions questions.toml")
def run_questions(
    sequence: Annotated[Path, typer.Argument(metavar="SEQ", help="Use this TUM folder.")],
    asked: Annotated[
        Path,
        typer.Option(
            "--questions",
            metavar="FILE.toml",
            help="Read things, and where they are, from this TOML file.",
        ),
    ],
    clip: ClipOption = None,
    use: UseOption = None,
    config: SettingsOption = None,
    out: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Ask the map of a recording where things are."""
    _require_own_folder(out, config, use)
    folder = folder_for(out, RUNS / "questions")
    settings = with_calibration(load_config(config, clip), use)
    _print(questions.run_questions(sequence, asked, settings, folder), as_json)


@_bench(encoder.NAME, "--worlds sweethome3d.jar/Studio")
def run_encoder(
    clip: ClipOption = None,
    use: UseOption = None,
    seeds: SeedsOption = None,
    worlds: Annotated[
        str | None,
        typer.Option("--worlds", help="Take pictures of these homes, drawn by others, too."),
    ] = None,
    sequences: Annotated[
        list[Path] | None,
        typer.Option("--sequence", metavar="SEQ", help="Ask a recording, too; may be repeated."),
    ] = None,
    marks: Annotated[
        list[Path] | None,
        typer.Option(
            "--questions",
            metavar="FILE.toml",
            help="Read what is marked in the recording from this file; once for each --sequence.",
        ),
    ] = None,
    named: Annotated[
        str | None,
        typer.Option(
            "--families",
            metavar="NAMES",
            help="Fit the belief to all of these encoders but one, each in turn, and judge it by"
            " that one: embedded,photos; versions of one encoder are joined by +.",
        ),
    ] = None,
    quick: QuickOption = False,
    config: SettingsOption = None,
    out: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Ask patches of pictures what they show."""
    if named is not None:
        if any(each is not None for each in (clip, use, seeds, worlds, sequences, marks)):
            raise ConfigError(
                f"--families {named} names its encoders and has its homes; leave out --clip, --use,"
                " --seeds, --worlds, --sequence and --questions"
            )
        folder = folder_for(out, RUNS / "families")
        compared = families.families_bench(load_config(config, None), named, quick, folder)
        _print(families.run_families(compared), as_json)
        return
    homes = seeds_of(seeds) or encoder.HOMES
    asked = encoder.EncoderBench(
        with_calibration(load_config(config, clip), use),
        homes[:1] if quick else homes,
        () if worlds is None else _world_files(worlds),
        _marked_sequences(sequences or [], marks or []),
        encoder.QUICK_PICTURES if quick else encoder.PICTURES,
        folder_for(out, RUNS / "encoder"),
    )
    _print(encoder.run_encoder(asked), as_json)


def _world_files(text: str) -> tuple[str, ...]:
    """The files of --worlds; homes of ours are named by --seeds."""
    worlds = tuple(text.split(","))
    for world in worlds:
        require_world(world)
        if seed_of(world) is not None:
            raise ConfigError(f"home {world} of --worlds is ours; give it by --seeds")
    return worlds


def _marked_sequences(
    sequences: Sequence[Path], marks: Sequence[Path]
) -> tuple[tuple[Path, Path], ...]:
    """Each recording with the file of its marks."""
    if len(sequences) != len(marks):
        raise ConfigError(
            f"{len(sequences)} --sequence and {len(marks)} --questions: give one file of marks for"
            " each recording, in the same order"
        )
    return tuple(zip(sequences, marks, strict=True))


@_bench(planner.NAME, "--quick")
def run_planner(
    quick: QuickOption = False, out: OutOption = None, as_json: JsonOption = False
) -> None:
    """Time planners; a whole run also writes its page."""
    folder = None if quick and out is None else folder_for(out, RUNS / "planner")
    _print(planner.run_planner(quick, folder), as_json)
    if folder is not None and not quick:
        _write_page(planner_page, folder)


@_bench(loop.NAME, "--quick")
def run_loop(
    quick: QuickOption = False,
    against: Annotated[
        str | None,
        typer.Option("--against", help="Compare with this commit, which runs in turns."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Time the ticks of rehearsals."""
    plan = loop.LoopBench.quick if quick else loop.LoopBench
    _print(loop.run_loop(plan(against)), as_json)


@_bench(faults.NAME, "--quick")
def run_faults(
    seeds: SeedsOption = None,
    quick: QuickOption = False,
    out: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Run drives and missions with faults; all of them also write their page."""
    homes, folder = seeds_of(seeds) or faults.HOMES, folder_for(out, RUNS / "faults")
    faults.require_homes(homes)
    _print(faults.run_faults(faults.FaultBench(homes, quick, folder)), as_json)
    if homes == faults.HOMES and not quick:
        _write_page(faults_page, folder)


def _run_board(
    options: BoardOptions,
    run: Callable[[BenchPlan], BenchResult],
    rows: str | None,
    known: Sequence[str],
    worlds: tuple[Home, ...] | None = None,
    folder: Path | None = None,
    goals: int | None = None,
) -> None:
    """Run a benchmark of the board; the whole board also writes its page.

    Args:
        options: The options that all of them have.
        run: The benchmark.
        rows: Names of the rows that are asked for, between commas; None for all.
        known: Names of all rows.
        worlds: Homes that no seed names.
        folder: Folder of the results where neither --out nor a whole board says it.
        goals: Number of goals of each home; None for all.
    """
    chosen, config, homes = _known_rows(rows, known), _unattended(options), seeds_of(options.seeds)
    _require_own_folder(options.out, options.config, options.clip, options.use)
    if options.out is None and homes is not None and min(homes) < FIRST_HOME:
        raise ConfigError(
            f"home {min(homes)} of --seeds is a training home (benchmark homes begin at"
            f" {FIRST_HOME}) and no part of the board; give a folder by --out"
        )
    fingerprint = Fingerprint.taken(config.clip)
    if not fingerprint.clean:
        echo(f"the sources are not those of a commit: results say {fingerprint.commit!r}", err=True)
    default = folder or (QUICK_SHARE if options.quick else BOARD_ROWS)
    kept = folder_for(options.out, default)
    plan = BenchPlan(config, kept, fingerprint, worlds or homes, options.quick, chosen, goals)
    _print(run(plan), options.as_json)
    if plan.full:
        _write_page(search_page, kept)


def _run_fast(options: BoardOptions, rows: str | None, scale: EncoderScale | None) -> None:
    """Compare rules of the search in the fast world, in homes of development."""
    config, seeds = _unattended(options), seeds_of(options.seeds)
    for seed in seeds or ():
        if not fast_world.is_of_development(seed):
            raise ConfigError(
                f"home {seed} of --seeds is none of development, which --fast is for; give homes"
                " from 0 to 999 or from 1100 to 1199"
            )
    chosen = _known_rows(rows, [rule.name for rule in fast_world.rules(config)])
    made = Fingerprint.taken(config.clip)
    folder = folder_for(options.out, FAST_WORLD)
    plan = BenchPlan(config, folder, made, seeds, options.quick, chosen)
    _print(fast_world.run_fast(plan, scale), options.as_json)


def _asked_rows(
    rows: str | None, method: MethodOption, encoder_scale: EncoderScaleOption
) -> str | None:
    """Names of the rows that are asked for; each method and each scale of an encoder has one."""
    own = {"--method": method, "--encoder-scale": encoder_scale, "--rows": rows}
    named = [f"{option} {value}" for option, value in own.items() if value is not None]
    if len(named) > 1:
        raise ConfigError(f"{named[0]} is a row of its own; leave out {' and '.join(named[1:])}")
    if encoder_scale is not None:
        return ENCODER_ROWS[encoder_scale]
    return single_goal.DEFAULT if method == "belief" else rows or method


def _known_rows(text: str | None, known: Sequence[str]) -> tuple[str, ...] | None:
    """The rows that `text` names; None for all of them."""
    if text is None:
        return None
    rows = tuple(part.strip() for part in text.split(","))
    for row in rows:
        if row not in known:
            raise ConfigError(f"unknown row {row!r}; use {', '.join(known)}")
    return rows


def _worlds(text: str, options: BoardOptions) -> tuple[str, ...]:
    """The homes of --worlds: with bare walls, or in files. Their results are kept apart.

    Those of ours without a modifier are named by --seeds.
    """
    if options.seeds is not None:
        raise ConfigError(f"--worlds {text} and --seeds both name homes; give one of them")
    worlds = tuple(text.split(","))
    for world in worlds:
        require_world(world)
        if seed_of(world) is not None and not is_bare(world):
            raise ConfigError(f"home {world} of --worlds has a seed alone; give it by --seeds")
    ours = [world for world in worlds if is_bare(world)]
    if ours and len(ours) < len(worlds) and options.out is None:
        raise ConfigError(
            f"--worlds {text}: results in bare homes and in those of others are kept apart; give a"
            " folder by --out"
        )
    return worlds


def _unattended(options: BoardOptions) -> Config:
    """The settings of a robot that nobody stands beside, unless a file says otherwise."""
    config = UNATTENDED if options.config is None else load_config(options.config)
    if options.clip is not None:
        config = config.model_copy(update={"clip": options.clip})
    return with_calibration(config, options.use)


def _require_own_folder(out: Path | None, *changes: object) -> None:
    """Refuse to keep results of other settings beside those of the defaults."""
    if out is None and any(change is not None for change in changes):
        raise ConfigError(
            "results with --clip, --use or --config are kept apart; give a folder by --out"
        )


def _write_page(made: Callable[[Path, Path], str], folder: Path) -> None:
    """Write the page of kept rows, where they are enough for one."""
    page = pages.page_of(folder)
    if text := made(folder, page):
        write_whole(page, text.encode())
        echo(f"written: {page}", err=True)


def _print(result: BenchResult, as_json: bool) -> None:
    content = {"name": result.name, "rows": result.rows, "summary": result.summary}
    echo(json.dumps(content) if as_json else result.text)
