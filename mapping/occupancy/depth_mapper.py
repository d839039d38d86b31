"""DepthMapper of the paper (section C, Algorithm 1): a 2D obstacle map from depth and poses.

Every frame becomes a planar scan, which is painted into a grid of log odds and kept, anchored to
its keyframe; where keyframes moved with the graph, the grid is painted again from the scans. A
newer scan replaces the one of the same keyframe and place, so that what is kept grows with the home
and not with time. What the bumper felt is kept apart, so that a camera that cannot see it (glass, a
thin leg) does not clear it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from mapping.occupancy.log_odds_grid import LogOddsGrid
from mapping.occupancy.planar_scan import PlanarScan, ScanConfig, flatten, level_pose
from vizbot.core.errors import MapError
from vizbot.core.geometry import invert, transform
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, Intrinsics, OccupancyGrid


class DepthMapperConfig(BaseModel):
    """The obstacle map: its cells and how fast evidence changes them."""

    model_config = SETTINGS

    scan: ScanConfig = ScanConfig()
    """How a depth image is read."""
    resolution: float = Field(default=0.05, ge=0.01, le=0.5)
    """Edge of a cell [m] (paper, common settings)."""
    obstacle_odds: float = 0.6
    """Log odds that one near sight of an obstacle adds to its cell; far ones add less."""
    floor_odds: float = -0.4
    """Log odds that one sight of the floor adds."""
    drop_odds: float = 0.4
    """Log odds that one sight of a drop adds: the robot keeps away from stairs as from a wall."""
    passed_odds: float = -0.12
    """Log odds that rays which passed over a cell add."""
    min_odds: float = -1.6
    """Bound that lets an obstacle appear again within some frames."""
    max_odds: float = 3.5
    """Bound that lets a vanished obstacle go within some frames."""
    rebuild_distance: float = 0.025
    """Paint again once a keyframe moved farther [m]."""
    rebuild_angle: float = 0.0087
    """Paint again once a keyframe turned farther [rad]."""
    place_size: float = Field(default=0.05, gt=0.0)
    """Scans and footprints of one keyframe that are no farther apart share a place in memory [m];
    so do scans ..."""
    place_angle: float = Field(default=0.05, gt=0.0)
    """... that are also turned by no more than this [rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class _AnchoredScan:
    keyframe: int
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


def require_resolution(kept: OccupancyGrid, config: DepthMapperConfig) -> None:
    """Refuse a map of before that cannot be gone on with.

    Raises:
        MapError: its cells are of another size.
    """
    if not np.isclose(kept.resolution, config.resolution):
        raise MapError(
            f"the map's cells are {kept.resolution:g} m wide, those of the robot"
            f" {config.resolution:g} m: set perception.depth_mapper.resolution to"
            f" {kept.resolution:g}"
        )


def _contacts_of(kept: OccupancyGrid) -> list[_Contact]:
    """What the bumper felt: depth alone never makes a cell as sure as that."""
    felt = kept.to_xy(np.argwhere(kept.occupancy == 1.0))
    return [_Contact(None, np.array([x, y, 0.0])) for x, y in felt]


class DepthMapper:
    """The obstacle map as it grows; `map` has its floor at z = 0."""

    def __init__(self, config: DepthMapperConfig, kept: OccupancyGrid | None = None) -> None:
        """Begin with nothing, or in a map of before.

        Args:
            config: Cells and evidence.
            kept: The map of before; what it holds moves with no keyframe.

        Raises:
            MapError: its cells are of another size.
        """
        if kept is not None:
            require_resolution(kept, config)
        self._config = config
        bounds = config.min_odds, config.max_odds
        self._grid = LogOddsGrid(config.resolution, bounds, kept)
        self._odds = np.array(
            [0.0, config.passed_odds, config.drop_odds, config.floor_odds, config.obstacle_odds]
        )
        self._evidence: dict[tuple[int | None, ...], _AnchoredScan | _Footprint] = {}
        self._contacts: list[_Contact] = [] if kept is None else _contacts_of(kept)
        self._painted_at: dict[int, SE3] = {}
        self._newest: int | None = None

    @property
    def scans(self) -> int:
        """How many scans are kept."""
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

        Args:
            keyframe: Id of the keyframe that the frame is anchored to.
            T_keyframe_cam: The camera in that keyframe's camera.
            T_map_cam: The camera in the map, heights above the floor included.
            depth: Distance along the optical axis.
            intrinsics: Of the depth image.
        """
        T_map_level = level_pose(T_map_cam)
        scan = flatten(depth, intrinsics, invert(T_map_level) @ T_map_cam, self._config.scan)
        T_map_keyframe = T_map_cam @ invert(T_keyframe_cam)
        self._painted_at.setdefault(keyframe, T_map_keyframe)
        self._keep_scan(keyframe, invert(T_map_keyframe) @ T_map_level, scan)
        self._newest = keyframe
        self._paint_scan(scan, T_map_level, 1)

    def mark_obstacle(self, T_map_base: SE3, points: NDArray[np.float64]) -> None:
        """Keep obstacles that the bumper felt at `points` (N, 2) x, y in `base` [m].

        Depth never clears them; only the robot's own footprint does (`mark_free`).
        """
        on_floor = np.column_stack([points, np.zeros(len(points))])
        for p_map in transform(T_map_base, on_floor):
            self._contacts.append(_Contact(*self._anchor(p_map)))

    def mark_free(self, T_map_base: SE3, radius: float) -> None:
        """The floor within `radius` [m] of the robot's centre is free: the robot stands on it.

        Contacts more than a cell inside that circle are forgotten.
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
        """Move with the graph.

        Args:
            keyframe_poses: T_map_keyframe of the keyframes' cameras by id; keyframes that it does
                not name stay where they are.

        Returns:
            Whether some keyframe had moved far enough for the grid to be painted again.
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
        """The obstacle map now; at least one block, even before the first frame."""
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
        """Keep a scan instead of the one that was taken from there before."""
        heading = np.arctan2(T_keyframe_level[0, 0], T_keyframe_level[2, 0])
        turn = round(float(heading) / self._config.place_angle)
        place = (keyframe, *self._place(T_keyframe_level[:3, 3]), turn)
        former = self._evidence.pop(place, None)
        sightings = former.sightings + 1 if isinstance(former, _AnchoredScan) else 1
        self._evidence[place] = _AnchoredScan(keyframe, T_keyframe_level, scan, sightings)

    def _place(self, p_keyframe: NDArray[np.float64]) -> tuple[int, ...]:
        return tuple(int(i) for i in np.round(p_keyframe / self._config.place_size))

    def _centre(self, item: _AnchoredScan | _Footprint) -> NDArray[np.float64]:
        """Where it was made, x, y in `map` [m]."""
        if isinstance(item, _Footprint):
            return self._in_map(item.keyframe, item.p_keyframe)[:2]
        return self._in_map(item.keyframe, item.T_keyframe_level[:3, 3])[:2]

    def _paint(self, item: _AnchoredScan | _Footprint) -> None:
        if isinstance(item, _Footprint):
            self._paint_footprint(item)
        else:
            T_map_level = self._painted_at[item.keyframe] @ item.T_keyframe_level
            self._paint_scan(item.scan, T_map_level, item.sightings)

    def _paint_scan(self, scan: PlanarScan, T_map_level: SE3, sightings: int) -> None:
        self._grid.paint_scan(scan, T_map_level, self._odds * sightings, self._config.scan)

    def _paint_footprint(self, footprint: _Footprint) -> None:
        centre = self._in_map(footprint.keyframe, footprint.p_keyframe)[:2]
        self._grid.paint_free_disc(centre, footprint.radius)
