"""Recognises where a lost robot is, by images and by obstacles."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from mapping.keyframes.frame import Frame, KeyframeMatch
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.keyframes.wheel_only_motion import pose_difference
from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import RelativePose
from mapping.relocalisation.config import RelocalisationConfig
from mapping.relocalisation.depth_consistency import DepthConsistency, corners_in_view
from mapping.relocalisation.local_map import LocalMap
from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.types import SE3, Intrinsics


class Relocaliser:
    """Collects evidence for the place of a lost robot."""

    def __init__(
        self,
        keyframe_map: KeyframeMap,
        intrinsics: Intrinsics,
        T_base_cam: SE3,
        consistency: DepthConsistency,
        config: RelocalisationConfig,
        local_map: LocalMap | None,
    ) -> None:
        self._map = keyframe_map
        self._intrinsics = intrinsics
        self._T_base_cam = T_base_cam
        self._consistency = consistency
        self._config = config
        self._local_map = local_map
        self._hypotheses: list[tuple[SE3, SE3 | None]] = []

    def reset(self) -> None:
        """Drop the evidence collected so far."""
        self._hypotheses.clear()
        if self._local_map is not None:
            self._local_map.reset()

    def recognise(self, frame: Frame) -> KeyframeMatch | None:
        """Find the keyframe that shows a frame's place; None while unsure.

        Images decide, unless obstacles rule out their result; else obstacles decide, and the
        keyframe is the nearest one.
        """
        around, now = self._local_map, frame.dead_reckoned
        T_odom_base = None if now is None else now.T_odom_base
        if around is not None and T_odom_base is not None:
            around.add(frame.image, T_odom_base, self._T_base_cam)
        found = self._by_images(frame.features, T_odom_base)
        if found is None and around is not None and T_odom_base is not None:
            found = self._by_obstacles(frame.features, around)
        return found

    def sure_matches(self, features: Features, before: int) -> Iterator[KeyframeMatch]:
        """Keyframes older than `before`, each of which a lost robot would believe at once.

        The best comes first.
        """
        if len(features) < self._config.alone:
            return
        similar = self._map.most_similar(features, self._config.candidates)
        older = (keyframe for keyframe in similar if keyframe < before)
        found = [
            match
            for match in self._measured(older, features)
            if match.pose.inliers >= self._config.alone
        ]
        for match in sorted(found, key=lambda match: -match.pose.inliers):
            if self._resembles(match, features):
                yield match

    def _measured(self, candidates: Iterable[int], features: Features) -> Iterator[KeyframeMatch]:
        """A frame in those keyframes that it matches, wherever it is there."""
        for keyframe in candidates:
            shown = self._map[keyframe].features
            found = self._map.matcher.between(shown, features, np.eye(4), 1.0)
            if found is not None:
                yield KeyframeMatch(keyframe, found)

    def _resembles(self, match: KeyframeMatch, features: Features) -> bool:
        """Whether a frame surely lies in a keyframe."""
        keyframe, found = self._map[match.keyframe].features, match.pose
        return self._is_sure(keyframe, features, found) and self._is_more_than_floor(
            keyframe, features, found
        )

    def _by_obstacles(self, features: Features, around: LocalMap) -> KeyframeMatch | None:
        keyframes = self._map
        candidates, unambiguous = around.candidate_poses()
        for T_map_cam in candidates:
            for keyframe in keyframes.nearby(T_map_cam)[: self._config.candidates]:
                expected = invert(keyframes.poses[keyframe]) @ T_map_cam
                shown = keyframes[keyframe].features
                found = keyframes.matcher.between(shown, features, expected, 1.0)
                if found is None or found.inliers < self._config.inliers:
                    continue
                if pose_difference(expected, found.T_keyframe_cam).max() <= self._config.beside:
                    return KeyframeMatch(keyframe, found)
        if not unambiguous:
            return None
        keyframe = keyframes.nearest(candidates[0])
        T_keyframe_cam = invert(keyframes.poses[keyframe]) @ candidates[0]
        return KeyframeMatch(keyframe, RelativePose(T_keyframe_cam, around.covariance, 0, 1.0))

    def _by_images(self, features: Features, T_odom_base: SE3 | None) -> KeyframeMatch | None:
        config, around, keyframes = self._config, self._local_map, self._map
        similar = keyframes.most_similar(features, config.candidates)
        sure = [
            match for match in self._measured(similar, features) if self._resembles(match, features)
        ]
        if not sure:
            if T_odom_base is None:
                self._hypotheses.clear()
            return None
        T_odom_cam = None if T_odom_base is None else T_odom_base @ self._T_base_cam
        best = max(sure, key=lambda match: match.pose.inliers)
        T_map_cam = keyframes.poses[best.keyframe] @ best.pose.T_keyframe_cam
        if around is not None and T_odom_base is not None and around.contradicts(T_map_cam):
            return None
        others = [keyframes.poses[other.keyframe] @ other.pose.T_keyframe_cam for other in sure]
        rivals = [T for T in others if pose_difference(T, T_map_cam).max() > config.beside]
        # Where the earlier hypotheses lead to, and how far the robot has turned since.
        led = [(T_map @ moved, rotation_angle(moved)) for T_map, moved in self._since(T_odom_cam)]
        off = [pose_difference(T, T_map_cam).max() for T, _ in led]
        alike = [turn for (_, turn), far in zip(led, off, strict=True) if far <= config.agreement]
        elsewhere = sum(far > config.beside for far in off) + len(rivals)
        if best.pose.inliers >= config.alone and elsewhere == 0:
            return best
        aside = T_odom_cam is None or max(alike, default=0.0) >= config.aside
        if aside and len(alike) > elsewhere:
            return best
        newest = [(T, T_odom_cam) for T in (*rivals, T_map_cam)]
        self._hypotheses = [*self._hypotheses, *newest][-config.guesses :]
        return None

    def _since(self, T_odom_cam: SE3 | None) -> list[tuple[SE3, SE3]]:
        """T_map_cam of the earlier hypotheses, and T_guess_now by dead reckoning.

        Without wheels only the hypotheses of the frame before count.
        """
        if T_odom_cam is None:
            last, self._hypotheses = self._hypotheses, []
            return [(T_map_guess, np.eye(4)) for T_map_guess, _ in last]
        return [
            (T_map_guess, np.eye(4) if T_odom_guess is None else invert(T_odom_guess) @ T_odom_cam)
            for T_map_guess, T_odom_guess in self._hypotheses
        ]

    def _is_sure(self, keyframe: Features, features: Features, found: RelativePose) -> bool:
        config, T = self._config, found.T_keyframe_cam
        both = max(
            corners_in_view(keyframe, T, self._intrinsics),
            corners_in_view(features, invert(T), self._intrinsics),
        )
        return (
            found.inliers >= max(config.inliers, config.shown * both)
            and found.inlier_fraction >= config.inlier_fraction
        )

    def _is_more_than_floor(
        self, keyframe: Features, features: Features, found: RelativePose
    ) -> bool:
        above = self._map.matcher.between(
            self._consistency.above_floor(keyframe),
            self._consistency.above_floor(features),
            found.T_keyframe_cam,
            self._config.above_floor,
        )
        return (
            above is not None
            and pose_difference(found.T_keyframe_cam, above.T_keyframe_cam).max()
            <= self._config.beside
        )
