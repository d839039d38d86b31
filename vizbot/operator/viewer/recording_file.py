"""A file that is written through a pipe, so that a full disk causes an error here alone.

If rerun writes a file itself, a failed write blocks its `flush` for ever: the writing thread is
gone.
"""

from __future__ import annotations

import io
import logging
import os
from pathlib import Path
from threading import Thread

from vizbot.core.errors import ConfigError

log = logging.getLogger(__name__)

_AT_ONCE = 1 << 16
"""Most that is copied in one go [bytes]."""
_FREE_AT_LEAST = 1 << 20
"""A disk with less free space is full [bytes]."""
_CLOSED_WITHIN = 10.0
"""Longest wait for the rest to be copied [s]."""
_REMEDY = "free some space"


class RecordingFile:
    """Copies what is written to the path `entrance` into a file; drops the rest after an error."""

    def __init__(self, path: Path) -> None:
        """Begin the file anew.

        Raises:
            ConfigError: it cannot be written.
        """
        self._path = path
        try:
            self._file = _with_space(path)
        except OSError as error:
            raise ConfigError(
                f"cannot write {path}: {error.strerror}; {_REMEDY}, or go without --rerun"
            ) from error
        self._exit, self._entrance = os.pipe()
        self._closed = False
        self._copying = Thread(target=self._copy, name="recording", daemon=True)
        self._copying.start()

    @property
    def entrance(self) -> Path:
        """The path to write to; may be opened until `close`."""
        return Path(f"/dev/fd/{self._entrance}")

    def close(self) -> None:
        """Wait until all is in the file; others who opened `entrance` must have closed it."""
        if not self._closed:
            self._closed = True
            os.close(self._entrance)
            self._copying.join(_CLOSED_WITHIN)

    def _copy(self) -> None:
        whole = True
        with self._file, os.fdopen(self._exit, "rb", buffering=0) as pipe:
            while written := pipe.read(_AT_ONCE):
                if not whole:
                    continue
                try:
                    self._write(memoryview(written))
                except OSError as error:
                    whole = False
                    log.warning("%s is not whole: %s; %s", self._path, error.strerror, _REMEDY)

    def _write(self, written: memoryview) -> None:
        while written:
            written = written[self._file.write(written) :]


def _with_space(path: Path) -> io.FileIO:
    """An empty file on a disk with room; raise OSError where there is none."""
    path.write_bytes(bytes(_FREE_AT_LEAST))
    return io.FileIO(path, "w")
