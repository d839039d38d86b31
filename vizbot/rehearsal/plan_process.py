"""A world that a process of its own plans, while this one loads what it needs to drive there.

Drawing a home occupies the interpreter for a second, as imports do; two processes do both at once.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from typing import TYPE_CHECKING, Any

from sim_stubs.world.body import Outline
from vizbot.core.closeable import Closeable
from vizbot.core.program.interpreter import end_when_left

if TYPE_CHECKING:  # its module loads what the other process is there for
    from sim_stubs.world.world_plan import HouseShape, WorldPlan


_PIPE = 1 << 20
"""Bytes of a plan that wait in the pipe; the system gives no more to users."""


class PlanProcess(Closeable):
    """The plan of a world, under way; `close` ends it."""

    def __init__(
        self,
        spec: str,
        outline: Outline,
        text: str = "",
        start: tuple[float, float, float] | None = None,
    ) -> None:
        """Begin.

        Args:
            spec: As `sim_stubs.world.world_name.plan_world` takes it.
            outline: The robot's.
            text: As `plan_world` takes it.
            start: As there.
        """
        self._asked = (spec, text, None, start), outline
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            pipesize=_PIPE,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            start_new_session=True,  # Ctrl-C is for the program alone
        )
        assert self._process.stdin is not None
        try:
            with self._process.stdin as asked:
                pickle.dump(self._asked, asked)
        except BrokenPipeError:
            pass  # it could not start

    def plan(self) -> WorldPlan:
        """What `plan_world` returns; it is called here where the process has failed.

        Raises:
            ConfigError: as there.
        """
        planned: WorldPlan | None = self._next()
        if planned is None:
            from sim_stubs.world.world_name import plan_world

            planned = plan_world(*self._asked[0])
        return planned

    def shape(self, plan: WorldPlan) -> HouseShape:
        """What `shape_of` returns for the plan, likewise; to be asked for after `plan`.

        Raises:
            ConfigError: as there.
        """
        shape: HouseShape | None = self._next()
        if shape is None:
            from sim_stubs.world.world_name import shape_of

            shape = shape_of(plan, self._asked[1])
        self._process.wait()  # it has ended, or is about to
        return shape

    def _next(self) -> Any:
        """The next thing that the process has made; None where it has failed."""
        assert self._process.stdout is not None
        try:
            return pickle.load(self._process.stdout)
        except (EOFError, pickle.UnpicklingError):  # it ended before, or amid it
            return None

    def close(self) -> None:
        """End the process, whatever it has done."""
        self._process.kill()
        self._process.__exit__(None, None, None)


def main() -> None:
    """Write plan and shape of the world that standard input asks for to standard output.

    It ends when the reader of its output does.
    """
    end_when_left(sys.stdout.fileno())
    from sim_stubs.world.world_name import plan_world, shape_of

    asked, outline = pickle.load(sys.stdin.buffer)
    planned = plan_world(*asked)
    pickle.dump(planned, sys.stdout.buffer, pickle.HIGHEST_PROTOCOL)
    sys.stdout.buffer.flush()
    pickle.dump(shape_of(planned, outline), sys.stdout.buffer, pickle.HIGHEST_PROTOCOL)
    sys.stdout.buffer.flush()
    os._exit(0)  # to free all that was loaded would take a third of a second


if __name__ == "__main__":
    main()
