"""An array that grows by rows without moving the rows that it has.

Doubling an array copies it, and a robot with a large map would stand still meanwhile. So an array
has addresses for far more rows than it holds. The system gives memory to those that were written
to.
"""

from __future__ import annotations

import logging
import math
import mmap
import resource
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Number = TypeVar("Number", bound=np.generic)
Table = TypeVar("Table", bound="DataclassInstance")

log = logging.getLogger(__name__)

ROOM = 1 << 22
"""Number of rows that have addresses, four times those of the largest measured map. An array that
grows beyond them is copied."""
_NO_RESERVE = 0x4000
"""`MAP_NORESERVE` of mmap(2), which Python does not name: addresses count as no memory."""
_STRICT = "2"
"""As `vm.overcommit_memory`: the system counts addresses as memory whatever was asked for."""


class GrowingRows(Generic[Number]):
    """Rows of numbers, with room for more."""

    def __init__(self, first: NDArray[Number], room: int = ROOM) -> None:
        """Begin with a copy of these rows (N, ...), and addresses for `room` of them."""
        self._room, self._size = room, len(first)
        self._rows: NDArray[Number] = _with_room(
            max(room, len(first)), len(first), first.shape[1:], first.dtype
        )
        self._rows[: self._size] = first

    def __len__(self) -> int:
        return self._size

    @property
    def rows(self) -> NDArray[Number]:
        """All rows (N, ...), as a view that later additions do not change."""
        return self._rows[: self._size]

    def add(self, fresh: NDArray[Number]) -> None:
        """Add rows (M, ...)."""
        start, end = self._size, self._size + len(fresh)
        self._reach(end)
        self._rows[start:end] = fresh
        self._size = end

    def add_same(self, value: ArrayLike, count: int) -> None:
        """Add `count` rows that all have one value."""
        start, end = self._size, self._size + count
        self._reach(end)
        self._rows[start:end] = value
        self._size = end

    def with_changed(self, chosen: NDArray[np.integer], values: NDArray[Number]) -> Self:
        """A copy whose `chosen` rows (M,) have other values (M, ...)."""
        changed = type(self)(self.rows, self._room)
        changed._rows[chosen] = values
        return changed

    def _reach(self, end: int) -> None:
        """Have rows up to `end`."""
        if end <= len(self._rows):
            return
        more = max(end, 2 * len(self._rows), 256)
        grown: NDArray[Number] = _with_room(more, more, self._rows.shape[1:], self._rows.dtype)
        grown[: self._size] = self.rows
        self._rows = grown


class GrowingTable(Generic[Table]):
    """A table, a dataclass whose fields are arrays of one length, with room for more rows."""

    def __init__(self, first: Table, room: int = ROOM) -> None:
        """Begin with a copy of this table, and addresses for `room` rows."""
        self._kind, self._room = type(first), room
        self._columns = [GrowingRows(each, room) for each in _columns_of(first)]

    def __len__(self) -> int:
        return len(self._columns[0])

    @property
    def rows(self) -> Table:
        """All rows, as views that later additions do not change."""
        return self._kind(*(column.rows for column in self._columns))

    def add(self, fresh: Table) -> None:
        """Add the rows of another table."""
        for column, more in zip(self._columns, _columns_of(fresh), strict=True):
            column.add(more)


def chosen_rows(table: Table, chosen: slice | NDArray[np.bool_]) -> Table:
    """Some rows of a table: a part, or those where (N,) is true."""
    return type(table)(*(column[chosen] for column in _columns_of(table)))


def _columns_of(table: DataclassInstance) -> list[NDArray[Any]]:
    return [getattr(table, each.name) for each in fields(table)]


def _with_room(room: int, least: int, shape: Sequence[int], dtype: DTypeLike) -> NDArray[Any]:
    """An array of `room` rows; where the system gives no mere addresses, of `least`."""
    row = np.dtype(dtype).itemsize * math.prod(shape)
    if row and _has_addresses():
        with suppress(OSError, OverflowError):
            flags = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | _NO_RESERVE
            memory = mmap.mmap(-1, room * row, flags=flags)
            with suppress(OSError):  # a kernel without huge pages, of which each is 2 MB at once
                memory.madvise(mmap.MADV_NOHUGEPAGE)
            return np.frombuffer(memory, dtype).reshape(room, *shape)
    return np.empty((least, *shape), dtype)


@cache
def _has_addresses() -> bool:
    """Whether addresses cost nothing here: nobody limits them or counts them as memory."""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    try:
        policy = Path("/proc/sys/vm/overcommit_memory").read_text().strip()
    except OSError:
        policy = ""
    free = limit == resource.RLIM_INFINITY and policy != _STRICT
    if not free:
        log.warning(
            "addresses are limited here (ulimit -v, or vm.overcommit_memory is 2): a map that grows"
            " is copied now and then, for which the robot waits"
        )
    return free
