"""Command lines of programs of ours that run in an interpreter of their own."""

from __future__ import annotations

import sys
from pathlib import Path

import vizbot

_IMPORT_FROM = str(Path(vizbot.__file__).parents[1])


def interpreter_command(module: str, *arguments: str, packages: bool = True) -> list[str]:
    """Command line that calls `main(*arguments)` of a module in an interpreter of its own.

    Nothing is imported from the working directory.

    Args:
        module: Dotted name of a module of ours.
        arguments: What `main` is called with.
        packages: Whether installed packages can be imported; without them it starts at once.
    """
    # Before other installed copies of ours, but not before the standard library.
    add = f"insert(0, {_IMPORT_FROM!r})" if packages else f"append({_IMPORT_FROM!r})"
    program = (
        f"import sys; {_IMPORT_FROM!r} in sys.path or sys.path.{add};"
        f" from {module} import main; main(*sys.argv[1:])"
    )
    flags = ["-P"] if packages else ["-I", "-S"]
    return [sys.executable, *flags, "-c", program, *arguments]
