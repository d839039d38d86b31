"""Work that is done in order by a thread beside the run."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from queue import SimpleQueue
from threading import Thread
from weakref import finalize

_Work = Callable[[], None]
_Given = tuple[_Work, "Future[None]"]


class WorkQueue:
    """A queue of work with one thread; `put` waits while the queue is full.

    Its thread never keeps a program from ending: an interrupt that strikes while a
    `ThreadPoolExecutor` starts its thread leaves one that the program's end waits for in vain.
    """

    def __init__(self, capacity: int) -> None:
        """Begin empty; at most `capacity` pieces of work wait."""
        self._given: SimpleQueue[_Given | None] = SimpleQueue()
        self._capacity = capacity
        self._pending: deque[Future[None]] = deque()
        Thread(target=_work, args=(self._given,), daemon=True).start()
        finalize(self, self._given.put, None)

    def put(self, work: _Work) -> None:
        """Have work done after all that was put in before.

        Raises:
            Exception: of earlier work that has failed; `work` is dropped then.
        """
        while self._pending and (self._pending[0].done() or len(self._pending) >= self._capacity):
            self._pending.popleft().result()
        done: Future[None] = Future()
        self._given.put((work, done))
        self._pending.append(done)

    def finish(self) -> None:
        """Wait until everything is done.

        Raises:
            Exception: of work that has failed, the first one.
        """
        while self._pending:
            self._pending.popleft().result()


def _work(given: SimpleQueue[_Given | None]) -> None:
    while (each := given.get()) is not None:
        work, done = each
        try:
            work()
        except BaseException as error:
            done.set_exception(error)
        else:
            done.set_result(None)
        del each, work, done  # what they hold lives no longer than the work
