"""The simulated Roomba in real time, for programs that know nothing of simulated time."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from drivers.roomba.stream import PERIOD
from sim_stubs.roomba.base import SimulatedRoomba


def run_on_wall_clock(roomba: SimulatedRoomba, stopped: threading.Event) -> None:
    """Run the base in real time, a frame every 15 ms, until `stopped` is set."""
    before = time.monotonic()
    while not stopped.wait(PERIOD):
        now = time.monotonic()
        roomba.advance(now - before)
        roomba.publish()
        before = now


@contextmanager
def on_wall_clock(roomba: SimulatedRoomba) -> Iterator[SimulatedRoomba]:
    """Run the base in a thread beside the caller, and close it at the end."""
    stopped = threading.Event()
    thread = threading.Thread(target=run_on_wall_clock, args=(roomba, stopped), daemon=True)
    with roomba:
        thread.start()
        try:
            yield roomba
        finally:
            stopped.set()
            thread.join()
