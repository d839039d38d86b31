"""The folder of a saved map as a whole: found, moved, deleted, and held while a robot is in it."""

from __future__ import annotations

import fcntl
import logging
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mapping.map_header import HEADER, REMEDY, is_map_file
from vizbot.core.closeable import Closeable
from vizbot.core.errors import MapError

log = logging.getLogger(__name__)


class MapUse(Closeable):
    """A claim to a saved map: until it is closed or its process ends, nobody deletes the map."""

    def __init__(self, folder: Path) -> None:
        """Claim a map; several robots may.

        Raises:
            OSError: there is no such folder.
        """
        self._descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_SH)
        except OSError:
            os.close(self._descriptor)
            raise

    def close(self) -> None:
        """End the claim; twice is fine."""
        descriptor, self._descriptor = self._descriptor, -1
        if descriptor >= 0:
            os.close(descriptor)


def is_in_use(folder: Path) -> bool:
    """Whether a robot on this machine is in a saved map.

    Raises:
        OSError: there is no such folder.
    """
    try:
        with _claimed_alone(folder):
            return False
    except BlockingIOError:
        return True


def delete(folder: Path) -> None:
    """Delete a saved map. Whenever that is interrupted, the map is whole or gone.

    Raises:
        MapError: there is no such map, a robot is in it, it is a link, it holds other files, or it
            cannot be deleted.
    """
    _require_map(folder)
    try:
        with _claimed_alone(folder):
            shutil.rmtree(previous_folder(folder), ignore_errors=True)  # else that would be loaded
            doomed = folder.with_name(f".{folder.name}.deleted")
            shutil.rmtree(doomed, ignore_errors=True)
            folder.rename(doomed)
            sync_folder(folder.parent)
    except BlockingIOError as error:
        raise MapError(f"the map {folder.name!r} is in use; change to another map first") from error
    except OSError as error:
        raise MapError(
            f"the map {folder.name!r} cannot be deleted: {error.strerror}; see who may write to"
            f" {folder.parent}"
        ) from error
    for each in folder.parent.glob(".*.deleted"):  # also what is left of an interrupted deletion
        shutil.rmtree(each, ignore_errors=True)


def move(folder: Path, new: Path) -> None:
    """Move a saved map; a claim to it goes with it.

    Raises:
        MapError: there is no such map, it is a link, it holds other files, something is there
            already, or it cannot be moved.
    """
    _require_map(folder)
    if new.exists() or new.is_symlink() or previous_folder(new).exists():
        raise MapError(f"there is a map {new.name!r} already; delete it or give another name")
    try:
        shutil.rmtree(previous_folder(folder), ignore_errors=True)  # else that would be loaded
        folder.rename(new)
        sync_folder(new.parent)
    except OSError as error:
        raise MapError(
            f"the map {folder.name!r} cannot be renamed: {error.strerror}; see who may write to"
            f" {folder.parent}"
        ) from error


def is_readable(folder: Path) -> bool:
    """Whether there is a folder of a map, or the map before one that was being replaced.

    Raises:
        OSError: that cannot be seen.
    """
    return folder.is_dir() or previous_folder(real_folder(folder)).is_dir()


def readable_folder(folder: Path) -> Path:
    """Where a map is, or the map before where a program was killed while it replaced it.

    Raises:
        MapError: there is no map.
    """
    previous = previous_folder(real_folder(folder))
    try:
        if not folder.is_dir() and previous.is_dir():
            log.warning("%s was not replaced to the end: the map before is read", folder)
            return previous
        found = folder.is_dir()
    except OSError as error:
        raise MapError(f"no map at {folder}: {error.strerror}") from error
    if not found:
        raise MapError(f"no map at {folder}: {REMEDY}")
    return folder


def real_folder(folder: Path) -> Path:
    """The folder that a chain of links leads to; in a loop it is one of the links."""
    return Path(os.path.realpath(folder))


def previous_folder(folder: Path) -> Path:
    """Where the previous map is kept while a new one replaces it."""
    return folder.with_name(f".{folder.name}.previous")


def sync_folder(folder: Path) -> None:
    """Flush a folder, so that new and renamed files in it survive a power cut."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _require_map(folder: Path) -> None:
    """Reject a folder that is more or something else than one map, damaged or not."""
    if folder.is_symlink():
        raise MapError(f"{folder} is a link and is left alone: remove it by hand")
    try:
        names = {path.name for path in folder.iterdir()}
    except OSError as error:
        raise MapError(f"no map at {folder}: {error.strerror}") from error
    if HEADER not in names:
        raise MapError(f"{folder} is not a map, it has no {HEADER}: {REMEDY}")
    if others := sorted(name for name in names if not is_map_file(name)):
        raise MapError(
            f"{folder} holds more than a map ({others[0]!r}) and is left alone: move that elsewhere"
        )


@contextmanager
def _claimed_alone(folder: Path) -> Iterator[None]:
    """Claim a folder alone.

    Raises:
        BlockingIOError: a robot is in it.
        OSError: there is no such folder.
    """
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise
        except OSError:
            pass  # a file system without locks, where nobody has claimed anything
        yield
    finally:
        os.close(descriptor)
