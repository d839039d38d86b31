"""Saves a growing map again and again: whole at first, and then what is new."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapping.clip.growing_rows import chosen_rows
from mapping.map_arrays import MOST_BYTES
from mapping.map_bundle import arrays_of, header_of, save, unwritable, write_header
from mapping.map_folder import real_folder, sync_folder
from mapping.map_header import HEADER, MapHeader
from mapping.map_segments import MOST_SEGMENTS, Segment, segment_name
from mapping.map_snapshot import MapSnapshot
from mapping.tensor_file import size_of, write_through
from vizbot.core.errors import MapError


@dataclass(frozen=True, slots=True)
class _Saved:
    """What is on the disk: the header of the map, and the snapshot that was saved last."""

    header: MapHeader
    snapshot: MapSnapshot


class MapSaver:
    """Keeps the map of one run in a folder; a program that is killed leaves the last one whole."""

    def __init__(self, folder: Path) -> None:
        """Begin with nothing saved; `folder` is new, or is replaced by the first save."""
        self._folder = folder
        self._saved: _Saved | None = None

    def save(self, snapshot: MapSnapshot) -> None:
        """Save a map as it is now: what is new of the one before, or all of another one.

        Raises:
            MapError: it cannot be written, or has become too large; what was saved before is whole.
        """
        before, self._saved = self._saved, None  # after an error the next one is saved whole
        if before is None or not _goes_on(before, snapshot):
            header = save(snapshot.bundle(), self._folder)
        else:
            header = self._append(before, snapshot)
        self._saved = _Saved(header, snapshot)

    def _append(self, before: _Saved, snapshot: MapSnapshot) -> MapHeader:
        """Write the next segment, and then the header that names it."""
        folder = real_folder(self._folder)
        bundle = _since(before.snapshot, snapshot).bundle()
        arrays = arrays_of(bundle)
        size = before.header.tensors_size + sum(each.size for each in before.header.segments)
        if size + size_of(arrays) > MOST_BYTES:
            raise MapError(
                f"the map {folder} is not saved, it has more than {MOST_BYTES} bytes:"
                " begin a new map"
            )
        partial = folder.with_name(f".{folder.name}.partial")
        try:
            number = len(before.header.segments) + 1
            sha256 = write_through(folder / segment_name(number), arrays)
            segments = (*before.header.segments, Segment(size=size_of(arrays), sha256=sha256))
            added = header_of(bundle, before.header.tensors_size)
            counts = {
                name: count if name == "keyframes" else count + before.header.counts[name]
                for name, count in added.counts.items()
            }
            header = added.model_copy(
                update={
                    "counts": counts,
                    "tensors_sha256": before.header.tensors_sha256,
                    "segments": segments,
                }
            )
            partial.mkdir(exist_ok=True)
            write_header(partial, header)
            (partial / HEADER).replace(folder / HEADER)
            sync_folder(folder)
            partial.rmdir()
        except OSError as error:
            raise unwritable(folder, error) from error
        return header


def _goes_on(before: _Saved, now: MapSnapshot) -> bool:
    """Whether a map has the rows that are saved, and perhaps more, and has room for a segment."""
    tables = zip(_tables_of(before.snapshot), _tables_of(now), strict=True)
    return (
        len(before.header.segments) < MOST_SEGMENTS
        and all(_begins_with(new, old) for old, new in tables)
        and before.snapshot.features.keys() <= now.features.keys()
        and before.snapshot.model_id == now.model_id
        and len(before.snapshot.pictures) == len(now.pictures)
    )


def _tables_of(snapshot: MapSnapshot) -> tuple[NDArray[np.generic], ...]:
    """A column of each table that only grows."""
    return (
        snapshot.elements.frames,
        snapshot.statistics,
        snapshot.places.frames,
        snapshot.frames.numbers,
        snapshot.cloud.keyframes,
        snapshot.trajectory.keyframes,
    )


def _begins_with(rows: NDArray[np.generic], first: NDArray[np.generic]) -> bool:
    """Whether a column has these rows first, in the very memory that they were in before.

    Rows that were never there are no beginning: a map that has none is soon saved.
    """
    return 0 < len(first) <= len(rows) and bool(np.may_share_memory(rows, first))


def _since(before: MapSnapshot, now: MapSnapshot) -> MapSnapshot:
    """A map with the rows alone that came after an earlier snapshot of it."""
    return replace(
        now,
        features={i: now.features[i] for i in now.features.keys() - before.features.keys()},
        elements=chosen_rows(now.elements, slice(len(before.elements.frames), None)),
        statistics=now.statistics[len(before.statistics) :],
        pictures=now.pictures[:0],
        places=chosen_rows(now.places, slice(len(before.places), None)),
        frames=chosen_rows(now.frames, slice(len(before.frames), None)),
        cloud=chosen_rows(now.cloud, slice(len(before.cloud.keyframes), None)),
        trajectory=chosen_rows(now.trajectory, slice(len(before.trajectory.stamps), None)),
    )
