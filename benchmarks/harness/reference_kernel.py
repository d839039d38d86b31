"""A fixed piece of work, timed beside a benchmark, so that machines can be compared."""

from __future__ import annotations

import time

import numpy as np

_SIZE = 1024
_RUNS = 15

DESCRIPTION = f"product of two {_SIZE} x {_SIZE} matrices of 32-bit numbers"


def reference_ms() -> float:
    """Median time of the kernel on this machine now [ms]."""
    matrix = np.random.default_rng(0).standard_normal((_SIZE, _SIZE), np.float32)
    times = []
    for _ in range(_RUNS):
        began = time.perf_counter()
        matrix @ matrix
        times.append(time.perf_counter() - began)
    return 1000.0 * float(np.median(times))
