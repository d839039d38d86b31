"""Simulated time: the world, the devices and the program advance in lockstep.

Nothing depends on this machine's clock, so a seed gives the same run twice under any load. Work
that is started beside the caller runs in a thread, and who asks for its result waits for it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future, wait
from typing import Generic, Protocol, TypeVar

T = TypeVar("T")


class LockstepDevice(Protocol):
    """A simulated device that publishes and advances once in every period."""

    def publish(self) -> None:
        """Send what the device measures now, if it sends anything in this period."""
        ...

    def advance(self, seconds: float) -> None:
        """Execute the commands received since the last call, then let `seconds` pass."""
        ...


class SimulatedClock:
    """A `Clock` that runs only during `sleep`.

    One period: every device publishes, every repeated step runs, every device advances, and then
    the time does. Without any device it advances all the same, so that timeouts fire.
    """

    simulated = True

    def __init__(self, period: float = 0.015) -> None:
        """Start at 0; `period` [s] is that of the base's sensor frames."""
        self._period = period
        self._ticks = 0
        self._in_tick = False
        self._slowness: Callable[[], float] = lambda: 1.0
        self._devices: list[LockstepDevice] = []
        self._steps: list[Callable[[], None]] = []
        self._work = _Work()

    def now(self) -> float:
        """Seconds since the start; for work that was started beside the caller, when it was."""
        if self._work.started_at is not None:
            return self._work.started_at
        return self._ticks * self._period

    def sleep(self, seconds: float) -> None:
        """Let whole periods pass until `seconds` are over.

        Raises:
            RuntimeError: called from a device or from a repeated step, which time waits for.
        """
        # The margin keeps the rounding of a sum from costing a whole period.
        end = self.now() + seconds - 1e-9
        while self.now() < end:
            self._tick()

    def repeat(self, step: Callable[[], None]) -> Callable[[], None]:
        """Run `step` once in every period until the returned function is called."""
        return _add(self._steps, step)

    def attach(self, device: LockstepDevice) -> Callable[[], None]:
        """Let `device` take part in every period until the returned function is called."""
        return _add(self._devices, device)

    def slow_down(self, slowness: Callable[[], float]) -> None:
        """Multiply the latency of work that is started beside the caller by `slowness`, too."""
        before = self._slowness
        self._slowness = lambda: before() * slowness()

    def start(self, work: Callable[[], T], latency: float) -> _Started[T]:
        """Do `work` in a thread; its result is ready `latency` seconds from now."""
        outcome: Future[T] = Future()
        started_at = self.now()

        def run() -> None:
            self._work.started_at = started_at
            try:
                outcome.set_result(work())
            except BaseException as error:
                outcome.set_exception(error)

        threading.Thread(target=run, daemon=True).start()
        return _Started(outcome, self, started_at + latency * self._slowness())

    def _tick(self) -> None:
        if self._in_tick:
            raise RuntimeError("a step that runs once in every period cannot sleep")
        self._in_tick = True
        try:
            for device in tuple(self._devices):
                device.publish()
            for step in tuple(self._steps):
                step()
            for device in tuple(self._devices):
                device.advance(self._period)
            self._ticks += 1
        finally:
            self._in_tick = False


def _add(members: list[T], member: T) -> Callable[[], None]:
    """Append a member and return a function that removes it."""
    members.append(member)

    def remove() -> None:
        members[:] = [other for other in members if other is not member]

    return remove


class _Work(threading.local):
    """When the work of this thread was started [s]; None in a thread that does no such work."""

    started_at: float | None = None


class _Started(Generic[T]):
    """Work under way, whose result is ready once its latency is over."""

    def __init__(self, outcome: Future[T], clock: SimulatedClock, due: float) -> None:
        self._outcome = outcome
        self._clock = clock
        self._due = due

    def ready(self) -> bool:
        if self._clock.now() < self._due - 1e-9:
            return False
        wait([self._outcome])  # simulated time, not this machine's, decides
        return True

    def result(self) -> T:
        """Sleep until the latency is over, then wait for the result and return it."""
        self._clock.sleep(self._due - self._clock.now())
        return self._outcome.result()
