"""Threads of the numerical libraries: environment variables that are read when those load."""

from __future__ import annotations

import os


def let_threads_sleep() -> None:
    """Let threads that wait for each other sleep, and keep small products of matrices on one.

    PyTorch's threads spin at every barrier otherwise. While another program keeps a core busy, an
    image tower then takes ten times as long and burns a core. Variables that the user has set stay.
    """
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def keep_a_core_free() -> None:
    """Leave a core to what drives while images are embedded beside it."""
    cores = len(os.sched_getaffinity(0))
    os.environ.setdefault("OMP_NUM_THREADS", str(max(1, cores - 1)))
