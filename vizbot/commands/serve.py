"""A run that people may talk to while it goes on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import typer

from vizbot.config import ObjectNavConfig
from vizbot.core.devices import Devices
from vizbot.core.interrupts import is_interrupt
from vizbot.operator.api.auth import token_path
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service
from vizbot.operator.session.notifications import alerting
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.task_loop import attend
from vizbot.operator.session.task_queue import TaskRequest
from vizbot.operator.session.twist_mux import TwistMux
from vizbot.pipeline import Pipeline
from vizbot.recorder import Recorder


@dataclass(frozen=True, slots=True)
class ServedRun:
    """Devices that the robot's program shares with people.

    Attributes:
        desk: Where people ask; it belongs among the observers of the run.
        devices: For the program.
        base: The one that is shared; None without one.
    """

    desk: OperatorSession
    devices: Devices
    base: TwistMux | None

    @staticmethod
    def by_people(devices: Devices, recorder: Recorder) -> ServedRun:
        """Share them; what the base is then sent is recorded."""
        desk = OperatorSession()
        if devices.base is None:
            return ServedRun(desk, devices, None)
        base = TwistMux(devices.base, desk.wheel, desk.stopped)
        base.on_drive = recorder.keep_commands(devices.clock)
        desk.base_state, desk.resume_base = (lambda: base.state), base.resume_soon
        desk.show = base.show_soon
        return ServedRun(desk, replace(devices, base=base), base)

    def serve(
        self,
        pipeline: Pipeline,
        service: Service,
        wishes: Sequence[TaskRequest],
        config: ObjectNavConfig,
    ) -> None:
        """Serve until somebody ends it, the desk is closed or the camera ends.

        Args:
            pipeline: On these devices, with the desk among its observers.
            service: Where, and what listens.
            wishes: Asked for from the start.
            config: When to give up.

        Raises:
            VizbotError: the port cannot be used, or a device is gone.
        """
        with alerting(self.desk), Server(self.desk, service) as server:
            typer.echo(
                f"serving at {server.url} (open it in a browser; for programs: /openapi.json)",
                err=True,
            )
            if server.token is not None:
                shown = server.token if server.token_is_new else f"as kept in {token_path()}"
                typer.echo(f"token: {shown}", err=True)
            if wishes:
                self.desk.ask(wishes)
            try:
                attend(pipeline, self.devices.clock, self.base, self.desk, config)
            except (KeyboardInterrupt, SystemError) as error:
                if not is_interrupt(error):
                    raise
                typer.echo("stopping", err=True)
