"""Files of finished results: one JSON object a line, each with its key."""

from __future__ import annotations

import json
from collections.abc import Callable, Hashable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from pydantic import TypeAdapter

from vizbot.core.errors import ConfigError
from vizbot.core.files import parse_json, write_whole

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T", bound="DataclassInstance")


@dataclass(frozen=True, slots=True)
class StoredResult(Generic[T]):
    """A result as it is stored."""

    key: str
    commit: str
    hardware: str
    result: T


class Store(Generic[T]):
    """One file of results, which every change writes as a whole."""

    def __init__(self, path: Path, kind: type[T]) -> None:
        """Read the file, if there is one.

        Raises:
            ConfigError: the file cannot be read, or a line is no result of this kind.
        """
        self._path = path
        self._lines: list[StoredResult[T]] = []
        adapter = TypeAdapter(kind)
        try:
            content = path.read_bytes()
        except FileNotFoundError:
            content = b""
        except OSError as error:
            raise ConfigError(f"results {path} cannot be read: {error.strerror}") from error
        for number, line in enumerate(content.splitlines(), start=1):
            try:
                fields = parse_json(line)
                if not isinstance(fields, dict):
                    raise TypeError(f"{type(fields).__name__} is no object")
                key, commit, hardware = (
                    _text(fields.pop(k)) for k in ("key", "commit", "hardware")
                )
                self._lines.append(
                    StoredResult(key, commit, hardware, adapter.validate_python(fields))
                )
            except (ValueError, KeyError, TypeError) as error:
                raise ConfigError(
                    f"{path}, line {number} is no result; delete that line"
                ) from error

    def results_with_key(self, key: str) -> list[T]:
        """Results with this key, in the order they were finished."""
        return [stored.result for stored in self.stored_with_key(key)]

    def stored_with_key(self, key: str) -> list[StoredResult[T]]:
        """Results with this key, with their commits and machines."""
        return [stored for stored in self._lines if stored.key == key]

    def fullest(self) -> list[StoredResult[T]]:
        """The results with the key that has most of them; the newest key among equals."""
        by_key: dict[str, list[StoredResult[T]]] = {}
        for stored in self._lines:
            by_key.setdefault(stored.key, []).append(stored)
        return max(reversed(by_key.values()), key=len, default=[])

    def newest(self, of: Callable[[T], Hashable]) -> list[StoredResult[T]]:
        """The newest result of each thing that `of` names, whatever its key."""
        return list({of(stored.result): stored for stored in self._lines}.values())

    def all(self) -> list[StoredResult[T]]:
        """All results, in the order they were finished."""
        return list(self._lines)

    def add(self, key: str, commit: str, hardware: str, *results: T) -> None:
        """Append results and write the file."""
        self._lines += [StoredResult(key, commit, hardware, result) for result in results]
        self._write()

    def drop_others(self, key: str) -> None:
        """Delete the results with other keys."""
        self._lines = self.stored_with_key(key)
        self._write()

    def _write(self) -> None:
        lines = [
            json.dumps(
                {"key": stored.key, "commit": stored.commit, "hardware": stored.hardware}
                | asdict(stored.result),
                separators=(",", ":"),
            )
            for stored in self._lines
        ]
        self._path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self._path, "".join(f"{line}\n" for line in lines).encode())


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is no text")
    return value
