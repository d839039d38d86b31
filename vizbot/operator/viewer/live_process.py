"""The rerun viewer as a process of its own, which reads a recording while it grows.

Between it and the robot there is only the file: the viewer may hang, crash or be closed.
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path

_SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")
_VIEWER = (
    f"{shlex.quote(sys.executable)} -m rerun_cli --bind 127.0.0.1 --port auto --expect-data-soon -"
)


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
