"""What a program no longer needs: when Python looks for it, and where its memory goes."""

from __future__ import annotations

import ctypes
import gc
from collections.abc import Iterator
from contextlib import contextmanager

_TRIM_THRESHOLD, _MMAP_THRESHOLD, _ARENA_MAX = -1, -3, -8
"""Parameters of mallopt(3), as in glibc's malloc.h."""
_KEPT = 256 << 20
"""[bytes]"""
_LARGEST_KEPT = 64 << 20
"""Larger blocks go back to the system at once [bytes]."""


@contextmanager
def collecting_afterwards() -> Iterator[None]:
    """Collect no garbage until the end of a block that loads and opens what stays.

    Loading makes hundreds of thousands of objects. The collector goes through them again and again
    and finds none to free, which is a third of the time that PyTorch takes to load. Nor does it go
    through them later, which would hold up a tick for a quarter of a second.
    """
    collected = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collected:
            gc.freeze()
            gc.enable()


def keep_freed_memory() -> None:
    """Keep freed memory for what is allocated next; call before threads start.

    Pictures and the layers of an image tower are blocks of megabytes, made anew in every tick.
    Those that went back to the system come again page by page, each one cleared, which takes up to
    a quarter of the time of the image tower.
    """
    mallopt = ctypes.CDLL(None).mallopt
    mallopt(_TRIM_THRESHOLD, _KEPT)
    mallopt(_MMAP_THRESHOLD, _LARGEST_KEPT)
    mallopt(_ARENA_MAX, 1)  # any other one gives up whole heaps, whatever is to be kept
