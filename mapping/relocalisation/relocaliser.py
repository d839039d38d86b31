"""Recognises where a lost robot is."""

from __future__ import annotations

import numpy as np
from pydantic import BaseModel, Field

from mapping.keyframes.frame_matcher import FrameMatcher
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.keyframes.wheel_only_motion import apart
from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import RelativePose
from mapping.relocalisation.depth_consistency import DepthConsistency, corners_in_view
from mapping.relocalisation.local_map import LocalMap
from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, Intrinsics, RGBDFrame


class RelocalisationConfig(BaseModel):
    """When a lost robot knows again where it is."""

    model_config = SETTINGS

    candidates: int = Field(default=5, gt=0)
    """Places that look most like a frame and are compared with it."""
    inliers: int = Field(default=40, gt=0)
    """Matches that must agree on a place ..."""
    inlier_fraction: float = Field(default=0.5, gt=0.0)
    """... and their share of all matches."""
    shown: float = Field(default=0.1, gt=0.0)
    """... and their share of the corners that both images should show, ..."""
    above_floor: float = Field(default=0.03, gt=0.0)
    """... and corners above the floor must make a pose as well, searched for within this radius, as
    a fraction of the image's width: boards and tiles repeat."""
    alone: int = Field(default=120, gt=0)
    """So many are believed at once, unless the frame is like another place as well, or another one
    leads elsewhere; else another must lead to the same place, and more of them than elsewhere,
    ..."""
    agreement: float = Field(default=0.15, gt=0.0)
    """... to within this [m, rad], ..."""
    aside: float = Field(default=0.35, gt=0.0)
    """... taken after a turn by this, where wheels tell of it, so that it shows other things:
    there is more than one window with the same view [rad]."""
    guesses: int = Field(default=50, gt=0)
    """Places that earlier frames led to are remembered for that, the newest ones: a robot may stand
    lost for hours."""
    beside: float = Field(default=0.3, gt=0.0)
    """Images agree with a place that obstacles suggest when they lead there to within this
    [m, rad]."""


class Relocaliser:
    """What speaks for a place."""

    def __init__(
        self,
        intrinsics: Intrinsics,
        T_base_cam: SE3,
        solid: DepthConsistency,
        config: RelocalisationConfig,
        surroundings: LocalMap | None,
    ) -> None:
        self._intrinsics = intrinsics
        self._T_base_cam = T_base_cam
        self._solid = solid
        self._config = config
        self._surroundings = surroundings
        self._guesses: list[tuple[SE3, SE3 | None]] = []

    def forget(self) -> None:
        """What was seen until now says nothing more about where the robot is."""
        self._guesses.clear()
        if self._surroundings is not None:
            self._surroundings.forget()

    def recognise(
        self,
        frame: RGBDFrame,
        features: Features,
        places: KeyframeMap,
        matcher: FrameMatcher,
        T_odom_base: SE3 | None,
    ) -> tuple[int, RelativePose] | None:
        """The keyframe that shows the frame's place, and the frame in it; None while unsure.

        Images tell it, unless obstacles rule it out; else obstacles do, and the keyframe is the
        nearest one.

        Args:
            frame: Newer than any before.
            features: Of the frame.
            places: Where it may be.
            matcher: Measures it there.
            T_odom_base: By dead reckoning; None without wheels.
        """
        around = self._surroundings
        if around is not None and T_odom_base is not None:
            around.add(frame, T_odom_base, self._T_base_cam)
        found = self._by_images(features, places, matcher, T_odom_base)
        if found is None and around is not None and T_odom_base is not None:
            found = self._by_obstacles(features, places, matcher, around)
        return found

    def striking(
        self, features: Features, places: KeyframeMap, matcher: FrameMatcher
    ) -> list[tuple[int, RelativePose]]:
        """The keyframes, wherever, each of which a lost robot would believe at once, best first."""
        if len(features) < self._config.alone:
            return []
        found = self._resembling(features, places, matcher)
        found = [pair for pair in found if pair[1].inliers >= self._config.alone]
        return sorted(found, key=lambda pair: -pair[1].inliers)

    def _resembling(
        self, features: Features, places: KeyframeMap, matcher: FrameMatcher
    ) -> list[tuple[int, RelativePose]]:
        """Of the keyframes that look most like a frame, those in which it surely lies."""
        measured = [
            (keyframe, matcher.between(places[keyframe].features, features, np.eye(4), 1.0))
            for keyframe in places.alike(features, self._config.candidates)
        ]
        return [
            (keyframe, found)
            for keyframe, found in measured
            if found is not None
            and self._is_sure(places[keyframe].features, features, found)
            and self._is_more_than_floor(places[keyframe].features, features, found, matcher)
        ]

    def _by_obstacles(
        self,
        features: Features,
        places: KeyframeMap,
        matcher: FrameMatcher,
        around: LocalMap,
    ) -> tuple[int, RelativePose] | None:
        fitting, alone = around.places()
        for T_map_cam in fitting:
            for keyframe in places.nearby(T_map_cam)[: self._config.candidates]:
                expected = invert(places.poses[keyframe]) @ T_map_cam
                found = matcher.between(places[keyframe].features, features, expected, 1.0)
                if found is None or found.inliers < self._config.inliers:
                    continue
                if apart(expected, found.T_keyframe_cam).max() <= self._config.beside:
                    return keyframe, found
        if not alone:
            return None
        keyframe = places.nearest(fitting[0])
        T_keyframe_cam = invert(places.poses[keyframe]) @ fitting[0]
        return keyframe, RelativePose(T_keyframe_cam, around.covariance, 0, 1.0)

    def _by_images(
        self,
        features: Features,
        places: KeyframeMap,
        matcher: FrameMatcher,
        T_odom_base: SE3 | None,
    ) -> tuple[int, RelativePose] | None:
        config, around = self._config, self._surroundings
        sure = self._resembling(features, places, matcher)
        if not sure:
            if T_odom_base is None:
                self._guesses.clear()
            return None
        T_odom_cam = None if T_odom_base is None else T_odom_base @ self._T_base_cam
        keyframe, found = max(sure, key=lambda pair: pair[1].inliers)
        T_map_cam = places.poses[keyframe] @ found.T_keyframe_cam
        if around is not None and T_odom_base is not None and around.contradict(T_map_cam):
            return None
        others = [places.poses[other] @ seen.T_keyframe_cam for other, seen in sure]
        rivals = [T for T in others if apart(T, T_map_cam).max() > config.beside]
        # Where the earlier guesses lead to, and how far the robot has turned since.
        led = [(T_map @ moved, rotation_angle(moved)) for T_map, moved in self._since(T_odom_cam)]
        alike = [turn for T, turn in led if apart(T, T_map_cam).max() <= config.agreement]
        elsewhere = sum(apart(T, T_map_cam).max() > config.beside for T, _ in led) + len(rivals)
        if found.inliers >= config.alone and elsewhere == 0:
            return keyframe, found
        aside = T_odom_cam is None or max(alike, default=0.0) >= config.aside
        if aside and len(alike) > elsewhere:
            return keyframe, found
        guesses = [(T, T_odom_cam) for T in (*rivals, T_map_cam)]
        self._guesses = [*self._guesses, *guesses][-config.guesses :]
        return None

    def _since(self, T_odom_cam: SE3 | None) -> list[tuple[SE3, SE3]]:
        """T_map_cam of the earlier guesses, and T_guess_now by dead reckoning.

        Without wheels only the frame before was taken near by.
        """
        if T_odom_cam is None:
            guesses, self._guesses = self._guesses, []
            return [(T_map_guess, np.eye(4)) for T_map_guess, _ in guesses]
        return [
            (T_map_guess, np.eye(4) if T_odom_guess is None else invert(T_odom_guess) @ T_odom_cam)
            for T_map_guess, T_odom_guess in self._guesses
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
        self, keyframe: Features, features: Features, found: RelativePose, matcher: FrameMatcher
    ) -> bool:
        above = matcher.between(
            self._solid.among(keyframe),
            self._solid.among(features),
            found.T_keyframe_cam,
            self._config.above_floor,
        )
        return (
            above is not None
            and apart(found.T_keyframe_cam, above.T_keyframe_cam).max() <= self._config.beside
        )
