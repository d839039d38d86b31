"""Views of a home that are rendered and embedded once, and kept on the disk."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from mapping.clip.mapper import FrameElements
from mapping.clip.patches import embed_frame
from mapping.clip.places.footprint import Footprint, footprint
from mapping.occupancy.planar_scan import PlanarScan, flatten, level_pose
from sim_stubs.world.world import World
from vizbot.config import PerceptionConfig
from vizbot.core.files import write_whole
from vizbot.core.geometry import invert, planar, yaw_of
from vizbot.core.types import SE3, ImuSamples, RGBDFrame

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

log = logging.getLogger(__name__)

HEADINGS = 12
"""Headings of a place, a step's turn apart."""
FARTHEST = 5.5
"""Depth beyond which nothing is measured, as by the simulated camera [m]."""
_FILE = "views.safetensors"


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """What the maps take from one picture.

    Attributes:
        elements: Of the encoder, in 16 bits as they are kept.
        footprint: Which places its patches show.
        scan: What the obstacle map takes.
    """

    elements: FrameElements
    footprint: Footprint
    scan: PlanarScan


class Views:
    """The views of one home, made when they are asked for first."""

    def __init__(
        self, world: World, encoder: ClipEncoder, config: PerceptionConfig, folder: Path
    ) -> None:
        """Read the kept views, if there are some."""
        self.world, self._encoder, self._config = world, encoder, config
        self._path = folder / _FILE
        self._kept = _read(self._path)
        self.made = 0

    def view(self, xy: NDArray[np.float64], place: int, heading: int) -> View:
        """The view from a place.

        Args:
            xy: (2,) where the place is, in the world [m].
            place: Its number.
            heading: Number of its heading, 0 to `HEADINGS` - 1.
        """
        key = place * HEADINGS + heading
        if key not in self._kept:
            self._kept[key] = _rounded(self._make(xy, heading))
            self.made += 1
        return self._kept[key]

    def save(self) -> None:
        """Write all views, if there are new ones."""
        if self.made:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(self._path, _packed(self._kept))

    def _make(self, xy: NDArray[np.float64], heading: int) -> View:
        world, mapper = self.world, self._config.clip_mapper
        T_before, T_world_base = world.T_world_base, pose_of(xy, heading)
        x, y = xy.tolist()
        world.place(x, y, heading * 2 * np.pi / HEADINGS)  # where a true encoder looks from, too
        rgb, depth = world.render()
        depth = np.where(depth <= FARTHEST, depth, np.float32(0.0))
        frame = RGBDFrame(0.0, rgb, depth, world.intrinsics, ImuSamples.none())
        elements = embed_frame(frame, self._encoder, mapper)
        x, y = T_before[:2, 3].tolist()
        world.place(x, y, yaw_of(T_before))
        T_world_cam = T_world_base @ world.T_base_cam
        T_level_cam = invert(level_pose(T_world_cam)) @ T_world_cam
        scan = flatten(depth, world.intrinsics, T_level_cam, self._config.depth_mapper.scan)
        shown = footprint(depth, world.intrinsics, T_world_cam, elements.boxes)
        return View(elements, shown, scan)


def count_views(folder: Path) -> int:
    """Number of views that are kept in a folder."""
    return len(_read(folder / _FILE))


def pose_of(xy: NDArray[np.float64], heading: int) -> SE3:
    """T_world_base of the robot at a place (2,) [m] with the heading of this number."""
    x, y = xy.tolist()
    return planar(x, y, heading * 2 * np.pi / HEADINGS)


def _read(path: Path) -> dict[int, View]:
    """The views of a file; none where it is not there, or not what was written."""
    try:
        return _unpacked(path.read_bytes())
    except FileNotFoundError:
        return {}
    except (OSError, SafetensorError, KeyError, ValueError, IndexError) as error:
        log.info("the views in %s are taken anew: %s", path, error)
        return {}


def _unpacked(content: bytes) -> dict[int, View]:
    """The views of a file with this content."""
    arrays = load(content)
    ends, scan_ends = np.cumsum(arrays["counts"]), np.cumsum(arrays["scan_sizes"])
    place_ends = np.cumsum(arrays["place_counts"])
    packed = arrays["scans"].tobytes()
    views: dict[int, View] = {}
    for i, key in enumerate(arrays["keys"].tolist()):
        rows = slice(int(ends[i] - arrays["counts"][i]), int(ends[i]))
        places = slice(int(place_ends[i] - arrays["place_counts"][i]), int(place_ends[i]))
        first, *shape = arrays["scan_shapes"][i].tolist()
        inflated = packed[int(scan_ends[i] - arrays["scan_sizes"][i]) : int(scan_ends[i])]
        views[key] = View(
            FrameElements(
                arrays["points"][rows].astype(np.float64),
                arrays["embeddings"][rows].astype(np.float32),
                arrays["boxes"][rows],
            ),
            Footprint(
                arrays["place_points"][places], arrays["patches"][places], arrays["shares"][places]
            ),
            PlanarScan(first, (shape[0], shape[1]), inflated),
        )
    return views


def _packed(views: dict[int, View]) -> bytes:
    """The content of a file of views."""
    elements = [view.elements for view in views.values()]
    footprints = [view.footprint for view in views.values()]
    scans = [view.scan for view in views.values()]
    content: bytes = save(
        {
            "keys": np.array(list(views), np.int64),
            "counts": np.array([len(each.boxes) for each in elements], np.int64),
            "points": np.concatenate([each.points_cam for each in elements]).astype(np.float32),
            "embeddings": np.concatenate([e.embeddings for e in elements]).astype(np.float16),
            "boxes": np.concatenate([each.boxes for each in elements]),
            "place_counts": np.array([len(each.shares) for each in footprints], np.int64),
            "place_points": np.concatenate([each.points_cam for each in footprints]),
            "patches": np.concatenate([each.patches for each in footprints]),
            "shares": np.concatenate([each.shares for each in footprints]),
            "scan_shapes": np.array([(s.first_bearing, *s.shape) for s in scans], np.int64),
            "scan_sizes": np.array([len(scan.packed) for scan in scans], np.int64),
            "scans": np.frombuffer(b"".join(scan.packed for scan in scans), np.uint8),
        }
    )
    return content


def _rounded(view: View) -> View:
    """The view as it comes back from the disk, so that a second run is like the first."""
    return _unpacked(_packed({0: view}))[0]
