"""`vizbot dry-run`: the whole loop once, scored where the world is simulated."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from drivers.tum_sequence import parse_intrinsics
from mapping import map_bundle
from sim_stubs.clock import SimulatedClock
from sim_stubs.faults.catalogue import parse_faults
from sim_stubs.faults.faulty_encoder import FaultyEncoder
from sim_stubs.faults.faulty_program import FaultyObserver, Killer
from sim_stubs.scoring.success import Verdict, judge
from sim_stubs.world.world import World
from vizbot.commands.progress import Progress
from vizbot.commands.serve import ServedRun
from vizbot.config import Config, load_config
from vizbot.core.errors import ConfigError, VizbotError
from vizbot.core.interrupts import is_interrupt
from vizbot.core.observer import GoalReport, Observer, Outcome, Step
from vizbot.mission import advise, drive_to_all, watch
from vizbot.mission import explore as explore_all
from vizbot.objectnav.tasks import Task
from vizbot.operator.client.endpoint import Service
from vizbot.operator.report.report import Report
from vizbot.operator.session.notifications import OutcomeFeedback
from vizbot.operator.viewer.open_viewer import open_viewer, require_rerun
from vizbot.pipeline import Pipeline
from vizbot.recorder import Recorder, default_folder, require_empty
from vizbot.rig import Rig, open_encoder

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder


@dataclass
class GoalScorer:
    """An observer that scores each goal where the robot stopped, from the world's truth.

    Attributes:
        world: What the robot never sees of itself.
        verdicts: One for each goal so far.
    """

    world: World
    verdicts: list[Verdict] = field(default_factory=list)

    def on_step(self, step: Step) -> None:
        """Nothing is scored under way."""

    def on_goal(self, report: GoalReport) -> None:
        """Score the place where the robot stands now."""
        stopped = report.outcome is Outcome.ARRIVED
        self.verdicts.append(judge(self.world, report.text, stopped=stopped))


def run(
    *,
    goals: Sequence[str],
    explore: bool,
    camera: str,
    base: str | None,
    world: str,
    map_folder: Path | None,
    clip: str | None,
    config_path: Path | None,
    intrinsics: str | None,
    faults: str | None,
    out: Path | None,
    serve_at: Service | None,
    rerun: bool,
    as_json: bool,
) -> bool:
    """Run once, write the run's folder, print the result.

    Returns:
        Whether it succeeded: with no base, a recorded camera or `explore` by having come to its
        end, in a simulated world by the scorer's verdict, else by what the robot believes.

    Raises:
        VizbotError: an argument cannot be used, or a device is missing or gone.
    """
    for goal in goals:
        if not goal.strip():
            raise ConfigError("the goal '' is empty; say what to go to, for example 'yellow chair'")
        if not goal.isprintable():
            raise ConfigError(f"the goal {goal!r} holds what is no text; say it in plain words")
    if not goals and not explore and serve_at is None:
        raise ConfigError("no TEXT and no --explore: nothing to do. See: vizbot dry-run --help")
    if goals and explore and serve_at is not None:
        raise ConfigError("--explore with --serve takes no TEXT; ask for it when it has explored")
    folder = out or default_folder()
    require_empty(folder)
    if rerun:
        require_rerun()
    config = load_config(config_path)
    if clip is not None:
        config = config.model_copy(update={"clip": clip})
    if base is None:
        base = "sim" if camera in ("sim", "realsense") else "none"
    if explore and base == "none":
        raise ConfigError("--explore drives; give --base sim or roomba")
    if intrinsics is not None and (camera in ("sim", "realsense") or Path(camera).is_file()):
        raise ConfigError(f"--intrinsics are not for the camera {camera!r}, which has its own")
    kept = None if map_folder is None else map_bundle.load(map_folder)
    recording = None if intrinsics is None else parse_intrinsics(intrinsics)
    planned = [] if faults is None else parse_faults(faults)
    began = time.monotonic()
    with ExitStack() as opened:
        encoder: ClipEncoder = open_encoder(config.clip, config.device, config.half)
        first_goal = goals[0] if goals and not explore else ""
        rig = opened.enter_context(Rig(config, camera, base, world, recording, first_goal, planned))
        if rig.world is not None and rig.world.notice:
            typer.echo(rig.world.notice, err=True)
        recorder = Recorder(folder, config)
        report = Report(recorder.folder, encoder.notice)
        observers: list[Observer] = [recorder, report, opened.enter_context(Progress())]
        if rig.schedule is not None:
            encoder = FaultyEncoder(encoder, rig.schedule)
            observers[1] = FaultyObserver(report, rig.schedule)
            observers.append(Killer(rig.schedule))
        attended = None if serve_at is None else ServedRun.by_people(rig.devices, recorder)
        shared = None if attended is None else attended.base
        if rerun:
            observers.append(opened.enter_context(open_viewer(recorder.folder, shared)))
        devices = rig.devices if attended is None else attended.devices
        if devices.base is not None:
            observers.append(OutcomeFeedback(devices.base))
        scorer = None
        if rig.world is not None and rig.devices.base is not None and not explore:
            scorer = GoalScorer(rig.world)
            observers.append(scorer)
        if attended is not None:
            observers.append(attended.desk)
        pipeline = Pipeline(devices, encoder, config, observers, saved_map=kept)
        recorder.keep_map(pipeline.bundle, rig.devices.clock)

        def work() -> bool:
            if attended is not None and serve_at is not None:
                return _serve(pipeline, attended, serve_at, goals, explore, config)
            return (_explore_and_ask if explore else _drive_or_watch)(pipeline, rig, goals, config)

        claimed, failure = _to_the_end(pipeline, work)
        metrics = _metrics(recorder, rig, scorer, claimed, failure) | {
            "wall_seconds": round(time.monotonic() - began, 1),
            "run": str(recorder.folder),
            "camera": camera,
            "base": base,
            "world": world if rig.world is not None else None,
        }
        recorder.finish(pipeline.bundle(), metrics)
        if rig.world is None:
            report.finish(metrics)
        else:
            report.finish(metrics, rig.world.top_view(), rig.world.attributions)
    if encoder.notice:
        typer.echo(encoder.notice, err=True)
    for verdict in scorer.verdicts if scorer is not None else ():
        if not verdict.success:
            typer.echo(f"the scorer says: {verdict.reason}", err=True)
    success = bool(metrics["success"])
    if as_json:
        typer.echo(json.dumps(metrics))
    if failure is not None:
        typer.echo(f"what was mapped until then is in {recorder.folder}", err=True)
        raise failure
    if not as_json:
        done = "processed" if rig.devices.base is None else "arrived"
        if explore or attended is not None:
            done = "explored" if attended is None else "ended"
        typer.echo(f"{done if success else 'not done'}: {recorder.folder / 'report.html'}")
    return success


def _drive_or_watch(pipeline: Pipeline, rig: Rig, goals: Sequence[str], config: Config) -> bool:
    """Whether the robot believes that it has arrived everywhere, or a recording had frames."""
    wanted = [pipeline.goal(goal) for goal in goals]
    max_steps = config.objectnav.max_steps
    if rig.devices.base is None:
        if rig.devices.recorded:
            watch(pipeline, wanted)
        else:
            advise(pipeline, wanted, max_steps)
        return pipeline.steps > 0
    reports = drive_to_all(pipeline, rig.devices, wanted, max_steps)
    return all(report.outcome is Outcome.ARRIVED for report in reports)


def _explore_and_ask(pipeline: Pipeline, rig: Rig, goals: Sequence[str], config: Config) -> bool:
    """Whether nothing was left to see; then the map is asked for the goals all the same."""
    outcome, reason = explore_all(pipeline, rig.devices, config.objectnav.max_exploration_steps)
    if outcome is not Outcome.EXPLORED:
        typer.echo(f"the exploration has not come to its end: {reason}", err=True)
    pipeline.finish()
    for goal in goals:
        pipeline.look_up(pipeline.goal(goal))
    return outcome is Outcome.EXPLORED


def _serve(
    pipeline: Pipeline,
    attended: ServedRun,
    service: Service,
    texts: Sequence[str],
    explore: bool,
    config: Config,
) -> bool:
    """Whether the robot believes that all it was asked for is done, or a recording had frames."""
    drives = attended.base is not None
    wishes = [Task.EXPLORE] if explore else texts
    attended.serve(pipeline, service, wishes if drives else [], config.objectnav)
    if not drives:
        pipeline.finish()
        for text in texts:
            pipeline.look_up(pipeline.goal(text))
        return pipeline.steps > 0
    good = (Outcome.ARRIVED, Outcome.EXPLORED)
    return all(errand.outcome in good for errand in attended.desk.agenda.errands())


def _to_the_end(
    pipeline: Pipeline, work: Callable[[], bool]
) -> tuple[bool, VizbotError | KeyboardInterrupt | None]:
    """Whether it has worked, and what ended it early, so that what was mapped then is kept."""
    try:
        return work(), None
    except (VizbotError, KeyboardInterrupt, SystemError) as error:
        if isinstance(error, VizbotError):
            return False, error
        if is_interrupt(error):
            return False, KeyboardInterrupt()
        raise
    finally:
        pipeline.finish()


def _metrics(
    recorder: Recorder,
    rig: Rig,
    scorer: GoalScorer | None,
    claimed: bool,
    failure: BaseException | None,
) -> dict[str, object]:
    success = claimed
    if scorer is not None:
        success = failure is None and all(verdict.success for verdict in scorer.verdicts)
    lockstep = rig.world if isinstance(rig.devices.clock, SimulatedClock) else None
    return {
        "success": success,
        "judged": scorer is not None,
        "claimed": claimed,
        "goals": [_goal(report) for report in recorder.reports],
        "error": str(failure) or "interrupted" if failure is not None else None,
        "steps": recorder.steps,
        "path_length": round(recorder.path_length, 3),
        "collisions": None if lockstep is None else lockstep.collisions,
        "simulated_seconds": None if lockstep is None else round(rig.devices.clock.now(), 3),
    }


def _goal(report: GoalReport) -> dict[str, object]:
    best = report.candidates[0] if report.candidates else None
    return {
        "text": report.text,
        "outcome": report.outcome,
        "reason": report.reason,
        "position": None if best is None else [round(float(v), 3) for v in best.position],
        "score": None if best is None else round(best.similarity, 4),
    }
