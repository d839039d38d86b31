"""Jobs side by side, each in a process of its own, with progress on standard error.

A result does not depend on the jobs before it, nor on how many there are.
"""

from __future__ import annotations

import atexit
import logging
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

import cv2
from rich.console import Console
from rich.live import Live
from rich.text import Text

from vizbot.core.errors import VizbotError
from vizbot.core.program.interpreter import end_when_left

J = TypeVar("J")
R = TypeVar("R")

_MEMORY = 2e9
"""What a process may need [bytes]."""
_PAUSE = 0.1
"""Between two looks at whether all processes have ended [s]."""
_ONE_THREAD = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "LP_NUM_THREADS",
)
"""Variables for the threads of PyTorch, NumPy, numba and Mesa, read when those libraries load."""


def processes() -> int:
    """Number of jobs that run at a time: one on each core, as far as there is memory for them."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return max(1, min(len(os.sched_getaffinity(0)), int(memory / _MEMORY)))


def in_parallel(
    work: Callable[[J], R], jobs: Sequence[J], title: str, describe: Callable[[J, R], str]
) -> Iterator[tuple[J, R]]:
    """Yield each job with its result as soon as it is finished.

    A job that fails does not stop the others. When the caller leaves early, unfinished jobs are
    lost.

    Args:
        work: A function of a module, so that other processes can import it.
        jobs: The jobs, which begin in this order.
        title: Title of the progress line.
        describe: Returns one line about a finished job.

    Raises:
        VizbotError: a process was killed.
        Exception: the first error of `work`, once all other jobs are finished.
    """
    if not jobs:
        return
    with _one_thread_each(), _Progress(title, len(jobs)) as progress:
        executor = ThreadPoolExecutor(processes())
        pending = {executor.submit(_in_new_process, work, job): job for job in jobs}
        try:
            failures: list[Exception] = []
            for done in as_completed(pending):
                job = pending.pop(done)
                try:
                    result = done.result()
                except BrokenProcessPool:
                    raise
                except Exception as error:
                    failures.append(error)
                    progress.advance(f"{type(error).__name__}: {error}")
                    continue
                progress.advance(describe(job, result))
                yield job, result
            if failures:
                raise failures[0]
        except BrokenProcessPool as error:
            raise VizbotError(
                f"a process of {title} was killed, perhaps for lack of memory; run it again, what"
                " is finished is kept"
            ) from error
        finally:
            executor.shutdown(wait=False, cancel_futures=True)
            while not all(done.done() for done in pending):  # one may just be starting
                for process in multiprocessing.active_children():
                    process.terminate()
                time.sleep(_PAUSE)


def _in_new_process(work: Callable[[J], R], job: J) -> R:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, context, _begin) as executor:
        return executor.submit(work, job).result()


def _begin() -> None:
    """Set up a process: it ends with its parent, which alone is interrupted by Ctrl+C."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if (parent := multiprocessing.parent_process()) is not None:
        end_when_left(parent.sentinel)
    cv2.setNumThreads(1)
    # What befalls simulated devices is in the results, and not between the lines of progress.
    logging.getLogger().addHandler(logging.NullHandler())
    atexit.register(_end)


def _end() -> None:
    """End the process before Python takes the interpreter apart under threads in native code."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Give the processes that start meanwhile one thread each."""
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


class _Progress:
    """A live line on a terminal; elsewhere one line for each finished job."""

    def __init__(self, title: str, total: int) -> None:
        self._title, self._total = title, total
        self._done = 0
        self._began = time.monotonic()
        self._console = Console(stderr=True, highlight=False)
        self._live = Live(Text(f"{title}: 0 of {total}"), console=self._console)

    def advance(self, line: str) -> None:
        self._done += 1
        left = (time.monotonic() - self._began) / self._done * (self._total - self._done)
        state = f"{self._title}: {self._done} of {self._total}, {_duration(left)} left"
        if self._console.is_terminal:
            self._console.print(Text(line))
            self._live.update(Text(state))
        else:
            self._console.print(Text(f"{state} | {line}"), soft_wrap=True)

    def __enter__(self) -> _Progress:
        if self._console.is_terminal:
            self._live.start()
        return self

    def __exit__(self, *exc: object) -> None:
        if self._console.is_terminal:
            self._live.stop()


def _duration(seconds: float) -> str:
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60:02d} min"
