"""Where a run is kept when nobody says where."""

from __future__ import annotations

import time
from pathlib import Path


def default_folder() -> Path:
    """`runs/<local time>`, with a number behind it if that is taken."""
    name = time.strftime("%Y-%m-%d_%H%M%S")
    folder = Path("runs") / name
    number = 1
    while folder.exists():
        number += 1
        folder = Path("runs") / f"{name}_{number}"
    return folder
