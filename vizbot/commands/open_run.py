"""Opens a run, rehearsed or on the robot: its folder, devices, maps and observers."""

from __future__ import annotations

import logging
import shlex
import sys
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from sim_stubs.faults.faulty_encoder import FaultyEncoder
from sim_stubs.faults.faulty_program import FaultyObserver, Killer
from sim_stubs.world.plan_process import PlanProcess
from vizbot import __version__
from vizbot.commands.progress import Progress, parts_with_bank
from vizbot.commands.run_log import GoalLog, RunLog
from vizbot.commands.run_plan import DeviceChoice, RunPlan
from vizbot.config import Config
from vizbot.core.observer import Observer
from vizbot.core.program.garbage import collecting_afterwards
from vizbot.core.program.interrupts import (
    first_error,
    holding_interrupts,
    letting_interrupts_through,
)
from vizbot.operator.printing import echo
from vizbot.operator.report.report import Report
from vizbot.operator.session.notifications import OutcomeFeedback
from vizbot.operator.viewer.open_viewer import open_viewer
from vizbot.pipeline import Pipeline, require_usable
from vizbot.recorder import Recorder
from vizbot.rig import Rig, open_encoder

if TYPE_CHECKING:
    from mapping.clip.encoder import ClipEncoder  # its module loads torch
    from sim_stubs.scoring.success import GoalScorer  # its module loads the simulated homes
    from sim_stubs.world.world import World
    from vizbot.commands.serve import ServedRun  # its module loads the console's server


log = logging.getLogger(__name__)

_SUMMED_UP = ("success", "error", "steps", "skipped_frames", "path_length", "wall_seconds")
"""Metrics that the log has."""


@dataclass(frozen=True, slots=True, eq=False)
class OpenRun:
    """A run whose devices are open.

    Attributes:
        config: Its settings.
        rig: Its devices.
        pipeline: Does the work, on the devices that people share where the run is served.
        recorder: Writes its folder.
        report: Draws its page.
        notice: What must be said wherever the encoder answers; None for nothing.
        served: What people talk to; None where the run is not served.
        scorer: Judges the goals by the simulated world; None where none is to be judged.
        began: When it was opened, by the process's monotonic clock [s].
    """

    config: Config
    rig: Rig
    pipeline: Pipeline
    recorder: Recorder
    report: Report
    notice: str | None
    served: ServedRun | None
    scorer: GoalScorer | None
    began: float

    @property
    def folder(self) -> Path:
        """Where the run is recorded."""
        return self.recorder.folder

    def totals(self) -> dict[str, object]:
        """The metrics that every run has; frames are those of the present map."""
        seen = self.pipeline.map.perception if self.pipeline.map.has_frames else None
        return {
            "goals": self.recorder.goals,
            "steps": self.recorder.steps,
            "embedded_frames": 0 if seen is None else seen.embedded,
            "skipped_frames": 0 if seen is None else seen.skipped,
            "path_length": round(self.recorder.path_length, 3),
            "wall_seconds": round(time.monotonic() - self.began, 1),
            "run": str(self.folder),
        }

    def write(
        self, metrics: Mapping[str, object]
    ) -> tuple[dict[str, object], BaseException | None]:
        """Write map, trajectory, metrics and report, each whatever becomes of the others.

        Returns:
            The metrics with `map` and `map_error` as `Recorder.finish` has them, and the first
            error.
        """
        kept, lost = self.recorder.finish(self.pipeline.bundle, metrics)
        if kept["map"] is None:
            log.warning("no map of the end is saved: %s", kept["map_error"])
        else:
            log.info("map saved: %s", kept["map"])
        summary = ", ".join(f"{name} {metrics[name]}" for name in _SUMMED_UP if name in metrics)
        log.info("ended: %s", summary)
        unreported = first_error(lambda: self._write_report(kept))
        return kept, lost or unreported

    def _write_report(self, metrics: Mapping[str, object]) -> None:
        world = self.rig.world
        drawn = () if world is None else (world.top_view(), world.attributions)
        self.report.finish(metrics, *drawn)


@contextmanager
def open_run(
    plan: RunPlan,
    choice: DeviceChoice,
    *,
    serve: bool,
    score: bool,
    world: PlanProcess | None = None,
) -> Iterator[OpenRun]:
    """Open everything that a run needs, and close it in the end, whatever happens.

    Once its devices are open an interrupt ends it between two frames alone, and after it the
    folder is written and the devices are closed.

    Args:
        plan: As checked.
        choice: The devices.
        serve: Whether people may ask and drive by hand.
        score: Whether goals are judged, where a base drives in a simulated world.
        world: The plan of the simulated world, under way; None where it is not.

    Raises:
        VizbotError: a device is missing, the encoder has no weights here, the folder cannot be
            written, or the saved map is of another encoder.
    """
    began = time.monotonic()
    config = plan.config
    with holding_interrupts(), ExitStack() as opened:
        run_log = opened.enter_context(RunLog())
        log.info("vizbot %s: %s", __version__, shlex.join(sys.argv[1:]))
        with letting_interrupts_through():
            with collecting_afterwards():
                simulated, encoder = _world_and_encoder(config, choice, world, opened)
            log.info("encoder %s on %s", encoder.model_id, config.device)
            require_usable(plan.saved_map, encoder, config)  # before there is a folder
            parts = parts_with_bank(encoder)
            rig = opened.enter_context(
                Rig(
                    config,
                    choice.camera,
                    choice.base,
                    choice.world if simulated is None else simulated,
                    choice.recording,
                    choice.first_goal,
                    choice.faults,
                )
            )
        where = f", world {choice.world}" if rig.world is not None else ""
        log.info("devices open: camera %s, base %s%s", choice.camera, choice.base, where)
        if rig.world is not None and rig.world.notice:
            echo(rig.world.notice, err=True)
        recorder = Recorder(plan.folder, config)
        run_log.open(recorder.folder, rig.devices.clock)
        report = Report(recorder.folder, encoder.notice)
        notice = encoder.notice
        progress = Progress(config.objectnav.max_steps)
        observers: list[Observer] = [recorder, report, opened.enter_context(progress), GoalLog()]
        if rig.schedule is not None:
            encoder = FaultyEncoder(encoder, rig.schedule)
            observers[1] = FaultyObserver(report, rig.schedule)
            observers.append(Killer(rig.schedule))
        served = _shared(rig, recorder, report, plan.map_folder) if serve else None
        shared_base = None if served is None else served.base
        if plan.rerun:
            observers.append(opened.enter_context(open_viewer(recorder.folder, shared_base)))
        devices = rig.devices if served is None else served.devices
        if devices.base is not None:
            observers.append(OutcomeFeedback(devices.base))
        scorer = _scorer(rig) if score else None
        if scorer is not None:
            observers.append(scorer)
        if served is not None:
            observers.append(served.session)
        pipeline = Pipeline(devices, encoder, config, observers, parts, plan.saved_map)
        recorder.keep_map(pipeline.snapshot, rig.devices.clock)
        yield OpenRun(config, rig, pipeline, recorder, report, notice, served, scorer, began)


def _world_and_encoder(
    config: Config, choice: DeviceChoice, planned: PlanProcess | None, opened: ExitStack
) -> tuple[World | None, ClipEncoder]:
    """The simulated world, which refuses more than an encoder does, and sooner; then the encoder.

    The encoder of a planned world opens beside it: waits for the plan and for MuJoCo leave it the
    interpreter.
    """
    mount = config.mount.T_base_cam
    if planned is None:
        world = None
        if choice.camera == "sim":
            from sim_stubs.world.world_name import open_world

            goal, labels, start = choice.first_goal, choice.labels, choice.start
            world = open_world(choice.world, config.world, mount, goal, labels, start)
            opened.enter_context(world)
        return world, open_encoder(config.clip, config.device, config.half)
    with ThreadPoolExecutor(1) as beside:
        encoder = beside.submit(open_encoder, config.clip, config.device, config.half)
        import sim_stubs.world.renderer  # noqa: F401
        from sim_stubs.world.world import World

        plan = planned.plan()
        shape = partial(planned.shape, plan)
        world = opened.enter_context(World.of_plan(plan, config.world, mount, shape))
        return world, encoder.result()


def _shared(rig: Rig, recorder: Recorder, report: Report, begun_in: Path | None) -> ServedRun:
    from vizbot.commands.serve import ServedRun

    return ServedRun.share(rig.devices, recorder, report, begun_in)


def _scorer(rig: Rig) -> GoalScorer | None:
    if rig.world is None or rig.devices.base is None:
        return None
    from sim_stubs.scoring.success import GoalScorer

    return GoalScorer(rig.world)
