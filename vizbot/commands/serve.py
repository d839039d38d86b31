"""Serves a run, so that people may ask and drive by hand while it goes on."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapping.clip.reading import Reading
from vizbot.config import ObjectNavConfig
from vizbot.core.interfaces import Devices
from vizbot.core.observer import Candidate, GoalReport
from vizbot.core.program.interrupts import is_interrupt
from vizbot.core.types import BaseState, Feedback
from vizbot.objectnav.tasks import Task
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service
from vizbot.operator.printing import echo
from vizbot.operator.report.report import Report
from vizbot.operator.session.drive_lease import DriveLease
from vizbot.operator.session.notifications import log_warnings
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.task_loop import run_tasks
from vizbot.operator.session.task_queue import TaskRequest
from vizbot.operator.session.twist_mux import TwistMux
from vizbot.pipeline import Pipeline
from vizbot.recorder import Recorder

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RobotOfRun:
    """The robot of a run as its session sees it: a `SharedRobot`.

    Attributes:
        base: The base that program and people share; None without one.
        recorder: Keeps verdicts in the folder of the run.
        report: Has the pictures; it observes a goal before the session.
        begun_in: Folder of the saved map in which the run begins; None where it begins in none.
        stopped: Set while the wheels must rest.
    """

    base: TwistMux | None
    recorder: Recorder
    report: Report
    begun_in: Path | None
    lease: DriveLease
    stopped: threading.Event

    @property
    def folder(self) -> Path:
        """Folder of the run."""
        return self.recorder.folder

    def base_state(self) -> BaseState | None:
        """The newest state of the base; None without one."""
        return None if self.base is None else self.base.state

    def battery_state(self) -> BaseState | None:
        """The newest state that may be shown for the battery; None without one."""
        return None if self.base is None else self.base.battery_state

    def resume_base(self) -> None:
        """Ask the base to obey again."""
        if self.base is not None:
            self.base.resume_soon()

    def show(self, feedback: Feedback) -> None:
        """Play feedback on the base's lights and speaker."""
        if self.base is not None:
            self.base.show_soon(feedback)

    def picture_of(self, report: GoalReport) -> bytes | None:
        """JPEG of the best place of a report; None where there is none."""
        return self.report.picture_of(report)

    def picture_of_place(self, place: Candidate) -> bytes | None:
        """JPEG of a place on the map; None where there is none."""
        return self.report.picture_of_place(place)

    def keep_verdict(self, report: GoalReport, confirmed: bool) -> None:
        """Keep beside the run what people say of an arrival."""
        self.recorder.keep_verdict(report, confirmed)

    def keep_verdict_on_way(self, xy: NDArray[np.float64], confirmed: bool) -> None:
        """Keep what people say of the place that the robot approaches."""
        self.recorder.keep_verdict_on_way(xy, confirmed)


@dataclass(frozen=True, slots=True)
class ServedRun:
    """The devices of a run that the robot's program shares with people.

    Attributes:
        session: Holds what people ask for; it belongs among the observers of the run.
        devices: The devices that the program uses.
        base: The base that program and people share; None without one.
    """

    session: OperatorSession
    devices: Devices
    base: TwistMux | None

    @staticmethod
    def share(
        devices: Devices,
        recorder: Recorder,
        report: Report,
        begun_in: Path | None,
        reading: Callable[[str], Reading],
    ) -> ServedRun:
        """Share devices; the recorder keeps what the base is sent.

        `reading` is the encoder's: a goal that it has no name for is refused.
        """
        lease, stopped = DriveLease(time.monotonic), threading.Event()
        base: TwistMux | None = None
        if devices.base is not None:
            base = TwistMux(devices.base, lease, stopped)
            base.on_drive = recorder.keep_commands(devices.clock)
            devices = replace(devices, base=base)
        robot = RobotOfRun(base, recorder, report, begun_in, lease, stopped)
        return ServedRun(OperatorSession(robot, reading=reading), devices, base)

    def serve(
        self,
        pipeline: Pipeline,
        service: Service,
        requests: Sequence[TaskRequest],
        config: ObjectNavConfig,
    ) -> None:
        """Serve until somebody ends it, the session is closed or the camera ends.

        Without `requests`, which are queued from the start, a robot with a base that begins in a
        saved map finds its place in it first.

        Raises:
            VizbotError: the port cannot be used, or a device is gone.
        """
        with log_warnings(self.session), Server(self.session, service) as server:
            echo(
                f"serving at {server.console_url}"
                " (open it in a browser; for programs: /openapi.json)",
                err=True,
            )
            log.info("serving at %s", server.url)  # without the token: people send logs around
            if not requests and self.base is not None and pipeline.map.saved is not None:
                requests = [Task.FIND_PLACE]
                echo(
                    "the robot turns on the spot until it knows where it is in the saved map;"
                    " STOP ends that",
                    err=True,
                )
            if requests:
                self.session.ask(requests)
            try:
                run_tasks(pipeline, self.devices.clock, self.base, self.session, config)
                log.info("%s", "ended" if self.session.closed.is_set() else "the camera has ended")
            except BaseException as error:
                if not is_interrupt(error):
                    raise
                echo("stopping", err=True)
                log.info("interrupted")
