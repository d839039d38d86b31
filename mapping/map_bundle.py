"""A saved map: the result of a run, to be queried, shown and driven in later.

It is a folder with `map.json` (metadata, the encoder's id, checksums) and `map.safetensors` (the
arrays). Points and frames are anchored to keyframes, whose poses alone give theirs in `map`.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from contextlib import suppress
from dataclasses import dataclass, field, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import safetensors.numpy
from numpy.typing import NDArray
from pydantic import BaseModel, Field, ValidationError
from safetensors import SafetensorError

from mapping.clip.mapper import ClipElements
from mapping.keyframes.anchors import (
    Cloud,
    Keyframes,
    KeyframeViews,
    Trajectory,
    points_in_map,
    poses_in_map,
)
from vizbot.core.errors import MapError
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, Intrinsics, OccupancyGrid

if TYPE_CHECKING:  # the protocol's module loads torch
    from mapping.clip.encoder import ClipEncoder

FORMAT = "vizbot map"
SCHEMA_VERSION = 2
_REMEDY = "`vizbot map build SEQ --out MAP` makes one"
HEADER, TENSORS = "map.json", "map.safetensors"


@dataclass(frozen=True, slots=True, eq=False)
class MapBundle:
    """All that is saved of a run.

    Attributes:
        model_id: Of the encoder that made the elements.
        intrinsics: Of the camera.
        T_base_cam: Mount of the camera on the base.
        keyframes: What all else is anchored to.
        views: Corners of the keyframes.
        elements: The CLIP map.
        grid: The obstacle map.
        cloud: Coloured points, for display.
        trajectory: Of the camera.
        created: When the run ended, UTC.
        notice: Warning that the encoder gives with its results; None for none.
        keep_out: Polygons (K, 2) of corners x, y in `map` [m] that the robot must not enter.
    """

    model_id: str
    intrinsics: Intrinsics
    T_base_cam: SE3
    keyframes: Keyframes
    views: KeyframeViews
    elements: ClipElements
    grid: OccupancyGrid
    cloud: Cloud
    trajectory: Trajectory
    created: datetime = field(default_factory=lambda: datetime.now(UTC))
    notice: str | None = None
    keep_out: tuple[NDArray[np.float32], ...] = ()

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


_GROUPS = {
    "keyframes": Keyframes,
    "views": KeyframeViews,
    "elements": ClipElements,
    "cloud": Cloud,
    "trajectory": Trajectory,
}
_Row = tuple[float, float, float, float]


class _Header(BaseModel):
    model_config = SETTINGS

    format: str
    schema_version: int
    created: datetime
    model_id: str
    notice: str | None = None  # older maps have none
    intrinsics: Intrinsics
    T_base_cam: tuple[_Row, _Row, _Row, _Row]
    grid_resolution: float = Field(gt=0.0)
    grid_origin: tuple[float, float]
    keep_out: tuple[Annotated[tuple[tuple[float, float], ...], Field(min_length=3)], ...] = ()
    counts: dict[str, int]
    """Number of rows of each group, for readers of this file alone."""
    tensors_size: int
    tensors_sha256: str


def require_encoder(bundle: MapBundle, encoder: ClipEncoder) -> None:
    """Reject an encoder whose embeddings cannot be compared with the map's.

    Raises:
        MapError: another encoder made the map.
    """
    if encoder.model_id != bundle.model_id:
        raise MapError(
            f"the map's features are of {bundle.model_id!r}, not of {encoder.model_id!r}:"
            f" ask it with --clip {bundle.model_id}"
        )


def require_map_folder(folder: Path) -> None:
    """Reject a folder that holds anything but a map; call it before the work that makes the map.

    Raises:
        MapError: `folder` is neither new, nor empty, nor a map.
    """
    try:
        if not folder.exists() or not any(folder.iterdir()) or _is_map(folder):
            return
    except OSError:
        pass  # a file, or a folder that cannot be read
    raise MapError(f"{folder} is not a map and is left alone: give another folder for the map")


def save(bundle: MapBundle, folder: Path) -> None:
    """Write a map; an old one in the folder is replaced once the new one is whole on disk.

    Raises:
        MapError: the folder holds something else, or cannot be written.
    """
    require_map_folder(folder)
    folder = folder.resolve()
    partial = folder.with_name(f".{folder.name}.partial")
    previous = _previous(folder)
    try:
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir(parents=True)
        _write(bundle, partial)
        if folder.exists():
            shutil.rmtree(previous, ignore_errors=True)
            folder.rename(previous)
        partial.rename(folder)
        _sync(folder.parent)
        shutil.rmtree(previous, ignore_errors=True)
    except OSError as error:
        raise MapError(
            f"cannot save the map {folder}: {error.strerror}; give a folder on another disk"
        ) from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)
        if previous.exists() and not folder.exists():
            with suppress(OSError):  # `load` names the previous map
                previous.rename(folder)


def load(folder: Path) -> MapBundle:
    """Read a map and check that it is whole.

    Raises:
        MapError: there is no map, it has another schema, or it is damaged.
    """
    if not folder.is_dir():
        previous = _previous(folder.resolve())
        remedy = f"rename {previous}, the one before" if previous.exists() else _REMEDY
        raise MapError(f"no map at {folder}: {remedy}")
    header = _read_header(folder)
    try:
        tensors = (folder / TENSORS).read_bytes()
        if len(tensors) != header.tensors_size or _sha256(tensors) != header.tensors_sha256:
            raise ValueError("size or checksum")
        arrays = safetensors.numpy.load(tensors)
        groups: dict[str, Any] = {
            group: kind(*(arrays[f"{group}.{column.name}"] for column in fields(kind)))
            for group, kind in _GROUPS.items()
        }
        occupancy = arrays["grid.occupancy"]
    except (OSError, ValueError, KeyError, SafetensorError) as error:
        raise MapError(f"the map {folder} is damaged ({TENSORS}): build it again") from error
    return MapBundle(
        model_id=header.model_id,
        notice=header.notice,
        intrinsics=header.intrinsics,
        T_base_cam=np.array(header.T_base_cam),
        grid=OccupancyGrid(occupancy, header.grid_resolution, np.array(header.grid_origin)),
        created=header.created,
        keep_out=tuple(np.array(zone, np.float32) for zone in header.keep_out),
        **groups,
    )


def _read_header(folder: Path) -> _Header:
    try:
        content = (folder / HEADER).read_bytes()
        raw = json.loads(content)
    except FileNotFoundError as error:
        raise MapError(f"{folder} is not a map, it has no {HEADER}: {_REMEDY}") from error
    except (OSError, ValueError) as error:
        raise MapError(f"the map {folder} is damaged ({HEADER}): build it again") from error
    if not isinstance(raw, dict) or raw.get("format") != FORMAT:
        raise MapError(f"{folder} is not a map but has a {HEADER} of another program: {_REMEDY}")
    if raw.get("schema_version") != SCHEMA_VERSION:
        raise MapError(
            f"the map {folder} is of schema {raw.get('schema_version')!r},"
            f" not {SCHEMA_VERSION}: build it again"
        )
    try:
        return _Header.model_validate_json(content)
    except ValidationError as error:
        raise MapError(f"the map {folder} is damaged ({HEADER}): build it again") from error


def _write(bundle: MapBundle, folder: Path) -> None:
    arrays = {
        f"{group}.{column.name}": np.ascontiguousarray(getattr(getattr(bundle, group), column.name))
        for group, kind in _GROUPS.items()
        for column in fields(kind)
    }
    arrays["grid.occupancy"] = np.ascontiguousarray(bundle.grid.occupancy)
    tensors = safetensors.numpy.save(arrays)
    header = _Header(
        format=FORMAT,
        schema_version=SCHEMA_VERSION,
        created=bundle.created,
        model_id=bundle.model_id,
        notice=bundle.notice,
        intrinsics=bundle.intrinsics,
        T_base_cam=tuple(tuple(row) for row in bundle.T_base_cam.tolist()),
        grid_resolution=bundle.grid.resolution,
        grid_origin=tuple(bundle.grid.origin.tolist()),
        keep_out=tuple(tuple(map(tuple, zone.tolist())) for zone in bundle.keep_out),
        counts={
            "keyframes": len(bundle.keyframes.ids),
            "elements": len(bundle.elements.keyframes),
            "cloud": len(bundle.cloud.keyframes),
            "trajectory": len(bundle.trajectory.stamps),
        },
        tensors_size=len(tensors),
        tensors_sha256=_sha256(tensors),
    )
    _write_through(folder / TENSORS, tensors)
    _write_through(folder / HEADER, header.model_dump_json(indent=2).encode())
    _sync(folder)


def _write_through(path: Path, content: bytes) -> None:
    with path.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _sync(folder: Path) -> None:
    """Flush a folder, so that new and renamed files in it survive a power cut."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _is_map(folder: Path) -> bool:
    """Whether a folder holds a map of any schema and nothing else."""
    if {path.name for path in folder.iterdir()} - {HEADER, TENSORS}:
        return False
    try:
        header = json.loads((folder / HEADER).read_bytes())
    except ValueError:
        return False
    return isinstance(header, dict) and header.get("format") == FORMAT


def _previous(folder: Path) -> Path:
    """Where the previous map is kept while a new one replaces it."""
    return folder.with_name(f".{folder.name}.previous")
