"""Where a run is kept when nobody says where."""

from __future__ import annotations

import time
from pathlib import Path


def default_folder() -> Path:
    """`runs/<local time>`, a new one each second."""
    return Path("runs") / time.strftime("%Y-%m-%d_%H%M%S")
