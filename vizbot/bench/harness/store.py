"""Finished results, one JSON object a line, each with the key that it holds for."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from pydantic import TypeAdapter

from vizbot.core.errors import ConfigError
from vizbot.core.files import write_whole

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T", bound="DataclassInstance")


@dataclass(frozen=True, slots=True)
class StoredResult(Generic[T]):
    """A result as it is kept.

    Attributes:
        key: Of what it was made with.
        commit: That was checked out.
        hardware: That it ran on.
        result: The result.
    """

    key: str
    commit: str
    hardware: str
    result: T


class Store(Generic[T]):
    """One file of results; every addition leaves it whole."""

    def __init__(self, path: Path, kind: type[T]) -> None:
        """Read what is there.

        Raises:
            ConfigError: a line is no such result.
        """
        self._path = path
        self._lines: list[StoredResult[T]] = []
        adapter = TypeAdapter(kind)
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        for number, line in enumerate(text.splitlines(), start=1):
            try:
                fields: dict[str, Any] = json.loads(line)
                key, commit, hardware = (fields.pop(k) for k in ("key", "commit", "hardware"))
                self._lines.append(
                    StoredResult(key, commit, hardware, adapter.validate_python(fields))
                )
            except (ValueError, KeyError, TypeError) as error:
                raise ConfigError(f"{path}, line {number} is no result; delete it") from error

    def of(self, key: str) -> list[T]:
        """Results of this key, in the order they were finished."""
        return [kept.result for kept in self.kept(key)]

    def kept(self, key: str) -> list[StoredResult[T]]:
        """Likewise, with what they were made with."""
        return [kept for kept in self._lines if kept.key == key]

    def fullest(self, wanted: Callable[[T], bool] = lambda result: True) -> list[StoredResult[T]]:
        """All that is wanted of the key with the most of it; of the newest one among equals."""
        of_key: dict[str, list[StoredResult[T]]] = {}
        for kept in self._lines:
            if wanted(kept.result):
                of_key.setdefault(kept.key, []).append(kept)
        return max(reversed(of_key.values()), key=len, default=[])

    def add(self, key: str, commit: str, hardware: str, *results: T) -> None:
        """Keep results and write the file."""
        self._lines += [StoredResult(key, commit, hardware, result) for result in results]
        self._write()

    def drop_others(self, key: str) -> None:
        """Forget the results of all other keys."""
        self._lines = [kept for kept in self._lines if kept.key == key]
        self._write()

    def _write(self) -> None:
        lines = [
            json.dumps(
                {"key": kept.key, "commit": kept.commit, "hardware": kept.hardware}
                | asdict(kept.result),
                separators=(",", ":"),
            )
            for kept in self._lines
        ]
        self._path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self._path, "".join(f"{line}\n" for line in lines).encode())
