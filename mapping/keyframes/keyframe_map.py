"""Keyframes, what they show, and the graph between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.anchors import Keyframes, KeyframeViews
from mapping.keyframes.place_index import PlaceIndex, PlaceIndexConfig
from mapping.keyframes.pose_graph import PoseGraph, PoseGraphConfig
from mapping.keyframes.selection import Keyframe, KeyframeConfig, nearby
from mapping.odometry.dead_reckoned_pose import DeadReckonedPose
from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.types import SE3


class KeyframeMap:
    """All keyframes of a run.

    Attributes:
        poses: T_map_cam of every keyframe by its id, after the latest update of the graph.
    """

    def __init__(
        self,
        T_base_cam: SE3,
        keyframes: KeyframeConfig,
        graph: PoseGraphConfig,
        places: PlaceIndexConfig,
    ) -> None:
        """Empty."""
        self.poses: dict[int, SE3] = {}
        self._T_base_cam = T_base_cam
        self._config = keyframes
        self._graph = PoseGraph(T_base_cam, graph)
        self._places = PlaceIndex(places)
        self._keyframes: dict[int, Keyframe] = {}
        self._recent: list[int] = []
        self._linked: set[tuple[int, int]] = set()
        self._closing: set[tuple[int, int]] = set()
        self._tied: set[tuple[int, int]] = set()
        self._blank: list[int] = []

    def __len__(self) -> int:
        return len(self._keyframes)

    def __getitem__(self, keyframe: int) -> Keyframe:
        return self._keyframes[keyframe]

    @property
    def closures(self) -> list[tuple[int, int]]:
        """Pairs of keyframes between which a loop is closed."""
        return self._graph.closures

    def is_recent(self, keyframe: int) -> bool:
        """Whether dead reckoning still knows the way from there."""
        return keyframe in self._recent[-self._config.links :]

    def nearby(self, T_map_cam: SE3, but: int | None = None) -> list[int]:
        """Keyframes that may see what a camera there sees, nearest first, without `but`."""
        others = (keyframe for keyframe in self._keyframes if keyframe != but)
        return nearby(self.poses, others, T_map_cam, self._config)

    def nearest(self, T_map_cam: SE3) -> int:
        """The keyframe nearest to a camera, turned like it if several are near."""

        def off(keyframe: int) -> float:
            T_keyframe_cam = invert(self.poses[keyframe]) @ T_map_cam
            return float(np.linalg.norm(T_keyframe_cam[:3, 3])) + rotation_angle(T_keyframe_cam)

        return min(self.poses, key=off)

    def blank_near(self, T_map_cam: SE3) -> int | None:
        """The keyframe that shows nothing nearest to a camera, if one is near enough to serve."""
        off = {k: float(np.linalg.norm((self.poses[k] - T_map_cam)[:3, 3])) for k in self._blank}
        nearest = min(off, key=off.__getitem__, default=None)
        near = nearest is not None and off[nearest] <= self._config.blank_distance
        return nearest if near else None

    def alike(self, features: Features, count: int) -> list[int]:
        """Keyframes that look most like an image, best first."""
        return [keyframe for keyframe, _ in self._places.alike(features, count)]

    def begin(self, features: Features, reckoning: DeadReckonedPose | None) -> int:
        """Put the first keyframe where the base stands at the origin."""
        self._add(0, features, reckoning)
        self._graph.add_keyframe(0, self._T_base_cam, fixed=True)
        self.poses = self._graph.update()
        return 0

    def restore(self, keyframes: Keyframes, views: KeyframeViews) -> None:
        """Put the keyframes of a saved map where they were; they stay there."""
        for keyframe, T_map_cam in keyframes.poses().items():
            shown = slice(*np.searchsorted(views.keyframes, (keyframe, keyframe + 1)))
            features = Features(
                views.pixels[shown].astype(np.float64),
                views.descriptors[shown],
                views.points[shown].astype(np.float64),
            )
            self._add(keyframe, features, None)
            self._graph.add_keyframe(keyframe, T_map_cam, fixed=True)
        self._recent.clear()
        self.poses = self._graph.update()

    def views(self) -> KeyframeViews:
        """What all keyframes show."""
        ids = sorted(self._keyframes)
        if not ids:
            return KeyframeViews.none()
        shown = [self._keyframes[keyframe].features for keyframe in ids]
        return KeyframeViews(
            np.concatenate([features.pixels for features in shown]).astype(np.float32),
            np.concatenate([features.descriptors for features in shown]),
            np.concatenate([features.points for features in shown]).astype(np.float32),
            np.repeat(ids, [len(features) for features in shown]).astype(np.int32),
        )

    def insert(
        self,
        features: Features,
        reckoning: DeadReckonedPose | None,
        T_map_cam: SE3,
        reference: int,
        links: Mapping[int, RelativePose],
        way: NDArray[np.float64],
        *,
        gyro: bool,
    ) -> int:
        """Add a keyframe and solve.

        Args:
            features: What it shows.
            reckoning: Dead reckoning there; None without wheels.
            T_map_cam: Where it is so far.
            reference: The keyframe that dead reckoning and the frames until now refer to.
            links: The new camera in other keyframes by images.
            way: (2,) how far the robot drove and turned, of which images know nothing [m, rad].
            gyro: Whether the gyroscope is believed since the reference.
        """
        new, before = max(self._keyframes) + 1, self._keyframes[reference].reckoning
        recent = {keyframe for keyframe in links if self.is_recent(keyframe)}
        self._graph.add_keyframe(new, T_map_cam)
        # The noise of the new image is in all its links: they say less than if each had its own.
        shared = (len(links) + 1) / 2
        for keyframe, link in links.items():
            self._linked.add((keyframe, new))
            if keyframe not in recent:
                self._closing.add((keyframe, new))
            self._graph.add_image_motion(
                keyframe,
                new,
                link.T_keyframe_cam,
                shared * link.covariance,
                closes=keyframe not in recent,
            )
        if reckoning is not None:
            self._graph.add_floor(new, T_map_cam)
        if reckoning is not None and before is not None:
            if reference not in links:
                # Images knew part of the way until they failed.
                self._add_blind_motion(
                    reference, new, invert(self.poses[reference]) @ T_map_cam, way
                )
            elif reckoning.stamp > before.stamp:  # else that is the same image's word
                self._graph.add_wheel_motion(reference, new, reckoning.by_wheels_since(before))
            if gyro and reckoning.stamp > before.stamp and reckoning.gyro_since(before):
                sigma = reckoning.chained_gyro_sigma_since(before)
                self._graph.add_gyro_turn(reference, new, reckoning.since(before), sigma)
        elif not links:
            T_reference_cam = invert(self.poses[reference]) @ T_map_cam
            self._graph.add_unknown_motion(reference, new, T_reference_cam)
        self._add(new, features, reckoning)
        self.poses = self._graph.update()
        return new

    def close(
        self,
        i: int,
        j: int,
        link: RelativePose,
        doubt: tuple[int, NDArray[np.float64]] | None = None,
    ) -> bool:
        """Link two keyframes that came to see the same place, once, and solve; whether that holds.

        A link that the rest of the graph contradicts is opened again, and stays so.

        Args:
            i: Keyframe.
            j: Keyframe.
            link: Camera j in i.
            doubt: Keyframe up to which wheels alone may be off by (2,) [m, rad] if it holds.
        """
        pair = (min(i, j), max(i, j))
        if pair not in self._linked:
            self._linked.add(pair)
            self._closing.add(pair)
            self._graph.add_image_motion(
                i, j, link.T_keyframe_cam, link.covariance, closes=True, doubt=doubt
            )
            self.poses = self._graph.update()
        return pair not in self._closing or not {(i, j), (j, i)}.isdisjoint(self.closures)

    def tie(self, reference: int, keyframe: int, T_i_j: SE3, way: NDArray[np.float64]) -> None:
        """The robot knows its place again: a way by wheels alone ends there, once, and solve.

        Args:
            reference: Keyframe that dead reckoning refers to.
            keyframe: The one that shows the place.
            T_i_j: Its camera in the reference's, by dead reckoning.
            way: (2,) how far the robot drove and turned since then [m, rad].
        """
        pair = (min(reference, keyframe), max(reference, keyframe))
        if pair not in self._linked | self._tied:
            self._tied.add(pair)
            self._add_blind_motion(reference, keyframe, T_i_j, way)
            self.poses = self._graph.update()

    def _add_blind_motion(self, i: int, j: int, T_i_j: SE3, way: NDArray[np.float64]) -> None:
        T_base_i_base_j = self._T_base_cam @ T_i_j @ invert(self._T_base_cam)
        self._graph.add_wheel_motion(i, j, T_base_i_base_j, way)

    def refer_to(self, keyframe: int, found: RelativePose, now: DeadReckonedPose | None) -> None:
        """The camera was found there in a keyframe: dead reckoning goes on from it."""
        if now is not None:
            T_cam_keyframe = invert(found.T_keyframe_cam)
            T_base_keyframe = self._T_base_cam @ T_cam_keyframe @ invert(self._T_base_cam)
            there = now.at(T_base_keyframe, found.heading_variance(self._T_base_cam))
            self._keyframes[keyframe] = replace(self._keyframes[keyframe], reckoning=there)
        self._recent = [other for other in self._recent if other != keyframe] + [keyframe]

    def forget_ways(self) -> None:
        """The robot was carried: dead reckoning knows the way from nowhere."""
        self._recent.clear()

    def _add(self, keyframe: int, features: Features, reckoning: DeadReckonedPose | None) -> None:
        self._keyframes[keyframe] = Keyframe(features, reckoning)
        self._recent.append(keyframe)
        if len(features) == 0:
            self._blank.append(keyframe)
        self._places.add(keyframe, features)
