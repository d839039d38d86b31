"""`--rerun`: the recording of a run, and a viewer for it where this machine has a screen."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from vizbot.core.errors import ConfigError
from vizbot.operator.printing import echo
from vizbot.operator.session.twist_mux import TwistMux
from vizbot.operator.viewer.live_process import has_screen, show_recording

if TYPE_CHECKING:  # its module loads rerun
    from vizbot.operator.viewer.viewer import Viewer


def require_rerun() -> None:
    """Check for rerun before the devices are opened.

    Raises:
        ConfigError: rerun is not installed.
    """
    if find_spec("rerun") is None:
        raise ConfigError("--rerun needs rerun-sdk, not installed: pip install rerun-sdk")


def open_viewer(folder: Path, base: TwistMux | None) -> Viewer:
    """Begin `run.rrd` in a run's folder, show it if there is a screen, print how to follow it.

    Args:
        folder: The run's folder.
        base: Its battery is plotted; None without a base.
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
