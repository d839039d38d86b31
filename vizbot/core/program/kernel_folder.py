"""Where numba keeps compiled kernels.

That is beside the sources or in the user's cache. Numba raises where it can write neither, as for a
service without a home in an installation that it may only read.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from vizbot.core.files import require_folder, user_folder

VARIABLE = "NUMBA_CACHE_DIR"
"""Names another folder."""
_KERNEL = "*.nbi"


def can_keep() -> bool:
    """Whether this account can keep kernels where numba looks for them."""
    if os.environ.get(VARIABLE):
        return True
    for folder in _folders():
        with suppress(OSError):
            require_folder(folder)
            return True
    return False


def is_empty() -> bool:
    """Whether no kernel is kept yet, as after an installation: compiling all takes minutes."""
    named = os.environ.get(VARIABLE)
    return not any(
        any(folder.rglob(_KERNEL)) for folder in ([Path(named)] if named else _folders())
    )


def _folders() -> list[Path]:
    beside = Path(__file__).parents[3] / "nav" / "__pycache__"
    return [beside, user_folder("XDG_CACHE_HOME", ".cache").with_name("numba")]
