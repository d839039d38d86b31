"""Files that are written whole or not at all, whatever interrupts the writing."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from stat import S_IMODE

from vizbot.core.errors import ConfigError


def write_whole(path: Path, content: bytes) -> None:
    """Write a file. An existing one is replaced once the new one is whole on disk.

    The new file gets the rights of the old one and, as far as that is allowed, its owner.

    Raises:
        ConfigError: the file cannot be written, or `path` is something other than a file.
    """
    with _partial(path) as partial:
        with partial.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path.resolve())


def require_writable(path: Path) -> None:
    """Check beforehand whether `write_whole` can write there; nothing changes.

    Raises:
        ConfigError: the file cannot be written.
    """
    with _partial(path):
        pass


@contextmanager
def _partial(path: Path) -> Iterator[Path]:
    """Make an empty file beside `path`, and remove it at the end if it is still there."""
    target = path.resolve()
    partial = target.with_name(f".{target.name}.partial-{os.getpid()}")
    try:
        before = target.stat() if target.exists() else None
        if before is not None and not target.is_file():
            raise ConfigError(f"{path} is there and is not a file; give another file")
        if before is not None and not os.access(target, os.W_OK):
            raise ConfigError(f"{path} may not be written; chmod u+w it, or give another file")
        partial.touch()
        if before is not None:
            with suppress(OSError):
                os.chown(partial, before.st_uid, before.st_gid)
            partial.chmod(S_IMODE(before.st_mode))
        yield partial
    except OSError as error:
        raise ConfigError(f"cannot write {path}: {error.strerror}; give another file") from error
    finally:
        with suppress(OSError):
            partial.unlink()
