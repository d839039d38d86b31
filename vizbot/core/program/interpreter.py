"""Programs of ours that run in an interpreter of their own: their command lines and their end."""

from __future__ import annotations

import os
import select
import sys
import threading
from pathlib import Path

_IMPORT_FROM = str(Path(__file__).parents[3])


def interpreter_command(module: str, *arguments: str, packages: bool = True) -> list[str]:
    """Command line that calls `main(*arguments)` of a module in an interpreter of its own.

    Nothing is imported from the working directory.

    Without installed `packages`, which it then cannot import, it starts at once.
    """
    # Before other installed copies of ours, but not before the standard library.
    add = f"insert(0, {_IMPORT_FROM!r})" if packages else f"append({_IMPORT_FROM!r})"
    program = (
        f"import sys; {_IMPORT_FROM!r} in sys.path or sys.path.{add};"
        f" from {module} import main; main(*sys.argv[1:])"
    )
    flags = ["-P"] if packages else ["-I", "-S"]
    return [sys.executable, *flags, "-c", program, *arguments]


def end_when_left(descriptor: int) -> None:
    """End this process as soon as nobody holds the other end of a pipe or socket of it.

    Whoever has started it is gone then, in whatever way.
    """
    other_end = select.poll()
    other_end.register(descriptor, 0)  # poll always reports that it hangs up

    def wait() -> None:
        other_end.poll()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
