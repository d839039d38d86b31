"""Numba's `njit`, with a folder for compiled kernels also where an account can write none.

Numba keeps kernels beside the sources or in the user's cache, and raises where it can write
neither, as for a service without a home in an installation that it may only read.
"""

from __future__ import annotations

import atexit
import logging
import os
import shutil
from contextlib import suppress
from pathlib import Path
from tempfile import mkdtemp

import numba
from numba import njit

import vizbot
from vizbot.core.files import require_folder

__all__ = ["njit"]

log = logging.getLogger(__name__)


def _homes_of_kernels() -> list[Path]:
    """Where numba keeps kernels unless it is told."""
    sources = Path(vizbot.__file__).parents[1]
    caches = os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()
    return [sources / "nav" / "__pycache__", Path(caches) / "numba"]


def _find_folder() -> None:
    if numba.config.CACHE_DIR:
        return
    for folder in _homes_of_kernels():
        with suppress(OSError):
            require_folder(folder)
            return
    made = mkdtemp(prefix="vizbot-kernels-")
    log.warning(
        "neither the installation nor a home can be written: kernels are compiled anew for this"
        " run, half a minute; to keep them set NUMBA_CACHE_DIR to a folder of this account"
    )
    atexit.register(shutil.rmtree, made, ignore_errors=True)
    # The programs that this one starts share it.
    os.environ["NUMBA_CACHE_DIR"] = numba.config.CACHE_DIR = made


_find_folder()
