"""All keyframes of a run: what they show, and the pose graph between them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.anchors import Keyframes, KeyframeViews
from mapping.keyframes.config import KeyframeConfig, PlaceIndexConfig, PoseGraphConfig
from mapping.keyframes.frame import Frame, Keyframe
from mapping.keyframes.frame_matcher import FrameMatcher
from mapping.keyframes.place_index import PlaceIndex
from mapping.keyframes.pose_graph import PoseGraph
from mapping.odometry.config import GatingConfig
from mapping.odometry.dead_reckoned_pose import DeadReckonedPose, agrees_with_gyro
from mapping.odometry.features import Features
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.types import SE3


class KeyframeMap:
    """All keyframes of a run.

    Attributes:
        poses: T_map_cam of every keyframe by its id, after the latest update of the graph.
        matcher: Measures frames in its keyframes.
    """

    def __init__(
        self,
        matcher: FrameMatcher,
        T_base_cam: SE3,
        keyframes: KeyframeConfig,
        graph: PoseGraphConfig,
        places: PlaceIndexConfig,
        gates: GatingConfig,
    ) -> None:
        self.poses: dict[int, SE3] = {}
        self.matcher = matcher
        self._T_base_cam = T_base_cam
        self._config = keyframes
        self._gates = gates
        self._graph = PoseGraph(T_base_cam, graph)
        self._places = PlaceIndex(places)
        self._keyframes: dict[int, Keyframe] = {}
        self._recent: list[int] = []
        self._linked: set[tuple[int, int]] = set()
        self._closing: set[tuple[int, int]] = set()
        self._wheel_linked: set[tuple[int, int]] = set()
        self._blank: list[int] = []

    def __getitem__(self, keyframe: int) -> Keyframe:
        return self._keyframes[keyframe]

    @property
    def closures(self) -> list[tuple[int, int]]:
        """Pairs of keyframes between which a loop is closed."""
        return self._graph.closures

    def recent(self) -> list[int]:
        """Ids of the keyframes since which dead reckoning still gives the motion."""
        return self._recent[-self._config.links :]

    def track(self, frame: Frame, last: Frame, shares: tuple[float, ...]) -> RelativePose | None:
        """Measure a frame in its reference keyframe; arguments as for `FrameMatcher.track`."""
        return self.matcher.track(self._keyframes[frame.reference], frame, last, shares)

    def matches(
        self, frame: Frame, expected: Mapping[int, tuple[SE3, float]], *, once: bool = False
    ) -> dict[int, RelativePose]:
        """Measure a frame in several keyframes, as `FrameMatcher.match` does.

        `expected` has of each keyframe, by its id, the predicted pose of the frame in it, and the
        radius of the search; `once` is as for `FrameMatcher.match`.

        Returns:
            The frame in those keyframes that it matches. The gyroscope has a say as long as dead
            reckoning gives the motion since a keyframe.
        """
        recent, found = self.recent(), {}
        for keyframe, (T_keyframe_cam, share) in expected.items():
            now = frame.dead_reckoned if keyframe in recent else None
            match = self.matcher.match(
                self._keyframes[keyframe], frame.features, T_keyframe_cam, share, now, once=once
            )
            if match is not None:
                found[keyframe] = match
        return found

    def is_due(self, keyframe: int, T_keyframe_cam: SE3, measured: RelativePose | None) -> bool:
        """Whether a frame at `T_keyframe_cam` of a keyframe should become the next."""
        if not self.is_covered(T_keyframe_cam):
            return True
        config = self._config
        corners = len(self._keyframes[keyframe].features.pixels)
        enough = min(config.inliers, config.inlier_share * corners)
        return measured is not None and measured.inliers < enough

    def show_less(self, keyframes: Iterable[int], corners: int) -> bool:
        """Whether each of some keyframes shows fewer corners than that."""
        return all(len(self._keyframes[each].features.pixels) < corners for each in keyframes)

    def is_covered(self, T_keyframe_cam: SE3) -> bool:
        """Whether a keyframe shows what a frame at `T_keyframe_cam` of it shows."""
        near = np.linalg.norm(T_keyframe_cam[:3, 3]) < self._config.distance
        return bool(near and rotation_angle(T_keyframe_cam) < self._config.angle)

    def nearby(self, T_map_cam: SE3, but: int | None = None) -> list[int]:
        """Ids of keyframes that may see what a camera sees, nearest first, without `but`."""
        config = self._config
        keyframes = np.array([each for each in self._keyframes if each != but], np.int64)
        if len(keyframes) == 0:
            return []
        Ts_near = np.stack([self.poses[keyframe] for keyframe in keyframes.tolist()])
        distances = np.linalg.norm(Ts_near[:, :3, 3] - T_map_cam[:3, 3], axis=1)
        traces = np.einsum("nij,ij->n", Ts_near[:, :3, :3], T_map_cam[:3, :3])
        angles = np.arccos(np.clip((traces - 1) / 2, -1, 1))
        remoteness = distances / config.closure_distance + angles / config.closure_angle
        near = (distances <= config.closure_distance) & (angles <= config.closure_angle)
        order = np.argsort(remoteness[near], kind="stable")
        return [int(keyframe) for keyframe in keyframes[near][order]]

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

    def add_first(self, frame: Frame) -> int:
        """Add the first keyframe, with the base at the map's origin; return its id."""
        self._add(0, frame.features, frame.dead_reckoned)
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
        frame: Frame,
        features: Features,
        links: Mapping[int, RelativePose],
        wheel_only: NDArray[np.float64],
    ) -> int:
        """Add a keyframe and solve; return its id.

        Of its corners `features` are kept; `links` are the new camera in other keyframes by images,
        by id; `wheel_only` (2,) is distance and turn since the reference that images did not see
        [m, rad].
        """
        dead_reckoned, reference = frame.dead_reckoned, frame.reference
        new, before = max(self._keyframes) + 1, self._keyframes[reference].dead_reckoned
        T_map_cam = self.poses[reference] @ frame.T_reference_cam
        recent = self.recent()
        self._add(new, features, dead_reckoned)
        by_gyro: tuple[SE3, float] | None = None
        if dead_reckoned is not None and before is not None:
            by_wheels = dead_reckoned.by_wheels_since(before)
            believed = frame.measured is None or agrees_with_gyro(
                self._T_base_cam @ frame.measured.T_keyframe_cam @ invert(self._T_base_cam),
                before,
                dead_reckoned,
                self._gates,
            )
            # Else both are of the same image.
            is_later = dead_reckoned.stamp > before.stamp
            if believed and is_later and dead_reckoned.gyro_since(before):
                sigma = dead_reckoned.chained_gyro_sigma_since(before)
                by_gyro = dead_reckoned.since(before), sigma
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
            elif is_later:
                self._graph.add_wheel_motion(reference, new, by_wheels)
            if by_gyro is not None:
                self._graph.add_gyro_turn(reference, new, *by_gyro)
        elif not links:
            T_reference_cam = invert(self.poses[reference]) @ T_map_cam
            self._graph.add_unknown_motion(reference, new, T_reference_cam)
        self.poses = self._graph.update()
        return new

    def close_loop(
        self,
        i: int,
        j: int,
        link: RelativePose,
        wheel_slack: tuple[int, NDArray[np.float64]] | None = None,
    ) -> bool:
        """Link keyframes i and j that see the same place, and solve; whether the loop holds.

        A link that the rest of the graph contradicts is removed, and not tried again.

        `link` is camera j in i. Up to the keyframe of `wheel_slack` wheels alone may have erred if
        the loop holds, by its bound (2,) at most [m, rad].
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

        `T_i_j` is the camera of `keyframe` in `reference`, to which dead reckoning refers;
        `wheel_only` (2,) is distance and turn of the stretch [m, rad].
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
        if len(features.pixels) == 0:
            self._blank.append(keyframe)
        self._places.add(keyframe, features)
