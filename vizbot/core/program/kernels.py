"""Kernels: functions that numba compiles, and keeps where an account can keep any.

What takes the first minutes is said once, by whatever command compiles first.
"""

from __future__ import annotations

import atexit
import logging
import os
import shutil
from collections.abc import Callable
from tempfile import mkdtemp
from typing import Any, TypeVar

import numba

from vizbot.core.errors import ConfigError
from vizbot.core.program.kernel_folder import VARIABLE, can_keep, is_empty
from vizbot.core.program.log_records import NOTICE

_Function = TypeVar("_Function", bound=Callable[..., Any])

log = logging.getLogger(__name__)

if not can_keep():
    log.warning(
        "neither the installation nor a home can be written: kernels are compiled anew for this"
        " run, one to two minutes; to keep them set %s to a folder of this account",
        VARIABLE,
    )
    try:
        _folder = mkdtemp(prefix="vizbot-kernels-")
    except OSError as error:
        raise ConfigError(
            "no folder can be written, not even a temporary one, and compiled kernels need one:"
            f" set TMPDIR or {VARIABLE} to a folder of this account"
        ) from error
    atexit.register(shutil.rmtree, _folder, ignore_errors=True)
    # The programs that this one starts share it.
    os.environ[VARIABLE] = numba.config.CACHE_DIR = _folder
elif is_empty():
    log.log(NOTICE, "compiling what computes maps and ways, once: one to two minutes")


def kernel(signature: str | None = None, **options: Any) -> Callable[[_Function], _Function]:
    """Compile a function that runs without the interpreter, so that other threads go on.

    Args:
        signature: Its types, for which it is compiled at once; None for those of each call.
        options: Of `numba.njit`.
    """
    compiler: Callable[[_Function], _Function] = numba.njit(
        signature, cache=True, nogil=True, **options
    )
    return compiler
