"""Frames in, maps out: pose estimator, depth mapper and CLIP mapper."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cache, partial
from math import radians
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.calibration.floor_level import estimate_mount
from mapping.clip.compaction import LEAST, ClipTables, is_due
from mapping.clip.fitted.encoder import calibration_of
from mapping.clip.growing_rows import GrowingRows
from mapping.clip.mapped_frames import MappedFrame
from mapping.clip.mapper import ClipMap, FrameElements
from mapping.clip.patches import embed_frame
from mapping.clip.placement import PlacedElements, Placement
from mapping.clip.places.belief import Belief, PlaceBelief
from mapping.clip.places.footprint import Footprint, footprint
from mapping.clip.places.place_rows import PlaceMap
from mapping.clip.places.view_age import LATER
from mapping.clip.scores import NO_PICTURES, NO_STATISTICS, Background
from mapping.map_bundle import MapBundle
from mapping.map_snapshot import MapSnapshot
from mapping.occupancy.depth_mapper import DepthMapper
from mapping.relocalisation.local_map import LocalMap
from mapping.slam.slam import Slam
from vizbot.config import PerceptionConfig
from vizbot.core.errors import DeviceError
from vizbot.core.geometry import back_project, camera_mount, invert, rotation_angle
from vizbot.core.interfaces import Clock, Pending
from vizbot.core.program.interrupts import holding_interrupts
from vizbot.core.types import SE3, OccupancyGrid, PoseEstimate, RGBDFrame, Tracking
from vizbot.perception.interfaces import PerceptionParts
from vizbot.perception.run_record import RunRecord
from vizbot.perception.sightings import Sightings

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder


log = logging.getLogger(__name__)

_OVEREXPOSED = 250
_LEAST_EXPOSED = 0.2
"""An image shows something when at least this share of it is not overexposed."""
_DISTANCE, _TURN = 0.1, radians(10.0)
"""Images taken closer together than this show the same [m, rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class _Embedded:
    """What the CLIP map takes from a frame.

    Attributes:
        elements: The frame's elements.
        statistics: (M, 2) statistics of the elements, as in `Background.statistics`.
        footprint: Places that the patches show.
    """

    elements: FrameElements
    statistics: NDArray[np.float32]
    footprint: Footprint


@dataclass(frozen=True, slots=True, eq=False)
class _Compacted:
    """The parts of a CLIP map that a compacted one replaces."""

    clip_map: ClipMap
    statistics: GrowingRows[np.float32]
    places: PlaceMap
    placement: Placement


class Perception:
    """The three maps of one run, all anchored to the keyframes of one pose graph.

    Attributes:
        places: The frames that were mapped so far, and the views of places that they gave.
        embedded: Number of frames whose embedding has begun.
        skipped: Number of frames that were left out because the encoder was still busy.
    """

    def __init__(
        self,
        first: RGBDFrame,
        T_base_cam: SE3 | None,
        encoder: ClipEncoder,
        clock: Clock,
        config: PerceptionConfig,
        parts: PerceptionParts | None = None,
        saved_map: MapBundle | None = None,
    ) -> None:
        """Begin the maps where the first frame is taken, or continue a saved map.

        Args:
            first: First frame, for intrinsics and, without a known mount, the floor. Pass it to
                `update`, too.
            T_base_cam: Where the camera sits; None estimates it from the first frame, and takes a
                level camera at 1.5 m where no floor is seen.
            encoder: Embeds the patches.
            clock: Runs the embedding beside the caller.
            config: Settings of the parts.
            parts: Parts that replace the built-in ones.
            saved_map: The map to continue, made with the same encoder. The robot is lost in it at
                first.

        Raises:
            MapError: the saved map has cells of another size.
        """
        if T_base_cam is None:
            T_base_cam = estimate_mount(first)
        self.T_base_cam = camera_mount(1.5, 0.0, 0.0) if T_base_cam is None else T_base_cam
        parts = parts or PerceptionParts()
        slam, depth_mapper = parts.slam, parts.depth_mapper
        if depth_mapper is None:
            depth_mapper = DepthMapper(
                config.depth_mapper, None if saved_map is None else saved_map.grid
            )
        self.depth_mapper = depth_mapper
        if slam is None:
            around = LocalMap(self.depth_mapper.grid, config.depth_mapper, config.local_map)
            slam = Slam(first.intrinsics, self.T_base_cam, config.slam, around)
            if saved_map is not None:
                slam.start_in_map(saved_map.keyframes, saved_map.views)
        self.slam = slam
        self.clip_map = ClipMap(
            encoder.dimension, None if saved_map is None else saved_map.elements
        )
        self.places = PlaceMap(first.intrinsics) if saved_map is None else saved_map.place_map()
        background = parts.background or cache(partial(Background.embedded_by, encoder))
        statistics, self._pictures = NO_STATISTICS, NO_PICTURES
        if saved_map is not None and saved_map.statistics is not None and len(saved_map.pictures):
            statistics, self._pictures = saved_map.statistics, saved_map.pictures
        elif len(self.clip_map):
            statistics = background().statistics(self.clip_map.embeddings)
            self._pictures = background().pictures
        self._statistics = GrowingRows(statistics)
        self._placement = Placement()
        self._encoder, self._background = encoder, background
        self._patch_spreads, self._every_picture = parts.patch_spreads, parts.every_picture
        self._clock = clock
        self._config = config
        self._intrinsics = first.intrinsics
        self._record = RunRecord(every_pose=parts.every_pose)
        newest = -np.inf
        if saved_map is not None:
            self._record = RunRecord.going_on(
                saved_map.trajectory,
                saved_map.cloud,
                saved_map.keyframes,
                before=first.stamp,
                frames=int(saved_map.frames.numbers.max(initial=-1)) + 1,
                every_pose=parts.every_pose,
            )
            newest = float(saved_map.frames.times.max(initial=newest))
        # A later run counts as one also where the computer's clock was set back.
        self._began = max(datetime.now(UTC).timestamp(), newest + LATER) - first.stamp
        self._embedding: tuple[MappedFrame, SE3, Pending[_Embedded]] | None = None
        self._compacting: tuple[ClipTables, Pending[_Compacted]] | None = None
        self._T_map_embedded: SE3 | None = None
        self._encoder_fails = False
        self.embedded = self.skipped = self._mapped_since = 0

    def update(
        self, frame: RGBDFrame, T_odom_base: SE3 | None, *, lifted: bool = False
    ) -> PoseEstimate:
        """Add one frame to the poses and the obstacle map; an interrupt takes effect afterwards.

        A frame whose pose is unknown does not enter the obstacle map.

        `frame` is newer than all before it; `T_odom_base` is by the wheels, None without a base;
        `lifted`: the robot hangs in the air.
        """
        with holding_interrupts():
            if lifted and self._record.frames:
                estimate = self.slam.lift(frame.stamp)
            else:
                estimate = self.slam.track(frame, T_odom_base)
            self._record.add(estimate)
            if estimate.tracking is not Tracking.LOST:
                self.depth_mapper.integrate(
                    estimate.keyframe,
                    estimate.T_keyframe_cam,
                    estimate.T_map_cam,
                    frame.depth,
                    frame.intrinsics,
                )
                if estimate.is_keyframe:
                    self._add_to_cloud(estimate, frame)
            self.depth_mapper.follow(self.slam.keyframe_poses())
        return estimate

    @property
    def frame(self) -> int:
        """Index of the newest frame."""
        return self._record.frames - 1

    def finish(self) -> None:
        """Wait for the embedding that is still under way."""
        if self._embedding is not None:
            self._clock.sleep(self._config.embedding_latency)
            self._collect(wait=True)

    def grid(self) -> OccupancyGrid:
        """The present obstacle map."""
        return self.depth_mapper.grid()

    def points(self) -> NDArray[np.float64]:
        """Elements of the CLIP map (N, 3) in `map` [m], by the latest poses of the keyframes."""
        return self._placed().points

    @property
    def statistics(self) -> NDArray[np.float32]:
        """What each element of the CLIP map has in common with the background phrases (N, 2)."""
        return self._statistics.rows

    @property
    def pictures(self) -> NDArray[np.float32]:
        """The bank of pictures (B, D) as the encoder embeds it; none before the first element."""
        return self._pictures

    def believe(self, belief: Belief) -> PlaceBelief:
        """Update a belief, which may have followed this map before, and return what is believed."""
        placed = self.places.placed(self.slam.keyframe_poses())
        return belief.update(
            self.clip_map.embeddings, self.statistics, self.pictures, self.places.rows, placed
        )

    def sightings(self, similarities: NDArray[np.float32]) -> Sightings:
        """The elements of the CLIP map with their similarities (N,) to a goal."""
        placed = self._placed()
        return Sightings(placed.points, similarities, placed.seen_from)

    def _placed(self) -> PlacedElements:
        return self._placement.place(
            self.clip_map.elements, self.places.frames, self.slam.keyframe_poses()
        )

    def snapshot(self) -> MapSnapshot:
        """Everything worth saving, as it is now; it takes the same time however much there is."""
        return MapSnapshot(
            model_id=self._encoder.model_id,
            intrinsics=self._intrinsics,
            T_base_cam=self.T_base_cam,
            keyframe_poses=self.slam.keyframe_poses(),
            keyframe_stamps=self._record.keyframe_stamps,
            features=self.slam.features(),
            elements=self.clip_map.elements,
            statistics=self.statistics,
            pictures=self.pictures,
            places=self.places.rows,
            frames=self.places.frames,
            grid=self.grid(),
            cloud=self._record.cloud,
            trajectory=self._record.trajectory,
            notice=self._encoder.notice,
            calibration=calibration_of(self._encoder),
        )

    def bundle(self) -> MapBundle:
        """Everything worth saving, joined here and now."""
        return self.snapshot().bundle()

    def embed(self, frame: RGBDFrame, estimate: PoseEstimate, *, standing: bool = False) -> None:
        """Add the newest frame to the CLIP map, if its pose is known and the encoder is free.

        `frame` is what `update` had last. A frame whose view is not new shows nothing new and is
        left out, so that the map does not grow. Where every picture is wanted, only one from where
        the previous one was taken is left out, while the robot waits, `standing`.
        """
        # Not with every frame: a simulated clock waits here for an encoder that is slower.
        self._collect()
        self._compact()
        if estimate.tracking is Tracking.LOST:
            return
        T_map_cam, taken = estimate.T_map_cam, self._began + frame.stamp
        if self._every_picture:
            if standing and not _shows_more(self._T_map_embedded, T_map_cam):
                return
        elif not self.places.is_new_view(T_map_cam, taken):
            return
        if not _shows_something(frame.rgb):
            log.info("a picture that is burnt out is not mapped")
            return
        if self._embedding is not None:
            self.skipped += 1
            return
        self.embedded += 1
        pending = self._clock.start(
            lambda: self._embedded_of(frame, T_map_cam), self._config.embedding_latency
        )
        mapped = MappedFrame(self.frame, estimate.keyframe, estimate.T_keyframe_cam, taken)
        self._embedding = (mapped, T_map_cam, pending)
        self._collect()

    def _embedded_of(self, frame: RGBDFrame, T_map_cam: SE3) -> _Embedded:
        """Embed a frame that was taken at `T_map_cam`."""
        elements = embed_frame(frame, self._encoder, self._config.clip_mapper, self._patch_spreads)
        shown = footprint(frame.depth, frame.intrinsics, T_map_cam, elements.boxes)
        return _Embedded(elements, self._background().statistics(elements.embeddings), shown)

    def _collect(self, wait: bool = False) -> None:
        if self._embedding is None:
            return
        frame, T_map_cam, pending = self._embedding
        if wait or pending.ready():
            self._embedding = None
            try:
                embedded = pending.result()
            except DeviceError as error:
                self._log_encoder(error)
                return
            self._log_encoder(None)
            with holding_interrupts():  # else the parts of the map would not fit together
                self._add(embedded, frame, T_map_cam)
            self._T_map_embedded = T_map_cam

    def _add(self, embedded: _Embedded, frame: MappedFrame, T_map_cam: SE3) -> None:
        """Add what was embedded of a frame that was taken at `T_map_cam`."""
        is_new = self.places.is_new_view(T_map_cam, frame.time)
        shown = embedded.footprint if is_new else Footprint.nothing()
        if len(shown.shares) == 0 and not self._every_picture:
            return
        self.places.add(frame, T_map_cam, shown, first_element=len(self.clip_map))
        self.clip_map.add(frame, embedded.elements)
        self._mapped_since += 1
        self._statistics.add(embedded.statistics)
        self._pictures = self._background().pictures

    def _compact(self) -> None:
        """Begin to compact the map where that is due; take the compacted one when it is ready."""
        if self._compacting is not None:
            before, pending = self._compacting
            if not pending.ready():
                return
            self._compacting = None
            added, compacted = self._tables().since(before), pending.result()
            with holding_interrupts():  # else the parts of the map would not fit together
                self._take(compacted, added)
        elif not self._every_picture and self._mapped_since >= LEAST:
            self._mapped_since = 0
            poses = self.slam.keyframe_poses()
            retaken, tables = self.places.retaken_frames(poses), self._tables()
            if is_due(len(retaken), len(tables.frames)):
                pending = self._clock.start(lambda: self._compacted(tables, retaken, poses), 0.0)
                self._compacting = tables, pending

    def _tables(self) -> ClipTables:
        places = self.places
        return ClipTables(self.clip_map.elements, self.statistics, places.rows, places.frames)

    def _compacted(
        self, tables: ClipTables, retaken: NDArray[np.int32], keyframe_poses: Mapping[int, SE3]
    ) -> _Compacted:
        """The map without the frames of these numbers (M,), with all that takes long done."""
        kept = tables.without(retaken)
        places = self.places.compacted(kept.places, kept.frames)
        places.placed(keyframe_poses)
        placement = Placement()
        placement.place(kept.elements, kept.frames, keyframe_poses)
        clip_map = ClipMap(self._encoder.dimension, kept.elements)
        return _Compacted(clip_map, GrowingRows(kept.statistics), places, placement)

    def _take(self, compacted: _Compacted, added: ClipTables) -> None:
        """Take a compacted map, with what was added to the other one meanwhile."""
        first = np.int32(len(compacted.clip_map))
        compacted.clip_map.add_rows(added.elements)
        compacted.statistics.add(added.statistics)
        rows = replace(added.places, elements=added.places.elements + first)
        compacted.places.add_rows(rows, added.frames)
        self.clip_map, self.places = compacted.clip_map, compacted.places
        self._statistics, self._placement = compacted.statistics, compacted.placement

    def _log_encoder(self, error: DeviceError | None) -> None:
        """Log when the encoder begins to fail, which leaves frames unmapped, and when it works."""
        if error is not None and not self._encoder_fails:
            log.warning("%s; going on without its answers", error)
        elif error is None and self._encoder_fails:
            log.warning("the encoder works again")
        self._encoder_fails = error is not None

    def _add_to_cloud(self, estimate: PoseEstimate, frame: RGBDFrame) -> None:
        stride = self._config.cloud_stride
        points = back_project(frame.depth, frame.intrinsics)[::stride, ::stride].reshape(-1, 3)
        rgb = frame.rgb[::stride, ::stride].reshape(-1, 3)
        near = (points[:, 2] > 0.0) & (points[:, 2] < self._config.cloud_range)
        self._record.add_points(estimate.keyframe, estimate.T_map_cam, points[near], rgb[near])

    def base_of(self, estimate: PoseEstimate) -> SE3:
        """T_map_base at an estimate."""
        return estimate.T_map_cam @ invert(self.T_base_cam)


def _shows_something(rgb: NDArray[np.uint8]) -> bool:
    """Whether an image (H, W, 3) is not overexposed nearly everywhere, as by the sun."""
    return bool((rgb[::8, ::8] < _OVEREXPOSED).any(axis=2).mean() >= _LEAST_EXPOSED)


def _shows_more(T_map_previous: SE3 | None, T_map_cam: SE3) -> bool:
    """Whether an image is from elsewhere than the previous one; a first image is."""
    if T_map_previous is None:
        return True
    T_previous_cam = invert(T_map_previous) @ T_map_cam
    moved = float(np.linalg.norm(T_previous_cam[:3, 3]))
    return moved > _DISTANCE or rotation_angle(T_previous_cam) > _TURN
