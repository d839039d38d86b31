"""All keyframes of a run: what they show, and the pose graph between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.anchors import Keyframes, KeyframeViews
from mapping.keyframes.config import KeyframeConfig, PlaceIndexConfig, PoseGraphConfig
from mapping.keyframes.place_index import PlaceIndex
from mapping.keyframes.pose_graph import PoseGraph
from mapping.keyframes.selection import Keyframe, nearby
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
        self.poses: dict[int, SE3] = {}
        self._T_base_cam = T_base_cam
        self._config = keyframes
        self._graph = PoseGraph(T_base_cam, graph)
        self._places = PlaceIndex(places)
        self._keyframes: dict[int, Keyframe] = {}
        self._recent: list[int] = []
        self._linked: set[tuple[int, int]] = set()
        self._closing: set[tuple[int, int]] = set()
        self._wheel_linked: set[tuple[int, int]] = set()
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
        """Whether dead reckoning still gives the motion since a keyframe."""
        return keyframe in self._recent[-self._config.links :]

    def dead_reckoned_from(
        self, keyframe: int, now: DeadReckonedPose | None
    ) -> DeadReckonedPose | None:
        """Dead reckoning `now`, if it still gives the motion since a keyframe; else None."""
        return now if self.is_recent(keyframe) else None

    def nearby(self, T_map_cam: SE3, but: int | None = None) -> list[int]:
        """Ids of keyframes that may see what a camera sees, nearest first, without `but`."""
        others = (keyframe for keyframe in self._keyframes if keyframe != but)
        return nearby(self.poses, others, T_map_cam, self._config)

    def nearest(self, T_map_cam: SE3) -> int:
        """Id of the keyframe nearest to a camera in distance plus angle."""

        def off(keyframe: int) -> float:
            T_keyframe_cam = invert(self.poses[keyframe]) @ T_map_cam
            return float(np.linalg.norm(T_keyframe_cam[:3, 3])) + rotation_angle(T_keyframe_cam)

        return min(self.poses, key=off)

    def nearest_blank(self, T_map_cam: SE3) -> int | None:
        """Id of the nearest keyframe without corners, if one is near enough to be reused."""
        off = {k: float(np.linalg.norm((self.poses[k] - T_map_cam)[:3, 3])) for k in self._blank}
        nearest = min(off, key=off.__getitem__, default=None)
        near = nearest is not None and off[nearest] <= self._config.blank_distance
        return nearest if near else None

    def most_similar(self, features: Features, count: int) -> list[int]:
        """Ids of the keyframes that look most like an image, the best first."""
        return [keyframe for keyframe, _ in self._places.most_similar(features, count)]

    def add_first(self, features: Features, dead_reckoned: DeadReckonedPose | None) -> int:
        """Add the first keyframe, with the base at the map's origin; return its id."""
        self._add(0, features, dead_reckoned)
        self._graph.add_keyframe(0, self._T_base_cam, fixed=True)
        self.poses = self._graph.update()
        return 0

    def restore(self, keyframes: Keyframes, views: KeyframeViews) -> None:
        """Add the keyframes of a saved map at their poses, which stay fixed."""
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

    def features(self) -> dict[int, Features]:
        """What every keyframe shows, by its id; it stays so when the map goes on."""
        return {keyframe: each.features for keyframe, each in self._keyframes.items()}

    def insert(
        self,
        features: Features,
        dead_reckoned: DeadReckonedPose | None,
        T_map_cam: SE3,
        reference: int,
        links: Mapping[int, RelativePose],
        wheel_only: NDArray[np.float64],
        *,
        gyro: bool,
    ) -> int:
        """Add a keyframe and solve.

        Args:
            features: Its corners.
            dead_reckoned: Dead reckoning at the keyframe; None without wheels.
            T_map_cam: Its pose before solving.
            reference: Id of the keyframe that dead reckoning and the frames until now refer to.
            links: The new camera in other keyframes by images, by id.
            wheel_only: (2,) distance and turn since the reference that images did not see
                [m, rad].
            gyro: Whether the gyroscope is believed since the reference.

        Returns:
            The id of the new keyframe.
        """
        new, before = max(self._keyframes) + 1, self._keyframes[reference].dead_reckoned
        recent = {keyframe for keyframe in links if self.is_recent(keyframe)}
        self._graph.add_keyframe(new, T_map_cam)
        # All links share the noise of the new image: they say less than independent ones would.
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
        if dead_reckoned is not None:
            self._graph.add_floor(new, T_map_cam)
        if dead_reckoned is not None and before is not None:
            if reference not in links:
                # Images gave part of the motion until they failed.
                T_reference_new = invert(self.poses[reference]) @ T_map_cam
                self._add_wheel_only_motion(reference, new, T_reference_new, wheel_only)
            elif dead_reckoned.stamp > before.stamp:  # else both are of the same image
                motion = dead_reckoned.by_wheels_since(before)
                self._graph.add_wheel_motion(reference, new, motion)
            if gyro and dead_reckoned.stamp > before.stamp and dead_reckoned.gyro_since(before):
                sigma = dead_reckoned.chained_gyro_sigma_since(before)
                self._graph.add_gyro_turn(reference, new, dead_reckoned.since(before), sigma)
        elif not links:
            T_reference_cam = invert(self.poses[reference]) @ T_map_cam
            self._graph.add_unknown_motion(reference, new, T_reference_cam)
        self._add(new, features, dead_reckoned)
        self.poses = self._graph.update()
        return new

    def close_loop(
        self,
        i: int,
        j: int,
        link: RelativePose,
        wheel_slack: tuple[int, NDArray[np.float64]] | None = None,
    ) -> bool:
        """Link two keyframes that see the same place, once, and solve.

        A link that the rest of the graph contradicts is removed, and not tried again.

        Args:
            i: Id of a keyframe.
            j: Id of a keyframe.
            link: Camera j in i.
            wheel_slack: Id of the keyframe up to which wheels alone may have erred if the loop
                holds, and the bound (2,) of that error [m, rad].

        Returns:
            Whether the loop holds.
        """
        pair = (min(i, j), max(i, j))
        if pair not in self._linked:
            self._linked.add(pair)
            self._closing.add(pair)
            self._graph.add_image_motion(
                i, j, link.T_keyframe_cam, link.covariance, closes=True, wheel_slack=wheel_slack
            )
            self.poses = self._graph.update()
        return pair not in self._closing or not {(i, j), (j, i)}.isdisjoint(self.closures)

    def add_wheel_only_link(
        self, reference: int, keyframe: int, T_i_j: SE3, wheel_only: NDArray[np.float64]
    ) -> None:
        """Link the two ends of a wheel-only stretch after which images found the robot, and solve.

        Two keyframes are linked once at most.

        Args:
            reference: Id of the keyframe that dead reckoning refers to.
            keyframe: Id of the keyframe in which images found the robot.
            T_i_j: Camera of `keyframe` in `reference`, by dead reckoning.
            wheel_only: (2,) distance and turn of the stretch [m, rad].
        """
        pair = (min(reference, keyframe), max(reference, keyframe))
        if pair not in self._linked | self._wheel_linked:
            self._wheel_linked.add(pair)
            self._add_wheel_only_motion(reference, keyframe, T_i_j, wheel_only)
            self.poses = self._graph.update()

    def _add_wheel_only_motion(
        self, i: int, j: int, T_i_j: SE3, wheel_only: NDArray[np.float64]
    ) -> None:
        T_base_i_base_j = self._T_base_cam @ T_i_j @ invert(self._T_base_cam)
        self._graph.add_wheel_motion(i, j, T_base_i_base_j, wheel_only)

    def restart_dead_reckoning(
        self, keyframe: int, found: RelativePose, now: DeadReckonedPose | None
    ) -> None:
        """Let dead reckoning start at a keyframe in which images found the camera `now`."""
        if now is not None:
            T_cam_keyframe = invert(found.T_keyframe_cam)
            T_base_keyframe = self._T_base_cam @ T_cam_keyframe @ invert(self._T_base_cam)
            there = now.displaced(T_base_keyframe, found.heading_variance(self._T_base_cam))
            self._keyframes[keyframe] = replace(self._keyframes[keyframe], dead_reckoned=there)
        self._recent = [other for other in self._recent if other != keyframe] + [keyframe]

    def forget_dead_reckoning(self) -> None:
        """Drop the motion since all keyframes, since the robot was carried."""
        self._recent.clear()

    def _add(
        self, keyframe: int, features: Features, dead_reckoned: DeadReckonedPose | None
    ) -> None:
        self._keyframes[keyframe] = Keyframe(features, dead_reckoned)
        self._recent.append(keyframe)
        if len(features) == 0:
            self._blank.append(keyframe)
        self._places.add(keyframe, features)
