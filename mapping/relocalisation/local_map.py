"""What stands around a robot that is lost, held against the obstacle map.

A robot that turns on the spot sees most of a room. Obstacles tell rooms apart where images cannot:
from where the robot has not been before, or where furniture comes in pairs.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from mapping.keyframes.wheel_only_motion import apart
from mapping.occupancy.depth_mapper import DepthMapper, DepthMapperConfig
from mapping.relocalisation.scan_matching import (
    ScanMatch,
    ScanMatchConfig,
    agreement_at,
    match_scan,
)
from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, OccupancyGrid, RGBDFrame


class LocalMapConfig(BaseModel):
    """When obstacles tell where the robot is."""

    model_config = SETTINGS

    match: ScanMatchConfig = ScanMatchConfig()
    """How they are compared."""
    reach: float = Field(default=2.0, gt=0.0)
    """What was seen from farther away is forgotten, for dead reckoning drifts [m]."""
    turn: float = Field(default=1.0, gt=0.0)
    """They are compared with the whole map after every turn by this [rad]."""
    agreement: float = Field(default=0.7, gt=0.0)
    """A pose needs this much agreement ..."""
    rival: float = Field(default=0.75, gt=0.0)
    """... and, unless images agree, no other may have more than this share of it, ..."""
    repeats: int = Field(default=3, gt=0)
    """... or, where it was the best one so many times in a row, ..."""
    repeated_rival: float = Field(default=0.85, gt=0.0)
    """... than this: along a wall a step aside fits nearly as well."""
    same: float = Field(default=0.3, gt=0.0)
    """It is the same within this [m, rad]."""
    contradiction: float = Field(default=0.6, gt=0.0)
    """A pose that images suggest is wrong below this agreement."""
    translation_sigma: float = Field(default=0.05, gt=0.0)
    """Error of a pose by obstacles [m] ..."""
    rotation_sigma: float = Field(default=0.03, gt=0.0)
    """... and [rad]."""


class LocalMap:
    """What has been seen since the robot was lost."""

    def __init__(
        self,
        known: Callable[[], OccupancyGrid],
        mapper: DepthMapperConfig,
        config: LocalMapConfig,
    ) -> None:
        """Nothing has been seen.

        Args:
            known: The obstacle map of this moment.
            mapper: How depth is read.
            config: When it tells where the robot is.
        """
        self._known = known
        self._mapper_config = mapper
        self._config = config
        self.forget()

    @property
    def covariance(self) -> NDArray[np.float64]:
        """(6, 6) of a place found, rotation first."""
        sigmas = self._config.rotation_sigma, self._config.translation_sigma
        return np.diag(np.repeat(sigmas, 3) ** 2)

    def forget(self) -> None:
        """The robot is not lost."""
        self._mapper = DepthMapper(self._mapper_config)
        self._T_odom_around: SE3 | None = None
        self._T_around_cam = np.eye(4)
        self._turned = 0.0
        self._best: SE3 | None = None
        self._times = 0

    def add(self, frame: RGBDFrame, T_odom_base: SE3, T_base_cam: SE3) -> None:
        """See one more frame; the base stands there by dead reckoning."""
        if self._T_odom_around is not None:
            T_around_base = invert(self._T_odom_around) @ T_odom_base
            if np.linalg.norm(T_around_base[:3, 3]) > self._config.reach:
                self.forget()
        if self._T_odom_around is None:
            self._T_odom_around = T_odom_base
        T_around_cam = invert(self._T_odom_around) @ T_odom_base @ T_base_cam
        if self._mapper.scans:
            self._turned += rotation_angle(invert(self._T_around_cam) @ T_around_cam)
        self._T_around_cam = T_around_cam
        self._mapper.integrate(0, T_around_cam, T_around_cam, frame.depth, frame.intrinsics)

    def contradict(self, T_map_cam: SE3) -> bool:
        """Whether the newest frame cannot have been taken there."""
        T_map_around = T_map_cam @ invert(self._T_around_cam)
        match = self._config.match
        agreement = agreement_at(T_map_around, self._mapper.grid(), self._known(), match)
        return agreement is not None and agreement < self._config.contradiction

    def places(self) -> tuple[list[SE3], bool]:
        """Where what has been seen fits; asked with every frame, it looks after every turn.

        Returns:
            T_map_cam of the newest frame at one place or two, the better one first, or none; and
            whether the first stands alone.
        """
        config = self._config
        if self._turned < config.turn:
            return [], False
        self._turned -= config.turn
        found = match_scan(self._mapper.grid(), self._known(), config.match)
        if found is None:
            return [], False
        fits = ((found.T_map_around, found.agreement), (found.T_map_rival, found.rival))
        places = [T @ self._T_around_cam for T, share in fits if share >= config.agreement]
        least = config.repeated_rival if self._is_best_again(found, bool(places)) else config.rival
        return places, bool(places) and found.rival <= least * found.agreement

    def _is_best_again(self, found: ScanMatch, fits: bool) -> bool:
        """Whether one place has been the best of all often enough, without a break."""
        before, self._best = self._best, found.T_map_around if fits else None
        if before is None or self._best is None:
            self._times = int(fits)
        else:
            same = apart(before, self._best).max() <= self._config.same
            self._times = self._times + 1 if same else 1
        return self._times >= self._config.repeats
