"""What people want of the robot's maps: short jobs that its loop does between two steps."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from queue import Empty, Full, Queue
from typing import Any, TypeVar

from vizbot.core.errors import ConfigError, DeviceTimeoutError
from vizbot.pipeline import Pipeline

T = TypeVar("T")

MOST = 20
"""Most jobs that may wait for the robot's loop."""
WITHIN = 10.0
"""Longest wait for the robot's loop [s]."""


class LoopJobs:
    """Jobs that wait for the robot's loop; asked for and done in different threads."""

    def __init__(self) -> None:
        self._waiting: Queue[tuple[Callable[[Pipeline], None], Future[Any]]] = Queue(MOST)

    def __len__(self) -> int:
        """How many wait."""
        return self._waiting.qsize()

    def submit(self, job: Callable[[Pipeline], T]) -> Future[T]:
        """Have the loop do a short job with its maps; return the future of its result.

        Raises:
            ConfigError: too many jobs wait.
        """
        done: Future[T] = Future()

        def do(pipeline: Pipeline) -> None:
            if done.set_running_or_notify_cancel():
                try:
                    done.set_result(job(pipeline))
                except Exception as error:  # any error is for the caller, not for the run
                    done.set_exception(error)

        try:
            self._waiting.put_nowait((do, done))
        except Full as error:
            raise ConfigError(f"{MOST} questions are waiting already; ask later") from error
        return done

    def wait_for(self, job: Callable[[Pipeline], T]) -> T:
        """Have the loop do something short with its maps, and wait for what it returns.

        Raises:
            ConfigError: too many jobs wait.
            DeviceTimeoutError: the robot is too busy, or its run ends.
        """
        done = self.submit(job)
        try:
            try:
                return done.result(WITHIN)
            except TimeoutError:
                if done.cancel():
                    raise
            return done.result()  # it has just begun, and its result counts
        except (TimeoutError, CancelledError) as error:
            raise DeviceTimeoutError("the robot is busy or ends; ask again") from error

    def do_next(self, pipeline: Pipeline, within: float = 0.0) -> bool:
        """Called by the loop: do the job that waits longest; whether one came `within` [s]."""
        try:
            do, _ = self._waiting.get(timeout=within) if within else self._waiting.get_nowait()
        except Empty:
            return False
        do(pipeline)
        return True

    def cancel(self) -> None:
        """Cancel those that wait; the run ends."""
        while True:
            try:
                self._waiting.get_nowait()[1].cancel()
            except Empty:
                return
