"""`map.json` of a saved map: what it is of, and the checksums of itself and of the arrays."""

from __future__ import annotations

import hashlib
import json
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AfterValidator, Field, ValidationError, field_validator, model_validator

from mapping.clip.fitted.calibration import LIST_OF_VIEWS, EncoderCalibration
from mapping.map_arrays import FARTHEST, is_rigid
from mapping.map_segments import MOST_SEGMENTS, Segment, is_segment_name
from mapping.map_upgrade import FORMER_SCHEMA
from vizbot.core.camera_limits import require_camera
from vizbot.core.errors import MapError
from vizbot.core.files import parse_json, read_regular
from vizbot.core.settings import Settings, causes
from vizbot.core.types import Intrinsics

FORMAT = "vizbot map"
SCHEMA_VERSION = 6
REMEDY = "`vizbot map build SEQ --out MAP` makes one"
HEADER, TENSORS = "map.json", "map.safetensors"

MOST_HEADER_BYTES = 4 << 20
_FARTHEST_MOUNT = 100.0
_Row = tuple[float, float, float, float]
_Coordinate = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
_Line = Annotated[str, AfterValidator(lambda text: " ".join(text.split()))]
"""A text that is printed as a line: what a stranger writes into it makes no second one."""
_Zone = Annotated[tuple[tuple[_Coordinate, _Coordinate], ...], Field(min_length=3, max_length=1000)]


class MapHeader(Settings):
    """Content of `map.json`."""

    format: str
    schema_version: int
    created: datetime
    model_id: _Line = Field(min_length=1, max_length=1000)
    notice: _Line | None = Field(default=None, max_length=10_000)
    intrinsics: Intrinsics
    T_base_cam: tuple[_Row, _Row, _Row, _Row]
    grid_resolution: float = Field(ge=0.001, le=10.0)
    grid_origin: tuple[_Coordinate, _Coordinate]
    phrases_id: str | None = Field(default=None, max_length=100)
    """Of the background phrases that the elements' statistics are over."""
    pictures_id: str | None = Field(default=None, max_length=100)
    """Of the bank of pictures that is embedded in the map."""
    calibration: EncoderCalibration | None = None
    """Numbers of the belief that were fitted to the encoder; None for those that come along. The
    file has them only where they are fitted."""
    keep_out: tuple[_Zone, ...] = Field(default=(), max_length=1000)
    counts: dict[str, int]
    """Number of rows of each group, for readers of this file alone."""
    tensors_size: int
    tensors_sha256: str
    segments: tuple[Segment, ...] = Field(default=(), max_length=MOST_SEGMENTS)
    """Of what a running robot has added; the file has them only where there are some."""
    header_sha256: str | None = None
    """Of the rest of this file as JSON with sorted keys; None before it is written."""

    @field_validator("calibration", mode="before")
    @classmethod
    def _of_this_list(cls, raw: Any) -> Any:
        """Numbers of another list of views count as none: the map is as good without them."""
        views = raw.get("views") if isinstance(raw, dict) else None
        return None if isinstance(views, int) and views != LIST_OF_VIEWS else raw

    @model_validator(mode="after")
    def _physical(self) -> Self:
        require_camera(self.intrinsics)
        T_base_cam = np.array(self.T_base_cam)
        if not is_rigid(T_base_cam[None]) or np.abs(T_base_cam[:3, 3]).max() > _FARTHEST_MOUNT:
            raise ValueError("T_base_cam is not the mount of a camera")
        return self

    def content(self) -> bytes:
        """The file's content, with its checksum."""
        optional = {"calibration": self.calibration, "segments": self.segments}
        absent = {"header_sha256", *(name for name, value in optional.items() if not value)}
        raw = self.model_dump(mode="json", exclude=absent)
        return json.dumps(raw | {"header_sha256": _checksum(raw)}, indent=2).encode()


def read_header(folder: Path) -> MapHeader:
    """Read and check `map.json` of a map.

    Raises:
        MapError: the folder is not a map, or the file is of another schema or damaged.
    """
    try:
        raw = _read_json(folder)
    except FileNotFoundError as error:
        raise MapError(f"{folder} is not a map, it has no {HEADER}: {REMEDY}") from error
    except (OSError, ValueError) as error:
        raise damaged(folder, HEADER, error) from error
    if not isinstance(raw, dict) or raw.get("format") != FORMAT:
        raise MapError(f"{folder} is not a map but has a {HEADER} of another program: {REMEDY}")
    version = raw.get("schema_version")
    if version not in (SCHEMA_VERSION, FORMER_SCHEMA):
        raise MapError(
            f"the map {folder} is of schema {repr(version)[:40]}, not {SCHEMA_VERSION} or"
            f" {FORMER_SCHEMA}: build it again"
        )
    try:
        _require_checksum(raw)
        return MapHeader.model_validate(raw)
    except ValidationError as error:
        for wrong in error.errors(include_url=False):
            if wrong["type"] == "extra_forbidden":
                field = ".".join(map(str, wrong["loc"]))
                raise MapError(
                    f"the map {folder} is of another vizbot, its {HEADER} has {repr(field)[:80]}:"
                    " open it with that one, or build it again"
                ) from error
        raise damaged(folder, HEADER, ValueError(fault_of(error))) from error
    except (ValueError, OverflowError) as error:
        raise damaged(folder, HEADER, error) from error


def fault_of(error: ValidationError) -> str:
    """What is wrong with a header, in a few words."""
    first = causes(error.errors(include_url=False))[0]
    where = ".".join(map(str, first["loc"]))[:80]
    return f"{where} {first['msg']}".strip()


def is_map_file(name: str) -> bool:
    """Whether a file of this name belongs to a map."""
    return name in (HEADER, TENSORS) or is_segment_name(name)


def is_map(folder: Path) -> bool:
    """Whether a folder holds a map of any schema and nothing else.

    Raises:
        OSError: the folder cannot be read.
    """
    if not all(is_map_file(path.name) for path in folder.iterdir()):
        return False
    try:
        raw = _read_json(folder)
    except (OSError, ValueError):
        return False
    return isinstance(raw, dict) and raw.get("format") == FORMAT


def damaged(folder: Path, name: str, error: Exception) -> MapError:
    """The error that says in one line which file of a map is damaged, and by what."""
    reason = (isinstance(error, OSError) and error.strerror) or str(error)
    return MapError(f"the map {folder} is damaged ({name}: {reason}): build it again")


def _read_json(folder: Path) -> Any:
    """Parse `map.json`.

    Raises:
        OSError: it cannot be read, or is no file of that size.
        ValueError: it is not JSON, or nested too deep.
    """
    return parse_json(read_regular(folder / HEADER, MOST_HEADER_BYTES))


def _require_checksum(raw: dict[str, Any]) -> None:
    rest = {key: value for key, value in raw.items() if key != "header_sha256"}
    if raw.get("header_sha256") != _checksum(rest):
        raise ValueError("it has another checksum")


def _checksum(raw: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(raw, sort_keys=True).encode()).hexdigest()
