"""Where a frame was taken that its reference keyframe does not show."""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from mapping.blind_way import apart
from mapping.features import Features
from mapping.odometry import RelativePose
from mapping.relocalisation import Relocalisation
from mapping.slam_config import SlamConfig
from mapping.whereabouts import Whereabouts
from vizbot.core.geometry import invert
from vizbot.core.types import SE3, RGBDFrame


class PlaceSearch:
    """Searches the map; the keyframe that shows the frame becomes the reference."""

    def __init__(
        self, where: Whereabouts, relocalisation: Relocalisation, config: SlamConfig
    ) -> None:
        self._where = where
        self._relocalisation = relocalisation
        self._config = config

    def nearby(
        self, features: Features, predicted: SE3, unseen: NDArray[np.float64] | None
    ) -> RelativePose | None:
        """Search the whole image for the keyframes near.

        Args:
            features: Of the frame.
            predicted: T_reference_cam by dead reckoning.
            unseen: (2,) motion since images were last believed [m, rad]; None without wheels.
        """
        where, config = self._where, self._config
        T_map_cam = where.places.poses[where.reference] @ predicted
        others = where.places.nearby(T_map_cam, but=where.reference)
        for keyframe in [where.reference, *others[: config.nearby_tries]]:
            expected = invert(where.places.poses[keyframe]) @ T_map_cam
            found = where.against(keyframe, features, expected, 1.0)
            if found is None or found.inliers < config.gates.sure_inliers:
                continue
            if where.matcher.believed(found, expected, unseen):
                self._regain(keyframe, found, predicted, unseen)
                return found
        return None

    def far(
        self, features: Features, predicted: SE3, unseen: NDArray[np.float64]
    ) -> RelativePose | None:
        """Wheels that spin for long lead farther from the place than what is tried near by.

        Arguments are those of `nearby`.
        """
        keyframes, where = self._config.keyframes, self._where
        if unseen[0] < keyframes.closure_distance and unseen[1] < keyframes.closure_angle:
            return None
        T_map_cam = where.places.poses[where.reference] @ predicted
        place = self.beyond_doubt(features, T_map_cam, unseen)
        if place is None:
            return None
        self._regain(*place, predicted, unseen)
        return place[1]

    def anywhere(self, frame: RGBDFrame, features: Features) -> RelativePose | None:
        """Compare with all places, for a robot that may have been carried."""
        where = self._where
        T_odom_base = None if where.reckoning is None else where.reckoning.T_odom_base
        found = self._relocalisation.recognise(
            frame, features, where.places, where.matcher, T_odom_base
        )
        if found is None:
            return None
        where.places.forget_ways()
        where.refer_to(*found)
        return found[1]

    def beyond_doubt(
        self,
        features: Features,
        T_map_cam: SE3,
        off: NDArray[np.float64],
        before: int = sys.maxsize,
    ) -> tuple[int, RelativePose] | None:
        """The keyframe that shows the frame best, if its place is no farther off than may be.

        Args:
            features: Of the frame.
            T_map_cam: Where it should be.
            off: (2,) how far off that may be [m, rad].
            before: Only keyframes before this one.
        """
        where, gate = self._where, self._config.gates.wheel_gate
        for keyframe, found in self._relocalisation.beyond_doubt(
            features, where.places, where.matcher
        ):
            moved = apart(T_map_cam, where.places.poses[keyframe] @ found.T_keyframe_cam)
            if keyframe < before and (moved <= gate + off).all():
                return keyframe, found
        return None

    def _regain(
        self,
        keyframe: int,
        found: RelativePose,
        predicted: SE3,
        unseen: NDArray[np.float64] | None,
    ) -> None:
        where = self._where
        if unseen is not None and keyframe != where.reference:
            T_reference_keyframe = predicted @ invert(found.T_keyframe_cam)
            way = where.blind.since_reference
            where.places.tie(where.reference, keyframe, T_reference_keyframe, way)
        where.refer_to(keyframe, found)
