"""A home that a process of its own draws, while this one loads what it needs to drive there.

Drawing a home takes a second of work that holds the interpreter, as do imports; in two processes
they share nothing.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:  # their modules load what the other process is there for
    from sim_stubs.homes.geometry.free_space import FreeSpace
    from sim_stubs.homes.geometry.house import House


_PIPE = 1 << 20
"""Bytes of a home that wait in the pipe; the system gives no more to users."""


class HomeProcess:
    """The home of one seed, under way; `close` ends it."""

    def __init__(self, seed: int) -> None:
        """Begin to draw."""
        self._seed = seed
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", __name__, str(seed)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            pipesize=_PIPE,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            start_new_session=True,  # Ctrl-C is for the program alone
        )

    def home_and_space(self) -> tuple[House, FreeSpace]:
        """What `sim_stubs.homes.home.home_and_space` returns; drawn here where that has failed.

        Raises:
            ConfigError: as there.
        """
        from sim_stubs.homes.home import home_and_space

        assert self._process.stdout is not None
        content = self._process.stdout.read()
        if self._process.wait() != 0:
            return home_and_space(self._seed)
        drawn: tuple[House, FreeSpace] = pickle.loads(content)
        return drawn

    def close(self) -> None:
        """End the process, whatever it has done."""
        self._process.kill()
        self._process.__exit__(None, None, None)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()


def main(seed: str) -> None:
    """Draw the home of a seed and write it to standard output."""
    from sim_stubs.homes.home import home_and_space

    sys.stdout.buffer.write(pickle.dumps(home_and_space(int(seed)), pickle.HIGHEST_PROTOCOL))


if __name__ == "__main__":
    main(*sys.argv[1:])
