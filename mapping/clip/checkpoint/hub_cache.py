"""The cache of the Hugging Face hub: which revisions of a model were fetched."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

_MAIN = "main"
_LONGEST_HASH = 200
"""A file of a reference with more letters is none."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """A revision of a model that was fetched, perhaps in part.

    Attributes:
        revision: The name of what was asked for (`main`, `refs/pr/15`), else the commit.
    """

    folder: Path
    revision: str

    @property
    def is_main(self) -> bool:
        """Whether it is what is fetched unless a revision is named."""
        return self.revision == _MAIN


def snapshots_of(source: str) -> list[Snapshot]:
    """Revisions of a model by its hub name: the main one, those with a name, then the newest."""
    from huggingface_hub import constants
    from huggingface_hub.file_download import repo_folder_name

    folder = repo_folder_name(repo_id=source, repo_type="model")
    return snapshots_in(Path(constants.HF_HUB_CACHE) / folder)


def snapshots_in(folder: Path) -> list[Snapshot]:
    """The same of a folder of the cache, `models--OWNER--NAME`; none where it is no such folder."""
    names: dict[str, str] = {}
    for path in sorted((folder / "refs").rglob("*")):
        if path.is_file() and path.stat().st_size < _LONGEST_HASH:
            name, commit = path.relative_to(folder / "refs").as_posix(), path.read_bytes().strip()
            if names.get(known := commit.decode(errors="replace")) != _MAIN:
                names[known] = name
    found = [each for each in (folder / "snapshots").glob("*") if each.is_dir()]
    found.sort(key=lambda each: -each.stat().st_mtime)
    named = [Snapshot(each, names.get(each.name, each.name)) for each in found]
    return sorted(named, key=lambda each: (not each.is_main, each.folder.name not in names))


def weights_first(
    snapshots: Sequence[Snapshot], names: Sequence[str]
) -> tuple[Snapshot, str] | None:
    """The first snapshot with the earliest of these files, and the file; None where none has one.

    Better `snapshots` and `names` come first; a better file counts more than a better snapshot.
    """
    return next(
        ((each, name) for name in names for each in snapshots if (each.folder / name).is_file()),
        None,
    )
