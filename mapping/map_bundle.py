"""A saved map: the result of a run, to be queried, shown and driven in later.

It is a folder with `map.json` (metadata, the encoder's id, checksums) and `map.safetensors` (the
arrays). Points and frames are anchored to keyframes, whose poses alone give theirs in `map`.
"""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from mapping.clip.background.kept_bank import OnProgress
from mapping.clip.background.phrases import PHRASES_ID
from mapping.clip.background.pictures import PICTURES_ID
from mapping.clip.fitted.calibration import EncoderCalibration
from mapping.clip.mapped_frames import MappedFrames
from mapping.clip.mapper import ClipElements
from mapping.clip.own_encoder import is_class_name
from mapping.clip.places.place_rows import PlaceMap, PlaceRows, places_of
from mapping.clip.scores import NO_PICTURES, NO_STATISTICS, Background
from mapping.keyframes.anchors import (
    Cloud,
    Keyframes,
    KeyframeViews,
    Trajectory,
    points_in_map,
    poses_in_map,
)
from mapping.map_arrays import (
    GROWTH,
    MOST_BYTES,
    read_array,
    read_arrays,
    require_arrays,
    require_extent,
    require_places_extent,
)
from mapping.map_folder import previous_folder, readable_folder, real_folder, sync_folder
from mapping.map_header import (
    FORMAT,
    HEADER,
    MOST_HEADER_BYTES,
    SCHEMA_VERSION,
    TENSORS,
    MapHeader,
    damaged,
    fault_of,
    is_map,
    read_header,
)
from mapping.map_segments import segment_name
from mapping.map_upgrade import FORMER_SCHEMA
from mapping.tensor_file import size_of, write_through
from vizbot.core.errors import MapError
from vizbot.core.files import require_folder
from vizbot.core.types import SE3, Intrinsics, OccupancyGrid

if TYPE_CHECKING:  # the protocol's module loads torch
    from mapping.clip.encoder import TextEncoder


@dataclass(frozen=True, slots=True, eq=False)
class MapBundle:
    """All that is saved of a run.

    Attributes:
        model_id: Of the encoder that made the elements.
        T_base_cam: Mount of the camera on the base.
        keyframes: What all else is anchored to.
        views: Corners of the keyframes.
        elements: The CLIP map.
        statistics: What each element has in common with the background phrases (N, 2), as of
            `Background.statistics`; None where that is not known.
        places: Views of places.
        frames: The frames that the elements and views of places are of.
        cloud: Coloured points, for display.
        created: When the run ended, UTC.
        notice: Warning that the encoder gives with its results; None for none.
        keep_out: Polygons (K, 2) of corners x, y in `map` [m] that the robot must not enter.
        pictures: The bank of pictures (B, D) as the encoder embeds it; `NO_PICTURES` where that is
            not known.
        calibration: Numbers of the belief that were fitted to the encoder; None for those that
            come along.
    """

    model_id: str
    intrinsics: Intrinsics
    T_base_cam: SE3
    keyframes: Keyframes
    views: KeyframeViews
    elements: ClipElements
    statistics: NDArray[np.float32] | None
    places: PlaceRows
    frames: MappedFrames
    grid: OccupancyGrid
    cloud: Cloud
    trajectory: Trajectory
    created: datetime = field(default_factory=lambda: datetime.now(UTC))
    notice: str | None = None
    keep_out: tuple[NDArray[np.float32], ...] = ()
    pictures: NDArray[np.float32] = field(default_factory=lambda: NO_PICTURES)
    calibration: EncoderCalibration | None = None

    def place_map(self) -> PlaceMap:
        """The views of places, to be placed and to go on with."""
        return PlaceMap(self.intrinsics, self.places, self.frames)

    def element_points(self) -> NDArray[np.float64]:
        """Points (N, 3) of the CLIP map's elements in `map` [m]."""
        elements = self.elements
        return points_in_map(elements.points_keyframe, elements.keyframes, self.keyframes.poses())

    def cloud_points(self) -> NDArray[np.float64]:
        """Points (P, 3) of the cloud in `map` [m]."""
        cloud = self.cloud
        return points_in_map(cloud.points_keyframe, cloud.keyframes, self.keyframes.poses())

    def final_poses(self) -> NDArray[np.float64]:
        """Ts_map_cam (F, 4, 4) of the frames after the last optimisation of the graph."""
        trajectory = self.trajectory
        return poses_in_map(
            trajectory.Ts_keyframe_cam, trajectory.keyframes, self.keyframes.poses()
        )


_NO_SHA256 = 64 * "0"
"""Stands for a checksum that is not known before the arrays are written."""
_GROUPS = {
    "keyframes": Keyframes,
    "views": KeyframeViews,
    "elements": ClipElements,
    "places": PlaceRows,
    "frames": MappedFrames,
    "cloud": Cloud,
    "trajectory": Trajectory,
}


def require_no_class(bundle: MapBundle) -> None:
    """Reject a map that names a class, which is code that runs: a person has to name that.

    Raises:
        MapError: the map names a class.
    """
    if is_class_name(bundle.model_id):
        raise MapError(
            f"this map was made with an encoder of somebody's own, {bundle.model_id}; if you trust"
            f" it, name it: --clip {bundle.model_id}"
        )


def require_encoder(bundle: MapBundle, encoder: TextEncoder) -> None:
    """Reject an encoder whose embeddings cannot be compared with the map's.

    Raises:
        MapError: another encoder made the map, or its embeddings have another length.
    """
    if encoder.model_id != bundle.model_id:
        require_no_class(bundle)
        raise MapError(
            f"the map's features are of {bundle.model_id!r}, not of {encoder.model_id!r}:"
            f" ask it with --clip {bundle.model_id}"
        )
    length = bundle.elements.embeddings.shape[1]
    if length != encoder.dimension:
        raise MapError(
            f"the map's embeddings have {length} numbers, those of {encoder.model_id!r}"
            f" {encoder.dimension}: build the map again"
        )


def with_background(
    bundle: MapBundle, encoder: TextEncoder, on_progress: OnProgress = lambda done, of: None
) -> MapBundle:
    """The map with its background, which is computed where the map has none.

    `on_progress` is called with the number of embedded pictures, where the bank is not kept.
    """
    if bundle.statistics is not None and len(bundle.pictures):
        return bundle
    background = Background.embedded_by(encoder, on_progress)
    statistics = background.statistics(bundle.elements.embeddings)
    return replace(bundle, statistics=statistics, pictures=background.pictures)


def require_map_folder(folder: Path) -> None:
    """Reject a folder that holds anything but a map; call it before the work that makes the map.

    Raises:
        MapError: `folder` is neither new, nor empty, nor a map.
    """
    try:
        real = real_folder(folder)
        new = not real.exists() and not real.is_symlink()  # as a loop of links is
        if new or not any(real.iterdir()) or is_map(real):
            return
    except OSError:
        pass  # a file, or a folder that cannot be read
    raise MapError(f"{folder} is not a map and is left alone: give another folder for the map")


def require_savable(folder: Path, *, replace: bool) -> None:
    """Reject a folder that a map cannot be saved in, before the work that makes the map.

    With `replace` it may hold a map already.

    Raises:
        MapError: it is neither new, nor empty, nor a map to be replaced, or it cannot be written.
    """
    require_map_folder(folder)
    real = real_folder(folder)
    is_there = previous_folder(real).exists() or (real.exists() and any(real.iterdir()))
    if is_there and not replace:
        raise MapError(
            f"{folder} is a map already: give another folder for it, or replace it with --force"
        )
    try:
        require_folder(real.parent if real.exists() else real)
    except OSError as error:
        raise unwritable(folder, error) from error


def require_growable(folder: Path) -> None:
    """Reject a map that a robot could not go on in for long: soon it would be too large to save.

    Raises:
        MapError: there is no map, its header is damaged, or it has nearly the size of the largest.
    """
    header = read_header(readable_folder(folder))
    size = header.tensors_size + sum(each.size for each in header.segments)
    if size > MOST_BYTES - GROWTH:
        raise MapError(
            f"the map {folder} has {size // 1_000_000} MB, and with more than"
            f" {MOST_BYTES // 1_000_000} MB it could not be saved: begin a new one, which a robot"
            " can go on in; `vizbot map query` still asks this one"
        )


def unwritable(folder: Path, error: OSError) -> MapError:
    """The error of a folder in which a map cannot be saved, in one line."""
    return MapError(f"cannot save the map {folder}: {error.strerror}; give another folder for it")


def require_outside_maps(path: Path) -> None:
    """Reject a file in the folder of a map, which holds the map's two files and nothing else.

    Raises:
        MapError: the file that is to be written would be there.
    """
    folder = real_folder(path).parent
    if (folder / HEADER).exists() and (folder / TENSORS).exists():
        raise MapError(f"{path} would be in the map {folder}; give a file outside of it")


def save(bundle: MapBundle, folder: Path) -> MapHeader:
    """Write a map; an old one in the folder is replaced once the new one is whole on disk.

    Returns:
        What `map.json` says of it.

    Raises:
        MapError: the folder holds something else, or cannot be written, or `load` would refuse the
            map; an old one is left as it is.
    """
    require_map_folder(folder)
    folder = real_folder(folder)
    try:
        header, arrays = _packed(bundle)
    except ValueError as error:
        fault = fault_of(error) if isinstance(error, ValidationError) else str(error)
        raise MapError(
            f"the map {folder} is not saved, since it could not be loaded again ({fault}): look at"
            " the camera's calibration, depth and stamps, and begin a new map"
        ) from error
    sizes = (header.tensors_size, MOST_BYTES), (len(header.content()), MOST_HEADER_BYTES)
    for size, most in sizes:
        if size > most:
            raise MapError(
                f"the map {folder} is not saved, it has {size} bytes, more than {most}:"
                " begin a new map"
            )
    partial = folder.with_name(f".{folder.name}.partial")
    previous = previous_folder(folder)
    try:
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir(parents=True)
        sha256 = write_through(partial / TENSORS, arrays)
        header = header.model_copy(update={"tensors_sha256": sha256})
        write_header(partial, header)
        sync_folder(partial)
        if folder.exists():
            shutil.rmtree(previous, ignore_errors=True)
            folder.rename(previous)
        partial.rename(folder)
        sync_folder(folder.parent)
        shutil.rmtree(previous, ignore_errors=True)
    except OSError as error:
        raise unwritable(folder, error) from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)
        if previous.exists() and not folder.exists():
            with suppress(OSError):  # `load` reads the previous map where it is
                previous.rename(folder)
    return header


def map_in(folder: Path) -> Path:
    """The folder of a map: itself, or `map` in it where it is the folder of a run."""
    in_run = folder / "map"
    holds = (in_run / HEADER).exists() or previous_folder(in_run).is_dir()
    return in_run if holds and not (folder / HEADER).exists() else folder


def load(folder: Path) -> MapBundle:
    """Read a map and check that it is whole.

    Where a program was killed while it replaced the map, the map before is read.

    Raises:
        MapError: there is no map, it has another schema, or it is damaged.
    """
    folder = readable_folder(folder)
    header = read_header(folder)
    try:
        arrays = read_arrays(
            [
                (folder / TENSORS, header.tensors_size, header.tensors_sha256),
                *(
                    (folder / segment_name(number), each.size, each.sha256)
                    for number, each in enumerate(header.segments, start=1)
                ),
            ],
            header.schema_version,
            header.created,
        )
        groups: dict[str, Any] = {
            group: kind(*(arrays[f"{group}.{column.name}"] for column in fields(kind)))
            for group, kind in _GROUPS.items()
        }
        poses = groups["keyframes"].poses()
        require_places_extent(places_of(groups["places"], poses))
        occupancy = arrays["grid.occupancy"]
        require_extent(
            groups["keyframes"].Ts_map_cam,
            occupancy.shape,
            header.grid_resolution,
            header.grid_origin,
        )
    except (OSError, ValueError, MemoryError) as error:
        raise damaged(folder, TENSORS, error) from error
    bundle = MapBundle(
        model_id=header.model_id,
        notice=header.notice,
        intrinsics=header.intrinsics,
        T_base_cam=np.array(header.T_base_cam),
        grid=OccupancyGrid(occupancy, header.grid_resolution, np.array(header.grid_origin)),
        created=header.created,
        keep_out=tuple(np.array(zone, np.float32) for zone in header.keep_out),
        statistics=_statistics(arrays, header),
        pictures=_pictures(arrays, header),
        calibration=header.calibration,
        **groups,
    )
    counts = _counts(bundle)
    if header.schema_version == FORMER_SCHEMA:
        del counts["frames"]
    if header.counts != counts:
        raise damaged(folder, HEADER, ValueError("its counts are not those of the arrays"))
    return bundle


def load_grid(folder: Path) -> OccupancyGrid:
    """Read the obstacle map of a saved map, with its zones, and nothing else of it.

    Raises:
        MapError: there is no map, it has another schema, or this part of it is damaged.
    """
    folder = readable_folder(folder)
    header = read_header(folder)
    try:
        newest, size = TENSORS, header.tensors_size
        if header.segments:
            newest, size = segment_name(len(header.segments)), header.segments[-1].size
        occupancy = read_array(folder / newest, size, "grid.occupancy", header.schema_version)
    except (OSError, ValueError, MemoryError) as error:
        raise damaged(folder, TENSORS, error) from error
    zones = tuple(np.array(zone, np.float32) for zone in header.keep_out)
    return OccupancyGrid(occupancy, header.grid_resolution, np.array(header.grid_origin), zones)


def _packed(bundle: MapBundle) -> tuple[MapHeader, dict[str, NDArray[Any]]]:
    """Contents of `map.json`, but for the checksum of the arrays, and of `map.safetensors`.

    Raises:
        ValueError: `load` would refuse them.
    """
    arrays = arrays_of(bundle)
    grid = bundle.grid
    require_arrays(arrays)
    require_places_extent(places_of(bundle.places, bundle.keyframes.poses()))
    require_extent(
        bundle.keyframes.Ts_map_cam, grid.occupancy.shape, grid.resolution, tuple(grid.origin)
    )
    return header_of(bundle, size_of(arrays)), arrays


def arrays_of(bundle: MapBundle) -> dict[str, NDArray[Any]]:
    """All arrays of a map, by group and column."""
    arrays = {
        f"{group}.{column.name}": np.ascontiguousarray(getattr(getattr(bundle, group), column.name))
        for group, kind in _GROUPS.items()
        for column in fields(kind)
    }
    statistics = NO_STATISTICS if bundle.statistics is None else bundle.statistics
    arrays["elements.statistics"] = np.ascontiguousarray(statistics)
    length = bundle.elements.embeddings.shape[1]
    pictures = bundle.pictures if len(bundle.pictures) else np.zeros((0, length), np.float32)
    arrays["elements.pictures"] = np.ascontiguousarray(pictures)
    arrays["grid.occupancy"] = np.ascontiguousarray(bundle.grid.occupancy)
    return arrays


def header_of(bundle: MapBundle, tensors_size: int) -> MapHeader:
    """What `map.json` says of a map whose arrays take `tensors_size` bytes, but for checksums."""
    return MapHeader(
        format=FORMAT,
        schema_version=SCHEMA_VERSION,
        created=bundle.created,
        model_id=bundle.model_id,
        notice=bundle.notice,
        intrinsics=bundle.intrinsics,
        T_base_cam=tuple(tuple(row) for row in bundle.T_base_cam.tolist()),
        grid_resolution=bundle.grid.resolution,
        grid_origin=tuple(bundle.grid.origin.tolist()),
        phrases_id=PHRASES_ID,
        pictures_id=PICTURES_ID,
        calibration=bundle.calibration,
        keep_out=tuple(tuple(map(tuple, zone.tolist())) for zone in bundle.keep_out),
        counts=_counts(bundle),
        tensors_size=tensors_size,
        tensors_sha256=_NO_SHA256,
    )


def _statistics(arrays: dict[str, NDArray[Any]], header: MapHeader) -> NDArray[np.float32] | None:
    """The elements' statistics; None where there are none over the phrases of today."""
    statistics: NDArray[np.float32] = arrays["elements.statistics"]
    whole = len(statistics) == len(arrays["elements.keyframes"])
    return statistics if whole and header.phrases_id == PHRASES_ID else None


def _pictures(arrays: dict[str, NDArray[Any]], header: MapHeader) -> NDArray[np.float32]:
    """The bank of pictures; none where it is not that of today."""
    pictures: NDArray[np.float32] = arrays["elements.pictures"]
    return pictures if len(pictures) and header.pictures_id == PICTURES_ID else NO_PICTURES


def write_header(folder: Path, header: MapHeader) -> None:
    """Write `map.json` to the disk.

    Raises:
        OSError: it cannot be written.
    """
    with (folder / HEADER).open("wb") as file:
        file.write(header.content())
        file.flush()
        os.fsync(file.fileno())


def _counts(bundle: MapBundle) -> dict[str, int]:
    return {
        "keyframes": len(bundle.keyframes.ids),
        "elements": len(bundle.elements.keyframes),
        "places": len(bundle.places),
        "frames": len(bundle.frames),
        "cloud": len(bundle.cloud.keyframes),
        "trajectory": len(bundle.trajectory.stamps),
    }
