"""Work that is done in order by a thread beside the run."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor


class WorkQueue:
    """A queue of work with one thread; whoever puts in more than fits waits for the oldest."""

    def __init__(self, capacity: int) -> None:
        """Begin empty; at most `capacity` pieces of work wait."""
        self._executor = ThreadPoolExecutor(1)
        self._capacity = capacity
        self._pending: deque[Future[None]] = deque()

    def put(self, work: Callable[[], None]) -> None:
        """Have work done after all that was put in before.

        Raises:
            Exception: of earlier work that has failed; `work` is dropped then.
        """
        while self._pending and (self._pending[0].done() or len(self._pending) >= self._capacity):
            self._pending.popleft().result()
        self._pending.append(self._executor.submit(work))

    def finish(self) -> None:
        """Wait until everything is done.

        Raises:
            Exception: of work that has failed, the first one.
        """
        while self._pending:
            self._pending.popleft().result()
