"""Notices that the robot is not where it should be, and recognises where it is."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from mapping.features import Features
from mapping.frame_matcher import FrameMatcher
from mapping.keyframe_map import KeyframeMap
from mapping.odometry import RelativePose, predicted_pixels
from mapping.surroundings import Surroundings
from vizbot.core.geometry import invert, rotation_angle, transform
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, Intrinsics, RGBDFrame

_FLOOR = 0.1
"""What is no higher may be the floor [m]."""
_OFF, _OFF_PER_METRE = 0.1, 0.05
"""So far off depth and place may be [m], and so much more for each metre away."""


class RelocalisationConfig(BaseModel):
    """When the robot is lost, and when it knows again where it is."""

    model_config = SETTINGS

    corners: int = Field(default=80, gt=0)
    """An image shows plenty from so many corners on."""
    patience: int = Field(default=2, gt=0)
    """The robot is lost after so many frames in a row that show plenty, but not what they should;
    somebody who walks by is not there for longer."""
    solid: int = Field(default=20, gt=0)
    """Corners above the floor that must be in view ..."""
    in_place: float = Field(default=0.5, gt=0.0)
    """... and their share that must be as far away as they should be: then all is in its place."""
    patience_in_place: int = Field(default=8, gt=0)
    """Then the robot is lost after so many frames: blur and plain walls match nothing, but rooms
    are alike."""
    candidates: int = Field(default=5, gt=0)
    """Places that look most like a frame and are compared with it."""
    inliers: int = Field(default=40, gt=0)
    """Matches that must agree on a place ..."""
    inlier_fraction: float = Field(default=0.5, gt=0.0)
    """... and their share of all matches."""
    shown: float = Field(default=0.1, gt=0.0)
    """... and their share of the corners that both images should show."""
    alone: int = Field(default=120, gt=0)
    """So many are believed at once, unless another frame leads elsewhere; else another one must
    lead to the same place, and more of them than elsewhere, ..."""
    agreement: float = Field(default=0.15, gt=0.0)
    """... to within this [m, rad], ..."""
    aside: float = Field(default=0.35, gt=0.0)
    """... taken after a turn by this, where wheels tell of it, so that it shows other things:
    there is more than one window with the same view [rad]."""
    guesses: int = Field(default=50, gt=0)
    """Earlier frames that are remembered for that, the newest ones: a robot may stand lost for
    hours."""
    beside: float = Field(default=0.3, gt=0.0)
    """Images agree with a place that obstacles suggest when they lead there to within this
    [m, rad]."""


class Relocalisation:
    """What speaks against the robot's place, and for another one.

    Attributes:
        doubts: Whether the newest frame shows plenty, but not what it should; nothing new should be
            put at such a place.
    """

    def __init__(
        self,
        intrinsics: Intrinsics,
        T_base_cam: SE3,
        config: RelocalisationConfig,
        surroundings: Surroundings | None,
    ) -> None:
        self._size = np.array([intrinsics.width, intrinsics.height])
        self._intrinsics = intrinsics
        self._T_base_cam = T_base_cam
        self._config = config
        self._surroundings = surroundings
        self.doubts = False
        self._broke_off = False
        self._contradictions = Fraction(0)
        self._proven: set[int] = set()
        self._guesses: list[tuple[SE3, SE3 | None]] = []

    def agree(self, keyframe: int, found: RelativePose) -> None:
        """A frame is where a keyframe shows it, which others may be held against from now on.

        A keyframe that no other frame has matched may blur.
        """
        if found.inliers > 0:
            self._proven.add(keyframe)
        self.forget()

    def forget(self) -> None:
        """What was seen until now says nothing more about where the robot is."""
        self.doubts = False
        self._broke_off = False
        self._contradictions = Fraction(0)
        self._guesses.clear()
        if self._surroundings is not None:
            self._surroundings.forget()

    def is_elsewhere(
        self,
        frame: RGBDFrame,
        features: Features,
        places: KeyframeMap,
        matcher: FrameMatcher,
        reference: int,
        T_reference_cam: SE3,
        steady: int,
    ) -> bool:
        """Whether one more frame that matches nothing, on top of those before, proves it.

        Args:
            frame: Its depth may say that all is in its place; then it proves less.
            features: Of the frame.
            places: What it should show a part of.
            matcher: Tells whether it does, wherever: what is only refused by wheels or gyroscope is
                no proof.
            reference: Keyframe that the robot has been measured in.
            T_reference_cam: Where the frame should be.
            steady: How many of its corners go well with the frame before; one that blurs proves
                nothing, and without a break somewhere nobody has carried the robot.
        """
        self._broke_off |= steady == 0
        T_map_cam = places.poses[reference] @ T_reference_cam
        near = [k for k in places.nearby(T_map_cam, but=reference) if places.is_recent(k)]
        known = next((k for k in [reference, *near] if k in self._proven), None)
        if known is None:
            self.doubts = False
            return False
        expected = invert(places.poses[known]) @ T_map_cam
        in_view = self._in_view(places[known].features, expected)
        plenty = min(len(features), in_view) >= self._config.corners
        self.doubts = plenty and not matcher.shows(places[known], features)
        if self.doubts and self._broke_off and steady >= self._config.corners:
            in_place = self._is_in_place(places[known].features, expected, frame.depth)
            patience = self._config.patience_in_place if in_place else self._config.patience
            self._contradictions += Fraction(1, patience)
        return self._contradictions >= 1

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
        if found is not None:
            self._proven.clear()
        return found

    def beyond_doubt(
        self, features: Features, places: KeyframeMap, matcher: FrameMatcher
    ) -> list[tuple[int, RelativePose]]:
        """The keyframes, wherever, each of which shows the frame's place by itself, best first."""
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
            if found is not None and self._is_sure(places[keyframe].features, features, found)
        ]

    def _by_obstacles(
        self,
        features: Features,
        places: KeyframeMap,
        matcher: FrameMatcher,
        around: Surroundings,
    ) -> tuple[int, RelativePose] | None:
        fitting, alone = around.places()
        for T_map_cam in fitting:
            for keyframe in places.nearby(T_map_cam)[: self._config.candidates]:
                expected = invert(places.poses[keyframe]) @ T_map_cam
                found = matcher.between(places[keyframe].features, features, expected, 1.0)
                if found is None or found.inliers < self._config.inliers:
                    continue
                if _apart(expected, found.T_keyframe_cam) <= self._config.beside:
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
        # Where the earlier guesses lead to, and how far the robot has turned since.
        led = [(T_map @ moved, rotation_angle(moved)) for T_map, moved in self._since(T_odom_cam)]
        alike = [turn for T, turn in led if _apart(T, T_map_cam) <= config.agreement]
        elsewhere = sum(_apart(T, T_map_cam) > config.beside for T, _ in led)
        if found.inliers >= config.alone and elsewhere == 0:
            return keyframe, found
        aside = T_odom_cam is None or max(alike, default=0.0) >= config.aside
        if aside and len(alike) > elsewhere:
            return keyframe, found
        self._guesses = [*self._guesses, (T_map_cam, T_odom_cam)][-config.guesses :]
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
        both = max(self._in_view(keyframe, T), self._in_view(features, invert(T)))
        return (
            found.inliers >= max(config.inliers, config.shown * both)
            and found.inlier_fraction >= config.inlier_fraction
        )

    def _is_in_place(
        self, features: Features, T_features_cam: SE3, depth: NDArray[np.float32]
    ) -> bool:
        """Whether a camera there sees corners above the floor as far away as they should be.

        The floor is as far away wherever the robot stands.
        """
        points = transform(invert(T_features_cam), features.points)
        pixels = predicted_pixels(features, T_features_cam, self._intrinsics)
        with np.errstate(invalid="ignore"):
            seen = ((pixels >= 0) & (pixels < self._size - 1)).all(axis=1)
        seen &= (features.points[:, 2] > 0) & (transform(self._T_base_cam, points)[:, 2] > _FLOOR)
        columns, rows = pixels[seen].round().astype(np.int64).T
        expected, measured = points[seen, 2], depth[rows, columns]
        known = measured > 0
        off = np.abs(measured - expected)[known]
        fits = np.count_nonzero(off < _OFF + _OFF_PER_METRE * expected[known])
        least = max(self._config.solid, self._config.in_place * np.count_nonzero(known))
        return bool(fits >= least)

    def _in_view(self, features: Features, T_features_cam: SE3) -> int:
        """How many corners with depth a camera there should see, if nothing stands before them."""
        pixels = predicted_pixels(features, T_features_cam, self._intrinsics)
        with np.errstate(invalid="ignore"):
            inside = ((pixels >= 0) & (pixels < self._size)).all(axis=1)
        return int(np.count_nonzero(inside & (features.points[:, 2] > 0)))


def _apart(T_a: SE3, T_b: SE3) -> float:
    """How far two poses are apart, in metres or radians, whichever is more."""
    off = invert(T_a) @ T_b
    return max(float(np.linalg.norm(off[:3, 3])), rotation_angle(off))
