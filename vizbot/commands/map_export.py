"""`vizbot map export`: maps in the formats of other programs."""

from __future__ import annotations

import io
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from mapping import map_bundle
from mapping.map_bundle import MapBundle
from mapping.tum import write_trajectory
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.files import require_folder, require_new, write_whole
from vizbot.core.geometry import invert
from vizbot.operator.printing import echo
from vizbot.operator.session.saved_maps import find_map

if TYPE_CHECKING:
    from mapping.clip.places.belief import PlaceBelief

Form = Literal["ply", "npz", "rrd", "nav2", "tum"]
CameraOrBase = Literal["camera", "base"]


@dataclass(frozen=True, slots=True)
class MapExport:
    """What is exported.

    Attributes:
        folder: Of the map, or its name.
        form: The format.
        out: The file, of the format `nav2` the folder.
        query: What the points of a `ply` are scored by; None for no scores.
        frame: Whose way a `tum` is.
        force: Whether a file that is there is replaced.
    """

    folder: Path
    form: str
    out: Path
    query: str | None = None
    frame: str = "camera"
    force: bool = False


def export(asked: MapExport) -> None:
    """Write a map in the format of another program.

    Raises:
        VizbotError: the map cannot be read, an option is unknown or not for the format, or the file
            is there, cannot be written or would lie in a map's folder.
    """
    if asked.form not in get_args(Form):
        raise ConfigError(f"unknown format {asked.form!r}; use {', '.join(get_args(Form))}")
    if asked.frame not in get_args(CameraOrBase):
        raise ConfigError(f"unknown --frame {asked.frame!r}; use camera or base")
    if asked.query is not None and asked.form != "ply":
        raise ConfigError(f"--query is for --format ply, not {asked.form}; leave it out")
    if asked.frame != "camera" and asked.form != "tum":
        raise ConfigError(f"--frame is for --format tum, not {asked.form}; leave it out")
    map_bundle.require_outside_maps(asked.out)
    if asked.form == "nav2":
        _require_free_folder(asked.out)
    else:
        require_new(asked.out, replace=asked.force)
    if asked.query is None:
        _write(asked, map_bundle.load(find_map(asked.folder)), None)
    else:
        from vizbot.operator.session.saved_map import SavedMap

        saved = SavedMap(asked.folder)
        if saved.encoder.notice:
            echo(saved.encoder.notice, err=True)
        belief = saved.belief(asked.query)
        _write(asked, saved.bundle, belief)
    echo(str(asked.out))


def _write(asked: MapExport, bundle: MapBundle, belief: PlaceBelief | None) -> None:
    match asked.form:
        case "ply":
            from mapping.ply import write_ply

            points = bundle.cloud_points()
            scores = None if belief is None else _probabilities(points, belief)
            write_ply(asked.out, points, bundle.cloud.rgb, scores)
        case "npz":
            write_whole(asked.out, _elements(bundle))
        case "rrd":
            write_whole(asked.out, _recording(bundle))
        case "nav2":
            _write_nav2(asked.out, bundle)
        case _:
            T_frame_cam = bundle.T_base_cam if asked.frame == "base" else np.eye(4)
            Ts_map_frame = bundle.final_poses() @ invert(T_frame_cam)
            write_trajectory(asked.out, bundle.trajectory.stamps, Ts_map_frame, asked.frame)


def _probabilities(points: NDArray[np.float64], belief: PlaceBelief) -> NDArray[np.float32]:
    """The probability (P,) of the place that each point (P, 3) is in; 0 where none was seen."""
    from mapping.clip.places.footprint import PLACE

    columns, rows = (np.floor(points[:, :2] / PLACE).astype(np.int64) - belief.low).T
    height, width = belief.probabilities.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    scores = np.zeros(len(points), np.float32)
    scores[inside] = belief.probabilities[rows[inside], columns[inside]]
    return scores


def _elements(bundle: MapBundle) -> bytes:
    """The elements as arrays of NumPy, in the order of the map."""
    elements, frames = bundle.elements, bundle.frames
    of = frames.rows_of(elements.frames)
    cameras = frames.Ts_map_cam(bundle.keyframes.poses())[:, :3, 3]
    content = io.BytesIO()
    np.savez_compressed(
        content,
        points=bundle.element_points(),
        embeddings=elements.embeddings,
        boxes=elements.boxes,
        patch_sizes=elements.boxes[:, 2] - elements.boxes[:, 0],
        frames=elements.frames,
        cameras=cameras[of],
        times=frames.times[of],
        model_id=np.array(bundle.model_id),
    )
    return content.getvalue()


def _recording(bundle: MapBundle) -> bytes:
    try:
        from vizbot.operator.viewer.map_recording import map_recording
    except ModuleNotFoundError as error:
        raise ConfigError("--format rrd needs rerun: pip install rerun-sdk") from error
    return map_recording(bundle)


def _require_free_folder(out: Path) -> None:
    """Refuse a folder that is not new or empty, or cannot be made.

    Raises:
        ConfigError: it is such a folder.
    """
    try:
        if out.exists() and any(out.iterdir()):
            raise ConfigError(f"{out} is not a new or empty folder; give another with --out")
        require_folder(out)
    except OSError as error:
        raise ConfigError(
            f"cannot write to {out}: {error.strerror}; give another folder with --out"
        ) from error


def _write_nav2(out: Path, bundle: MapBundle) -> None:
    """Write the files of Nav2 into a folder, which appears only when all of them are there.

    Raises:
        ConfigError: they cannot be written.
    """
    from dataclasses import replace

    from mapping.nav2 import nav2_files

    costmap = Config().navigator.costmap
    grid = replace(bundle.grid, zones=bundle.keep_out)
    partial = out.with_name(f".{out.name}.partial")
    try:
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir(parents=True)
        files = nav2_files(grid, costmap.free_threshold, costmap.occupied_threshold)
        for name, content in files.items():
            write_whole(partial / name, content)
        if out.exists():
            out.rmdir()
        partial.rename(out)
    except OSError as error:
        raise ConfigError(
            f"cannot write to {out}: {error.strerror}; give another folder with --out"
        ) from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)
