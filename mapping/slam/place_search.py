"""Where a frame was taken that its reference keyframe does not show."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.tracked_pose import TrackedPose
from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import RelativePose
from mapping.relocalisation.relocaliser import Relocaliser
from mapping.slam.config import SlamConfig
from vizbot.core.geometry import invert
from vizbot.core.types import SE3, RGBDFrame


class PlaceSearch:
    """Searches the map; the keyframe that shows the frame becomes the reference."""

    def __init__(self, where: TrackedPose, relocalisation: Relocaliser, config: SlamConfig) -> None:
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

    def striking(self, features: Features) -> list[tuple[int, RelativePose]]:
        """The keyframes that look strikingly like a frame, wherever they are, best first."""
        return self._relocalisation.striking(features, self._where.places, self._where.matcher)

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
