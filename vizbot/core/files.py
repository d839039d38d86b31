"""Writes files whole or not at all, and reads files that may hold anything."""

from __future__ import annotations

import errno
import json
import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BufferedReader
from pathlib import Path
from stat import S_IMODE, S_ISREG
from tempfile import TemporaryFile
from typing import Any
from weakref import finalize

from vizbot.core.errors import ConfigError

log = logging.getLogger(__name__)

_NO_HOME = Path("/nonexistent")
"""Debian's name for the home of a user who has none."""
_DEEPEST = 16
"""Most levels of lists and tables in a JSON file."""


def user_folder(variable: str, default: str) -> Path:
    """This user's folder for files of vizbot, which may not be there.

    Args:
        variable: Environment variable that names the folder that holds it, such as
            `XDG_CACHE_HOME`; a relative path is ignored (XDG Base Directory Specification).
        default: That folder in the user's home. For a user without a home, as a service may be, it
            is one that is never there.
    """
    home = Path(os.path.expanduser("~"))  # noqa: PTH111  Path.home() raises where there is none
    named = Path(os.environ.get(variable, ""))
    usual = (home if home.is_absolute() else _NO_HOME) / default
    return (named if named.is_absolute() else usual) / "vizbot"


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


def require_new(path: Path, *, replace: bool) -> None:
    """Refuse to write over a file that is there, unless a person asked to replace it.

    Raises:
        ConfigError: it is there, whatever it is, or cannot be written.
    """
    if not replace and os.path.lexists(path):
        raise ConfigError(f"{path} is there already; give another file by --out, or add --force")
    require_writable(path)


class GrowingFile:
    """A text file that gets whole lines while a run goes on; a killed program loses none of them.

    Lines that cannot be written, as on a full disk, wait for the next ones; nothing is raised.

    Attributes:
        close: Ends the file; twice is fine.
    """

    def __init__(self, path: Path, heading: str) -> None:
        """Begin a file with its first line.

        Raises:
            OSError: the file cannot be made.
        """
        self._path = path
        self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        self.close = finalize(self, os.close, self._descriptor)
        self._size, self._waiting, self._fails = 0, b"", False
        self.add(heading)

    def add(self, lines: str) -> None:
        """Write lines, each with its end."""
        self._waiting += lines.encode()
        written = 0
        try:
            while written < len(self._waiting):  # a disk that becomes full takes a part at first
                rest = self._waiting[written:]
                written += os.pwrite(self._descriptor, rest, self._size + written)
            self._fails = False
        except OSError as error:
            if not self._fails:
                log.warning("%s lacks lines: %s; the run goes on", self._path, error.strerror)
            self._fails = True
        whole = self._waiting.rfind(b"\n", 0, written) + 1  # part of a line is written again
        self._size += whole
        self._waiting = self._waiting[whole:]


def require_folder(folder: Path, room: int = 0) -> None:
    """Check beforehand whether a folder can be made, or written to; nothing changes.

    `room` is what it must have room for [bytes].

    Raises:
        OSError: it cannot be made or written to, or there is no room.
    """
    missing = [each for each in (folder, *folder.parents) if not os.path.lexists(each)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder) as file:
            if room:
                os.posix_fallocate(file.fileno(), 0, room)
    finally:
        for each in missing:
            with suppress(OSError):
                each.rmdir()


def open_regular(path: Path, most: int) -> BufferedReader:
    """Open a file for reading that has `most` bytes at most; nothing is waited for or read.

    Raises:
        OSError: it is missing, larger, or anything but a regular file, as a pipe or a device.
    """
    if not S_ISREG(path.stat().st_mode):  # opening some devices has effects
        raise OSError(errno.EINVAL, "it is not a regular file", str(path))
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        status = os.fstat(descriptor)
        if not S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "it is not a regular file", str(path))
        if status.st_size > most:
            found = f"it has {status.st_size} bytes, more than {most}"
            raise OSError(errno.EFBIG, found, str(path))
        return os.fdopen(descriptor, "rb")
    except OSError:
        os.close(descriptor)
        raise


def read_regular(path: Path, most: int) -> bytes:
    """Read a whole file; arguments and errors as for `open_regular`."""
    with open_regular(path, most) as file:
        content = file.read(most + 1)
    if len(content) > most:  # it has grown meanwhile
        raise OSError(errno.EFBIG, f"it has more than {most} bytes", str(path))
    return content


def parse_json(content: bytes) -> Any:
    """Parse JSON in UTF-8, of at most 16 levels of lists and tables.

    Raises:
        ValueError: it is not JSON, or nested deeper.
    """
    try:
        parsed = json.loads(content.decode("utf-8-sig"))
    except RecursionError as error:
        raise ValueError("it is nested too deep") from error
    level = [parsed]
    for _ in range(_DEEPEST + 1):
        nested = [node for node in level if isinstance(node, (dict, list))]
        level = [
            child
            for node in nested
            for child in (node.values() if isinstance(node, dict) else node)
        ]
        if not nested:
            return parsed
    raise ValueError("it is nested too deep")


@contextmanager
def _partial(path: Path) -> Iterator[Path]:
    """Make an empty file beside `path`, and remove it at the end if it is still there."""
    try:
        target = path.resolve()
    except RuntimeError as error:  # until Python 3.12
        raise ConfigError(f"{path} is a link that leads to itself; give another file") from error
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
