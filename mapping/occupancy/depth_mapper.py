"""DepthMapper of the paper (section C, Algorithm 1): a 2D obstacle map from depth and poses.

Every frame becomes a planar scan, which is painted into a grid of log odds and stored, anchored to
its keyframe; where keyframes moved with the graph, the grid is painted again from the scans. A
newer scan replaces the one of the same keyframe and place, so that memory grows with the home and
not with time. Contacts of the bumper are stored apart, so that a camera that cannot see them
(glass, a thin leg) does not clear them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.occupancy.config import DepthMapperConfig
from mapping.occupancy.log_odds_grid import LogOddsGrid
from mapping.occupancy.planar_scan import PlanarScan, flatten, level_pose, scan_of_obstacles
from vizbot.core.errors import MapError
from vizbot.core.geometry import invert, planar, transform, yaw_of
from vizbot.core.types import SE3, Intrinsics, OccupancyGrid

_INFERRED_SIGHTINGS = 2
"""Number of near views of an obstacle that make its cell occupied; an inferred one counts as
much."""


@dataclass(frozen=True, slots=True, eq=False)
class _AnchoredScan:
    keyframe: int | None
    T_keyframe_level: SE3
    scan: PlanarScan
    sightings: int


@dataclass(frozen=True, slots=True, eq=False)
class _Footprint:
    keyframe: int | None
    p_keyframe: NDArray[np.float64]
    radius: float


@dataclass(frozen=True, slots=True, eq=False)
class _Contact:
    keyframe: int | None
    p_keyframe: NDArray[np.float64]
    touched: bool = False


def require_resolution(saved: OccupancyGrid, config: DepthMapperConfig) -> None:
    """Reject a saved map whose cells have another size.

    Raises:
        MapError: the cells have another size.
    """
    if not np.isclose(saved.resolution, config.resolution):
        raise MapError(
            f"the map's cells are {saved.resolution:g} m wide, those of the robot"
            f" {config.resolution:g} m: set perception.depth_mapper.resolution to"
            f" {saved.resolution:g}"
        )


def _contacts_of(saved: OccupancyGrid) -> list[_Contact]:
    """Contacts of the bumper: depth alone never brings a cell to an occupancy of 1."""
    touched = saved.to_xy(np.argwhere(saved.occupancy == 1.0))
    return [_Contact(None, np.array([x, y, 0.0])) for x, y in touched]


class DepthMapper:
    """The obstacle map as it grows; `map` has its floor at z = 0."""

    def __init__(self, config: DepthMapperConfig, saved: OccupancyGrid | None = None) -> None:
        """Start empty, or in a saved map, which moves with no keyframe.

        Raises:
            MapError: its cells have another size.
        """
        if saved is not None:
            require_resolution(saved, config)
        self._config = config
        bounds = config.min_odds, config.max_odds
        self._grid = LogOddsGrid(config.resolution, bounds, saved)
        self._odds = np.array(
            [0.0, config.passed_odds, config.drop_odds, config.floor_odds, config.obstacle_odds]
        )
        self._evidence: dict[tuple[int | None, ...], _AnchoredScan | _Footprint] = {}
        self._contacts: list[_Contact] = [] if saved is None else _contacts_of(saved)
        self._painted_at: dict[int, SE3] = {}
        self._newest: int | None = None

    @property
    def scans(self) -> int:
        """Number of stored scans."""
        return sum(isinstance(item, _AnchoredScan) for item in self._evidence.values())

    def integrate(
        self,
        keyframe: int,
        T_keyframe_cam: SE3,
        T_map_cam: SE3,
        depth: NDArray[np.float32],
        intrinsics: Intrinsics,
    ) -> None:
        """Add a depth image (H, W) [m], 0 where nothing was measured.

        `T_keyframe_cam` is the camera in that of its keyframe; `T_map_cam` has heights above the
        floor.
        """
        T_map_level = level_pose(T_map_cam)
        T_level_cam = invert(T_map_level) @ T_map_cam
        scan = flatten(depth, intrinsics, T_level_cam, self._config.scan)
        self._add_scan(keyframe, T_map_level, T_map_cam @ invert(T_keyframe_cam), scan)

    def add_scan(
        self, keyframe: int, T_keyframe_cam: SE3, T_map_cam: SE3, scan: PlanarScan
    ) -> None:
        """Add the scan of a depth image; poses as for `integrate`."""
        T_map_keyframe = T_map_cam @ invert(T_keyframe_cam)
        self._add_scan(keyframe, level_pose(T_map_cam), T_map_keyframe, scan)

    def _add_scan(
        self, keyframe: int, T_map_level: SE3, T_map_keyframe: SE3, scan: PlanarScan
    ) -> None:
        self._painted_at.setdefault(keyframe, T_map_keyframe)
        self._keep_scan(keyframe, invert(T_map_keyframe) @ T_map_level, scan)
        self._newest = keyframe
        self._paint_scan(scan, T_map_level, 1)

    def mark_obstacle(
        self, T_map_base: SE3, points: NDArray[np.float64], *, touched: bool = False
    ) -> None:
        """Add obstacles that the base has found at `points` (N, 2) x, y in `base` [m].

        Depth never clears them; only the robot's own footprint does (`mark_free`), and
        `forget_touched` those that were only touched.

        What the bumper `touched` may move away; an edge does not.
        """
        on_floor = np.column_stack([points, np.zeros(len(points))])
        for p_map in transform(T_map_base, on_floor):
            self._contacts.append(_Contact(*self._anchor(p_map), touched))

    def infer_obstacle(self, T_map_base: SE3, points: NDArray[np.float64]) -> None:
        """Mark obstacles at `points` (N, 2) x, y in `base` [m], though no sensor shows them.

        Depth that shows floor there clears them, as it clears an obstacle that it has seen.
        """
        scan = scan_of_obstacles(points, self._config.scan)
        x, y = T_map_base[:2, 3].tolist()
        T_map_level = planar(x, y, yaw_of(T_map_base))
        keyframe, T_keyframe_level = self._newest, T_map_level
        if keyframe is not None:
            T_keyframe_level = invert(self._painted_at[keyframe]) @ T_map_level
        place = (keyframe, *self._place(T_keyframe_level[:3, 3]), self._turn(T_keyframe_level), 0)
        item = _AnchoredScan(keyframe, T_keyframe_level, scan, _INFERRED_SIGHTINGS)
        self._evidence[place] = item
        self._paint(item)

    def forget_touched(self) -> bool:
        """Forget what the bumper touched since the start; return whether there was anything.

        Contacts of a saved map stay, since it does not distinguish them from edges.
        """
        before = len(self._contacts)
        self._contacts = [contact for contact in self._contacts if not contact.touched]
        return len(self._contacts) < before

    def mark_free(self, T_map_base: SE3, radius: float) -> None:
        """Mark the floor within `radius` [m] of the robot's centre free: the robot stands on it.

        Contacts more than a cell inside that circle are dropped.
        """
        centre = T_map_base[:3, 3] * [1.0, 1.0, 0.0]
        inside = radius - self._config.resolution
        self._contacts = [
            contact
            for contact in self._contacts
            if np.hypot(*(self._in_map(contact.keyframe, contact.p_keyframe) - centre)[:2]) > inside
        ]
        footprint = _Footprint(*self._anchor(centre), radius)
        place = (footprint.keyframe, *self._place(footprint.p_keyframe))
        self._evidence.pop(place, None)
        self._evidence[place] = footprint
        self._paint_footprint(footprint)

    def follow(self, keyframe_poses: dict[int, SE3]) -> bool:
        """Move with the pose graph; return whether keyframes moved, which repaints the grid.

        Args:
            keyframe_poses: T_map_keyframe of the keyframes' cameras by id; other keyframes stay
                where they are.
        """
        known = [keyframe for keyframe in self._painted_at if keyframe in keyframe_poses]
        if not known:
            return False
        old = np.stack([self._painted_at[keyframe] for keyframe in known])
        new = np.stack([keyframe_poses[keyframe] for keyframe in known])
        distances = np.linalg.norm(new[:, :3, 3] - old[:, :3, 3], axis=1)
        traces = np.einsum("nij,nij->n", old[:, :3, :3], new[:, :3, :3])
        angles = np.arccos(np.clip((traces - 1) / 2, -1.0, 1.0))
        far = (distances > self._config.rebuild_distance) | (angles > self._config.rebuild_angle)
        if not far.any():
            return False
        moved = {known[i] for i in np.flatnonzero(far)}
        touched = [item for item in self._evidence.values() if item.keyframe in moved]
        before = [self._centre(item) for item in touched]
        self._painted_at.update((keyframe, keyframe_poses[keyframe]) for keyframe in moved)
        after = [self._centre(item) for item in touched]
        centres = np.array([*before, *after]).reshape(-1, 2)
        reach = self._config.scan.max_range
        with self._grid.repainting(centres, reach) as touches:
            for item in self._evidence.values():
                if touches(self._centre(item), reach):
                    self._paint(item)
        return True

    def grid(self) -> OccupancyGrid:
        """The present obstacle map; at least one block, even before the first frame."""
        contacts = [
            self._in_map(contact.keyframe, contact.p_keyframe) for contact in self._contacts
        ]
        for contact in contacts:
            self._grid.include(contact[:2], 0.0)
        grid = self._grid.occupancy()
        for contact in contacts:
            row, col = grid.to_cells(contact[:2])
            grid.occupancy[row, col] = 1.0
        return grid

    def _anchor(self, p_map: NDArray[np.float64]) -> tuple[int | None, NDArray[np.float64]]:
        """A point in the newest keyframe; in `map` itself while there is none."""
        if self._newest is None:
            return None, p_map
        return self._newest, transform(invert(self._painted_at[self._newest]), p_map)

    def _in_map(self, keyframe: int | None, p_keyframe: NDArray[np.float64]) -> NDArray[np.float64]:
        if keyframe is None:
            return p_keyframe
        return transform(self._painted_at[keyframe], p_keyframe)

    def _keep_scan(self, keyframe: int, T_keyframe_level: SE3, scan: PlanarScan) -> None:
        """Store a scan instead of the former one from the same place."""
        place = (keyframe, *self._place(T_keyframe_level[:3, 3]), self._turn(T_keyframe_level))
        former = self._evidence.pop(place, None)
        sightings = former.sightings + 1 if isinstance(former, _AnchoredScan) else 1
        self._evidence[place] = _AnchoredScan(keyframe, T_keyframe_level, scan, sightings)

    def _place(self, p_keyframe: NDArray[np.float64]) -> tuple[int, ...]:
        return tuple(int(i) for i in np.round(p_keyframe / self._config.place_size))

    def _turn(self, T_keyframe_level: SE3) -> int:
        heading = np.arctan2(T_keyframe_level[0, 0], T_keyframe_level[2, 0])
        return round(float(heading) / self._config.place_angle)

    def _centre(self, item: _AnchoredScan | _Footprint) -> NDArray[np.float64]:
        """Position x, y in `map` from which the evidence was taken [m]."""
        if isinstance(item, _Footprint):
            return self._in_map(item.keyframe, item.p_keyframe)[:2]
        return self._in_map(item.keyframe, item.T_keyframe_level[:3, 3])[:2]

    def _paint(self, item: _AnchoredScan | _Footprint) -> None:
        if isinstance(item, _Footprint):
            self._paint_footprint(item)
        else:
            T_map_level = item.T_keyframe_level
            if item.keyframe is not None:
                T_map_level = self._painted_at[item.keyframe] @ T_map_level
            self._paint_scan(item.scan, T_map_level, item.sightings)

    def _paint_scan(self, scan: PlanarScan, T_map_level: SE3, sightings: int) -> None:
        self._grid.paint_scan(scan, T_map_level, self._odds * sightings, self._config.scan)

    def _paint_footprint(self, footprint: _Footprint) -> None:
        centre = self._in_map(footprint.keyframe, footprint.p_keyframe)[:2]
        self._grid.paint_free_disc(centre, footprint.radius)
