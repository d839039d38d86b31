"""The wall clock: monotonic time, and threads for what runs beside the caller."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Generic, TypeVar

T = TypeVar("T")


class _Running(Generic[T]):
    def __init__(self, work: Callable[[], T]) -> None:
        self._future: Future[T] = Future()
        threading.Thread(target=self._run, args=(work,), daemon=True).start()

    def _run(self, work: Callable[[], T]) -> None:
        try:
            self._future.set_result(work())
        except BaseException as error:
            self._future.set_exception(error)

    def ready(self) -> bool:
        return self._future.done()

    def result(self) -> T:
        return self._future.result()


class WallClock:
    """A `Clock` on `time.monotonic`."""

    simulated = False

    def now(self) -> float:
        """Seconds since an arbitrary start."""
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Block the caller for `seconds`."""
        time.sleep(seconds)

    def repeat(self, step: Callable[[], None]) -> Callable[[], None]:
        """Call `step` in a thread until the returned function is called, which joins it."""
        stopped = threading.Event()

        def run() -> None:
            while not stopped.is_set():
                step()

        thread = threading.Thread(target=run, daemon=True)
        thread.start()

        def stop() -> None:
            stopped.set()
            if thread is not threading.current_thread():
                thread.join(timeout=2.0)

        return stop

    def start(self, work: Callable[[], T], latency: float) -> _Running[T]:
        """Run `work` in a thread; `latency` is not needed here."""
        return _Running(work)
