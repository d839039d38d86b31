"""When Python looks for garbage: not while a program loads what it needs."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


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
