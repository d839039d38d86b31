"""Files that are there whole or not at all, whatever interrupts their writing."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from vizbot.core.errors import ConfigError


def write_whole(path: Path, content: bytes) -> None:
    """Write a file; one that is there is replaced once the new one is whole on disk.

    Raises:
        ConfigError: the file cannot be written, or `path` is something other than a file.
    """
    target = path.resolve()
    if target.exists() and not target.is_file():
        raise ConfigError(f"{path} is there and is not a file; give another file")
    partial = target.with_name(f".{target.name}.partial-{os.getpid()}")
    try:
        with partial.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(target)
    except OSError as error:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise ConfigError(f"cannot write {path}: {error.strerror}; give another file") from error
