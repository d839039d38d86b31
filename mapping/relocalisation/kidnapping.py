"""Notices that somebody has carried the robot away: images show plenty, but not its place."""

from __future__ import annotations

from fractions import Fraction

from pydantic import BaseModel, Field

from mapping.keyframes.frame_matcher import FrameMatcher
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import RelativePose
from mapping.relocalisation.depth_consistency import DepthConsistency, corners_in_view
from vizbot.core.geometry import invert
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, Intrinsics, RGBDFrame


class KidnappingConfig(BaseModel):
    """When the robot is lost."""

    model_config = SETTINGS

    corners: int = Field(default=80, gt=0)
    """An image shows plenty from so many corners on."""
    broken: int = Field(default=250, gt=0)
    """There is a break where so many corners of one frame should be in view in the next, but none
    is, and depth shows something else there."""
    patience: int = Field(default=2, gt=0)
    """The robot is lost after so many frames in a row that show plenty, but not what they should;
    somebody who walks by is not there for longer."""
    patience_in_place: int = Field(default=8, gt=0)
    """Where all is in its place, or was at the break, the robot is lost after so many frames: blur
    and plain walls match nothing, but rooms are alike."""


class Kidnapping:
    """What speaks against the robot's place.

    Attributes:
        doubts: Whether the newest frame shows plenty, but not what it should, or there was a break
            before it; nothing new should be put at such a place.
    """

    def __init__(
        self, intrinsics: Intrinsics, solid: DepthConsistency, config: KidnappingConfig
    ) -> None:
        self._intrinsics = intrinsics
        self._solid = solid
        self._config = config
        self.forget()
        self._proven: set[int] = set()

    def agree(self, keyframe: int, found: RelativePose) -> None:
        """A frame is where a keyframe shows it, which others may be held against from now on.

        A keyframe that no other frame has matched may blur.
        """
        if found.inliers > 0:
            self._proven.add(keyframe)
        self.forget()

    def forget(self) -> None:
        """What was seen until now says nothing more against the robot's place."""
        self.doubts = False
        self._broke_off = False
        self._moved = False
        self._suspects = False
        self._contradictions = Fraction(0)

    def over(self) -> None:
        """The robot knows where it is: no keyframe of before is one to hold it against."""
        self._proven.clear()

    def follow(self, before: Features, motion: SE3, steady: int, frame: RGBDFrame) -> None:
        """Notice whether one frame goes on where another ended.

        Args:
            before: What the other one showed.
            motion: T_before_cam as predicted.
            steady: How many corners go well with it.
            frame: That matches nothing in the map.
        """
        if steady > 0:
            return
        self._broke_off = True
        self._moved |= not self._solid.are_in_place(before, motion, frame.depth)
        rich = corners_in_view(before, motion, self._intrinsics) >= self._config.broken
        self._suspects |= rich and self._solid.are_out_of_place(before, motion, frame.depth)

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
        T_map_cam = places.poses[reference] @ T_reference_cam
        near = [k for k in places.nearby(T_map_cam, but=reference) if places.is_recent(k)]
        plenty = len(features) >= self._config.corners
        known = next((k for k in [reference, *near] if k in self._proven), reference)
        shown, expected = places[known].features, invert(places.poses[known]) @ T_map_cam
        in_view = corners_in_view(shown, expected, self._intrinsics)
        if known in self._proven and in_view >= self._config.corners:
            elsewhere = plenty and not matcher.shows(places[known], features)
            self.doubts = elsewhere or self._suspects
            contradicts = elsewhere and self._broke_off
            in_place = self._solid.are_in_place(shown, expected, frame.depth)
        else:  # nothing is known there
            self.doubts = self._suspects
            contradicts = plenty and self._suspects
            in_place = True
        if contradicts and steady >= self._config.corners:
            moved = self._moved and not in_place
            patience = self._config.patience if moved else self._config.patience_in_place
            self._contradictions += Fraction(1, patience)
        return self._contradictions >= 1
