"""`--rerun`: the recording of a run, and a viewer for it where this machine has a screen.

The viewer is a process of its own, which reads the recording while it grows. Between it and the
robot there is only the file: the viewer may hang, crash or be closed.
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from vizbot.core.errors import ConfigError
from vizbot.operator.printing import echo
from vizbot.operator.session.twist_mux import TwistMux

if TYPE_CHECKING:  # its module loads rerun
    from vizbot.operator.viewer.viewer import Viewer


_SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")
_VIEWER = (
    f"{shlex.quote(sys.executable)} -m rerun_cli --bind 127.0.0.1 --port auto --expect-data-soon -"
)


def require_rerun() -> None:
    """Check for rerun before the devices are opened.

    Raises:
        ConfigError: rerun is not installed.
    """
    if find_spec("rerun") is None:
        raise ConfigError("--rerun needs rerun-sdk, not installed: pip install rerun-sdk")


def open_viewer(folder: Path, base: TwistMux | None) -> Viewer:
    """Begin `run.rrd` in a run's folder, show it if there is a screen, print how to follow it.

    The battery of `base` is plotted; None without a base.
    """
    from vizbot.operator.viewer.viewer import Viewer

    path = folder / "run.rrd"

    def battery() -> float | None:
        state = None if base is None else base.state
        return None if state is None else state.battery

    viewer = Viewer(path, battery)
    if has_screen():
        show_recording(path)
    echo(f"recording {path}; to follow it: tail -c +1 -f {path} | rerun -", err=True)
    return viewer


def has_screen() -> bool:
    """Whether windows can be opened here."""
    return any(os.environ.get(name) for name in _SCREENS)


def show_recording(path: Path, viewer: str = _VIEWER) -> None:
    """Start a viewer that shows a recording and what is added to it until this program ends.

    Args:
        path: The recording, already begun.
        viewer: Command line of a program that shows what comes on its standard input.
    """
    tail = f'tail --pid={os.getpid()} --bytes=+1 --follow "$0"'
    # The shell ends at once and leaves both to themselves: Ctrl-C is for the robot alone.
    subprocess.run(
        ["sh", "-c", f"{tail} | {viewer} >/dev/null 2>&1 &", str(path)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        check=False,
    )
