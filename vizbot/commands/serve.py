"""Serves a run, so that people may ask and drive by hand while it goes on."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

from vizbot.config import ObjectNavConfig
from vizbot.core.devices import Devices
from vizbot.core.program.interrupts import is_interrupt
from vizbot.objectnav.tasks import Task
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service
from vizbot.operator.printing import echo
from vizbot.operator.session.notifications import log_warnings
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.task_loop import run_tasks
from vizbot.operator.session.task_queue import TaskRequest
from vizbot.operator.session.twist_mux import TwistMux
from vizbot.pipeline import Pipeline
from vizbot.recorder import Recorder

log = logging.getLogger(__name__)


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
    def share(devices: Devices, recorder: Recorder) -> ServedRun:
        """Share devices; the recorder keeps what the base is sent."""
        session = OperatorSession()
        session.keep_verdict, session.folder = recorder.keep_verdict, recorder.folder
        session.keep_verdict_on_way = recorder.keep_verdict_on_way
        if devices.base is None:
            return ServedRun(session, devices, None)
        base = TwistMux(devices.base, session.lease, session.stopped)
        base.on_drive = recorder.keep_commands(devices.clock)
        session.base_state, session.battery_state = (lambda: base.state), lambda: base.battery_state
        session.resume_base, session.show = base.resume_soon, base.show_soon
        return ServedRun(session, replace(devices, base=base), base)

    def serve(
        self,
        pipeline: Pipeline,
        service: Service,
        requests: Sequence[TaskRequest],
        config: ObjectNavConfig,
    ) -> None:
        """Serve until somebody ends it, the session is closed or the camera ends.

        Args:
            pipeline: Does the work, on these devices, with the session among its observers.
            service: Address and speech recogniser.
            requests: Tasks that are queued from the start. Without any, a robot with a base that
                begins in a saved map finds its place in it first.
            config: Says when to give up.

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
