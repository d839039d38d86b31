"""The watchdog of the process that owns the base's port.

A process that hangs does not end by itself, holds the port, and leaves the wheels turning. The
watchdog is its parent and does nothing else, so that no work of the program delays it. Within half
a second of the last sign of life it kills the process, has the wheels stopped, and starts another.
The watchdog gives signs of life, too: the program that drives does the same where it hangs.
"""

from __future__ import annotations

import os
import pickle
import signal
import struct
import sys
import time
import traceback
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from ctypes import Array, c_ubyte
from multiprocessing.context import BaseContext
from typing import TypeAlias

from drivers.roomba.service import Checkpoint

SILENCE = 0.35
"""Longest time between two signs of life of a healthy process [s]: reading takes 20 ms, writing to
a stuck line 100 ms, and a busy machine may make it wait."""
OPENING = 5.0
"""The same time while the process opens the port [s]."""
PERIOD = 0.02
"""Time between two looks at the process [s]."""
_LOOKS = 3
"""Looks in a row that find a process overdue before it is killed: after a pause of the whole
machine the first look finds every process so."""
MOST_ENDS, WITHIN = 4, 30.0
"""Ends in this time [s] after which a process is not replaced any more."""
_PRIORITY = 20
"""Real-time priority of the process, where the system allows one; the watchdog has one more."""
_DEADLINE, _SLOT = struct.Struct("d"), struct.Struct("q")
_CHECKPOINT = 8192
"""Space for a checkpoint [bytes]."""
_WATCHDOG = _DEADLINE.size
"""Where the watchdog's deadline is, behind that of the process [bytes]."""

SharedBytes: TypeAlias = "Array[c_ubyte]"
"""Memory that processes share."""


class Heartbeat:
    """Memory that program, watchdog and process share: signs of life, and the last checkpoint."""

    def __init__(self, memory: SharedBytes) -> None:
        """Use memory of `shared_memory`; what it holds stays."""
        self._memory = memoryview(memory).cast("B")

    @staticmethod
    def shared_memory(context: BaseContext) -> SharedBytes:
        """Memory for a heartbeat without a checkpoint, to be given to processes of a context."""
        memory = context.RawArray(c_ubyte, 2 * _DEADLINE.size + _SLOT.size + 2 * _CHECKPOINT)
        _SLOT.pack_into(memory, 2 * _DEADLINE.size, -1)
        return memory

    @property
    def deadline(self) -> float:
        """Time by which the next sign of life of the process is due, by `time.monotonic` [s]."""
        return float(_DEADLINE.unpack_from(self._memory)[0])

    @property
    def watchdog_deadline(self) -> float:
        """Likewise of the watchdog."""
        return float(_DEADLINE.unpack_from(self._memory, _WATCHDOG)[0])

    def beat(self, longest: float) -> None:
        """Give a sign of life of the process; the next one follows within `longest` [s]."""
        _DEADLINE.pack_into(self._memory, 0, time.monotonic() + longest)

    def beat_as_watchdog(self, longest: float) -> None:
        """Likewise of the watchdog."""
        _DEADLINE.pack_into(self._memory, _WATCHDOG, time.monotonic() + longest)

    def remember(self, checkpoint: Checkpoint) -> None:
        """Keep a checkpoint; a process that is killed here leaves the one before."""
        content = pickle.dumps(checkpoint)
        slot = 1 - max(0, self._slot)
        start = self._start(slot)
        self._memory[start : start + len(content)] = content
        _SLOT.pack_into(self._memory, 2 * _DEADLINE.size, slot)

    def checkpoint(self) -> Checkpoint | None:
        """The last checkpoint; None before the first."""
        if self._slot < 0:
            return None
        start = self._start(self._slot)
        checkpoint = pickle.loads(self._memory[start : start + _CHECKPOINT])
        assert isinstance(checkpoint, Checkpoint)
        return checkpoint

    @property
    def _slot(self) -> int:
        return int(_SLOT.unpack_from(self._memory, 2 * _DEADLINE.size)[0])

    def _start(self, slot: int) -> int:
        return 2 * _DEADLINE.size + _SLOT.size + slot * _CHECKPOINT


class OverdueLooks:
    """Counts the looks in a row that find somebody overdue."""

    def __init__(self) -> None:
        self._overdue = 0

    def hangs(self, deadline: float) -> bool:
        """Whether this look, a little after the one before, shows that somebody hangs.

        Args:
            deadline: When the next sign of life was due, by `time.monotonic` [s].
        """
        self._overdue = self._overdue + 1 if time.monotonic() > deadline else 0
        return self._overdue == _LOOKS


class Watchdog:
    """Runs a process of its own, and another one whenever it hangs or dies."""

    def __init__(
        self,
        serve: Callable[[Heartbeat], None],
        stop: Callable[[Heartbeat, str], None],
        heartbeat: Heartbeat,
    ) -> None:
        """Prepare; nothing runs yet.

        Args:
            serve: The work of the process, which ends it by returning.
            stop: Stops the wheels after the process died, given why it did. It raises an OSError
                where nobody is left to drive.
            heartbeat: Shared with who watches this watchdog.
        """
        self._serve = serve
        self._stop = stop
        self._heartbeat = heartbeat
        self._pid = 0
        self._ends = False

    def run(self) -> int:
        """Watch until the process ends by itself, which is exit code 0, or too often."""
        _raise_priority(_PRIORITY + 1)
        signal.signal(signal.SIGTERM, self._end)
        ends: deque[float] = deque(maxlen=MOST_ENDS)
        while True:
            self._start()
            reason = self._watch()
            if not reason:
                return 0
            self._heartbeat.beat_as_watchdog(OPENING)
            try:
                self._stop(self._heartbeat, reason)
            except OSError:
                return 0
            if self._ends:
                return 0
            ends.append(time.monotonic())
            if len(ends) == MOST_ENDS and ends[-1] - ends[0] <= WITHIN:
                return 1

    def _end(self, *_: object) -> None:
        """End the process, and start no other one."""
        self._ends = True
        if self._pid:
            with suppress(ProcessLookupError):
                os.kill(self._pid, signal.SIGTERM)

    def _start(self) -> None:
        """Start the process; a signal that comes meanwhile waits for it."""
        self._heartbeat.beat(OPENING)
        self._heartbeat.beat_as_watchdog(OPENING)
        signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM])
        self._pid = os.fork()
        if self._pid == 0:
            self._run_service()
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])

    def _run_service(self) -> None:
        """Be the process, to its end."""
        code = 1
        try:
            _raise_priority(_PRIORITY)
            signal.signal(signal.SIGTERM, lambda *_: sys.exit())
            signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])
            self._serve(self._heartbeat)
            code = 0
        except SystemExit:
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)

    def _watch(self) -> str:
        """Why the process ended; empty where it ended by itself."""
        looks = OverdueLooks()
        while True:
            self._heartbeat.beat_as_watchdog(SILENCE)
            ended, status = os.waitpid(self._pid, os.WNOHANG)
            if ended:
                return "ended" if status else ""
            if looks.hangs(self._heartbeat.deadline):
                os.kill(self._pid, signal.SIGKILL)
                os.waitpid(self._pid, 0)
                return f"gave no sign of life for {SILENCE} s"
            time.sleep(PERIOD)


def _raise_priority(priority: int) -> None:
    """Ask for a real-time priority for this process; without the right to it goes on as is."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError:
        try:
            os.setpriority(os.PRIO_PROCESS, 0, -10)
        except OSError:
            return
