"""Opens a run, rehearsed or on the robot: its folder, devices, maps and observers."""

from __future__ import annotations

import logging
import shlex
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mapping.clip.fitted.encoder import calibrated
from vizbot import __version__
from vizbot.commands.progress import Progress, parts_with_bank, say_calibration
from vizbot.commands.run_log import GoalLog, RunLog
from vizbot.commands.run_plan import DeviceChoice, RunPlan
from vizbot.config import Config
from vizbot.core.interfaces import Devices
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
from vizbot.rig import open_encoder, opened_devices

if TYPE_CHECKING:
    from mapping.clip.encoder import ClipEncoder  # its module loads torch
    from mapping.clip.reading import Reading
    from vizbot.commands.serve import ServedRun  # its module loads the console's server
    from vizbot.perception.interfaces import PerceptionParts
    from vizbot.rehearsal.plan_process import PlanProcess
    from vizbot.rehearsal.rig import Rig


log = logging.getLogger(__name__)

_SUMMED_UP = ("success", "error", "steps", "skipped_frames", "path_length", "wall_seconds")
"""Metrics that the log has."""


@dataclass(frozen=True, slots=True, eq=False)
class OpenRun:
    """A run whose devices are open.

    Attributes:
        devices: Its devices, not those that people share.
        rehearsal: What is simulated of and around them; None where nothing is.
        pipeline: Does the work, on the devices that people share where the run is served.
        notice: What must be said wherever the encoder answers; None for nothing.
        served: What people talk to; None where the run is not served.
        began: When it was opened, by the process's monotonic clock [s].
    """

    config: Config
    devices: Devices
    close: Callable[[], None]
    rehearsal: Rig | None
    pipeline: Pipeline
    recorder: Recorder
    report: Report
    notice: str | None
    served: ServedRun | None
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
        """Write map, trajectory, metrics and report, each even if another one fails.

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
        world = None if self.rehearsal is None else self.rehearsal.world
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

    With `serve` people may ask and drive by hand; with `score` goals are judged, where a base
    drives in a simulated world. `world` is the plan of that, under way; None where it is not.

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
            held = opened.enter_context(ExitStack())
            encoder, parts, own, rehearsal = _open_devices(plan, choice, world, held)
        where = f", world {choice.world}" if choice.world else ""
        log.info("devices open: camera %s, base %s%s", choice.camera, choice.base, where)
        if rehearsal is not None and rehearsal.world is not None and rehearsal.world.notice:
            echo(rehearsal.world.notice, err=True)
        recorder = Recorder(plan.folder, config)
        run_log.open(recorder.folder, own.clock)
        report = Report(recorder.folder, encoder.notice)
        notice = encoder.notice
        progress = Progress(config.objectnav.max_steps)
        observers: list[Observer] = [recorder, report, opened.enter_context(progress), GoalLog()]
        if rehearsal is not None:
            encoder = rehearsal.disturbed(encoder)
            observers[1], *killer = rehearsal.on_faulty_disk(report)
            observers += killer
        served = _shared(own, recorder, report, plan.map_folder, encoder.reading) if serve else None
        shared_base = None if served is None else served.base
        if plan.rerun:
            observers.append(opened.enter_context(open_viewer(recorder.folder, shared_base)))
        devices = own if served is None else served.devices
        if devices.base is not None:
            observers.append(OutcomeFeedback(devices.base))
        if score and rehearsal is not None:
            observers += rehearsal.judges()
        if served is not None:
            observers.append(served.session)
        pipeline = Pipeline(devices, encoder, config, observers, parts, plan.saved_map)
        recorder.keep_map(pipeline.snapshot, own.clock)
        reported = recorder, report, notice
        yield OpenRun(config, own, held.close, rehearsal, pipeline, *reported, served, began)


def _open_devices(
    plan: RunPlan, choice: DeviceChoice, planned: PlanProcess | None, opened: ExitStack
) -> tuple[ClipEncoder, PerceptionParts | None, Devices, Rig | None]:
    """The encoder, what perception begins with, the devices, and what is simulated of them."""
    config, simulated = plan.config, choice.rehearsal
    file = Path(config.clip_calibration) if config.clip_calibration else None

    def open_it() -> ClipEncoder:
        return calibrated(open_encoder(config.clip, config.device, config.half), file)

    with collecting_afterwards():
        if simulated is None:
            encoder = open_it()
        else:
            from vizbot.rehearsal.rig import Rig, open_world_and_encoder

            world, encoder = open_world_and_encoder(config, simulated, planned, open_it, opened)
    log.info("encoder %s on %s", encoder.model_id, config.device)
    say_calibration(encoder, config.clip)
    require_usable(plan.saved_map, encoder, config)  # before there is a folder
    parts = parts_with_bank(encoder)
    if simulated is None:
        of_robot = opened_devices(config, choice.camera, choice.base, choice.recording)
        return encoder, parts, opened.enter_context(of_robot), None
    goal, faults = simulated.first_goal, simulated.faults
    named = (choice.camera, choice.base, world, choice.recording)
    rig = opened.enter_context(Rig(config, *named, goal, faults))
    return encoder, parts, rig.devices, rig


def _shared(
    devices: Devices,
    recorder: Recorder,
    report: Report,
    begun_in: Path | None,
    reading: Callable[[str], Reading],
) -> ServedRun:
    from vizbot.commands.serve import ServedRun

    return ServedRun.share(devices, recorder, report, begun_in, reading)
