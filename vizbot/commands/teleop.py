"""`vizbot teleop`: drive a base by the keys of this terminal."""

from __future__ import annotations

import logging
import sys
from contextlib import ExitStack

from vizbot.commands.config.discovery import load_settings
from vizbot.commands.options import TeleopOptions
from vizbot.core.clock import WallClock
from vizbot.core.errors import ConfigError
from vizbot.core.program.interrupts import ended_by_interrupt
from vizbot.operator.client.remote_drive import RemoteDrive
from vizbot.operator.client.robot_client import RobotClient
from vizbot.operator.client.stop import whoami
from vizbot.operator.printing import PrintableFormatter, echo
from vizbot.operator.teleop.teleop import Driven, Teleop
from vizbot.operator.teleop.terminal import Terminal, require_terminal
from vizbot.rig import open_base, require_devices

_STANDARD_INPUT = 0
_KEYS = """\
Hold an arrow key or W, A, S, D to drive; let go to stop. Space stops at once.
+ and - or 1 to 9 set the speed, r goes on after an edge or when it was lifted, q or Esc ends.
Where the terminal tells when a key is let go, two keys at once drive a curve."""


def run(options: TeleopOptions) -> None:
    """Drive until the person leaves, by a key or Ctrl-C.

    Raises:
        VizbotError: a setting cannot be used, there is no terminal, or what is driven is missing
            or gone.
    """
    base, url = options.base, options.url
    if base not in ("roomba", "sim"):
        raise ConfigError(f"--base {base} cannot be driven by hand; use roomba or sim")
    require_terminal(_STANDARD_INPUT)
    config, clock = load_settings(options.config), WallClock()
    if url is None:
        require_devices(config, "sim", base)
    # Outermost, since a running robot that is left by Ctrl-C rests, and by q goes on.
    with ended_by_interrupt(), ExitStack() as opened:
        wheels: Driven
        if url is None:
            if base == "sim":
                from vizbot.rehearsal.rig import with_simulated_base

                config = with_simulated_base(config, opened)
            wheels = open_base(config, clock, opened)
        else:
            client = opened.enter_context(RobotClient(url, options.token))
            wheels = opened.enter_context(RemoteDrive(client, whoami(), over=options.over))
        echo(_KEYS, err=True)
        if sys.stderr.isatty():  # what the drivers log must not be written into the live line
            for each in logging.getLogger().handlers:
                each.setFormatter(PrintableFormatter("\r\x1b[K%(levelname)s: %(message)s"))
        terminal = opened.enter_context(Terminal(_STANDARD_INPUT))
        Teleop(wheels, terminal, clock).run()
