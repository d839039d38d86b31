"""The obstacles around a lost robot, matched to the obstacle map.

A robot that turns on the spot sees most of a room. Obstacles distinguish rooms where images cannot:
from viewpoints that are new, or where furniture comes in pairs.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.wheel_only_motion import pose_difference
from mapping.occupancy.config import DepthMapperConfig
from mapping.occupancy.depth_mapper import DepthMapper
from mapping.relocalisation.config import LocalMapConfig
from mapping.relocalisation.scan_matching import ScanMatch, agreement_at, match_scan
from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.types import SE3, OccupancyGrid, RGBDFrame


class LocalMap:
    """Obstacles seen since the robot was lost."""

    def __init__(
        self,
        known: Callable[[], OccupancyGrid],
        mapper: DepthMapperConfig,
        config: LocalMapConfig,
    ) -> None:
        """Start empty; `known` returns the present obstacle map."""
        self._known = known
        self._mapper_config = mapper
        self._config = config
        self.reset()

    @property
    def covariance(self) -> NDArray[np.float64]:
        """(6, 6) of a pose by obstacles, rotation first."""
        sigmas = self._config.rotation_sigma, self._config.translation_sigma
        return np.diag(np.repeat(sigmas, 3) ** 2)

    def reset(self) -> None:
        """Start anew, with nothing seen."""
        self._mapper = DepthMapper(self._mapper_config)
        self._T_odom_around: SE3 | None = None
        self._T_around_cam = np.eye(4)
        self._turned = 0.0
        self._best: SE3 | None = None
        self._times = 0

    def add(self, frame: RGBDFrame, T_odom_base: SE3, T_base_cam: SE3) -> None:
        """Add the obstacles of a frame, with the base at a pose by dead reckoning."""
        if self._T_odom_around is not None:
            T_around_base = invert(self._T_odom_around) @ T_odom_base
            if np.linalg.norm(T_around_base[:3, 3]) > self._config.max_distance:
                self.reset()
        if self._T_odom_around is None:
            self._T_odom_around = T_odom_base
        T_around_cam = invert(self._T_odom_around) @ T_odom_base @ T_base_cam
        if self._mapper.scans:
            self._turned += rotation_angle(invert(self._T_around_cam) @ T_around_cam)
        self._T_around_cam = T_around_cam
        self._mapper.integrate(0, T_around_cam, T_around_cam, frame.depth, frame.intrinsics)

    def contradicts(self, T_map_cam: SE3) -> bool:
        """Whether obstacles rule out a pose of the newest frame."""
        T_map_around = T_map_cam @ invert(self._T_around_cam)
        match = self._config.match
        agreement = agreement_at(T_map_around, self._mapper.grid(), self._known(), match)
        return agreement is not None and agreement < self._config.min_image_agreement

    def candidate_poses(self) -> tuple[list[SE3], bool]:
        """Match the obstacles to the map, if the robot has turned far enough since the last time.

        Returns:
            Up to two poses T_map_cam of the newest frame, the better one first, and whether the
            first is unambiguous.
        """
        config = self._config
        if self._turned < config.comparison_angle:
            return [], False
        self._turned -= config.comparison_angle
        found = match_scan(self._mapper.grid(), self._known(), config.match)
        if found is None:
            return [], False
        fits = ((found.T_map_around, found.agreement), (found.T_map_rival, found.rival))
        poses = [T @ self._T_around_cam for T, share in fits if share >= config.agreement]
        least = (
            config.max_repeated_rival
            if self._is_best_again(found, bool(poses))
            else config.max_rival
        )
        return poses, bool(poses) and found.rival <= least * found.agreement

    def _is_best_again(self, found: ScanMatch, fits: bool) -> bool:
        """Whether the same pose was the best often enough in a row."""
        before, self._best = self._best, found.T_map_around if fits else None
        if before is None or self._best is None:
            self._times = int(fits)
        else:
            same = pose_difference(before, self._best).max() <= self._config.same_pose_distance
            self._times = self._times + 1 if same else 1
        return self._times >= self._config.repeats
