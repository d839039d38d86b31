"""Loop closure: links to older keyframes that show what a frame or a new keyframe shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.frame_matcher import FrameMatcher
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.keyframes.selection import is_covered, is_due
from mapping.keyframes.tracked_pose import KeyframeMatch, TrackedPose
from mapping.keyframes.wheel_only_motion import WheelOnlySpan, pose_difference
from mapping.odometry.features import Features
from mapping.odometry.gating import may_link
from mapping.odometry.rgbd_odometry import RelativePose, chained, reversed_pose
from mapping.slam.config import SlamConfig
from mapping.slam.place_search import PlaceSearch
from vizbot.core.geometry import invert
from vizbot.core.types import SE3


class LoopClosure:
    """Closes loops in the map; it reads the tracked pose and does not change it."""

    def __init__(
        self,
        keyframe_map: KeyframeMap,
        matcher: FrameMatcher,
        search: PlaceSearch,
        T_base_cam: SE3,
        config: SlamConfig,
    ) -> None:
        self._map = keyframe_map
        self._matcher = matcher
        self._search = search
        self._T_base_cam = T_base_cam
        self._config = config
        self._hypotheses: list[tuple[SE3, SE3]] = []
        self._doubted_first: int | None = None

    def close_nearby(
        self, features: Features, measured: RelativePose, pose: TrackedPose
    ) -> KeyframeMatch | None:
        """Close the loop to an older keyframe near by that shows the same as the frame.

        Args:
            features: Corners of a frame that would become a keyframe.
            measured: The frame in its reference keyframe.
            pose: Of the frame.

        Returns:
            The older keyframe, which serves as the reference from now on; None if no loop closes.
        """
        config, keyframes = self._config, self._map
        near = keyframes.nearby(pose.in_map(keyframes.poses), but=pose.reference)
        for keyframe in near[: config.nearby_tries]:
            expected = invert(keyframes.poses[keyframe]) @ pose.in_map(keyframes.poses)
            if not is_covered(expected, config.keyframes):
                continue
            found = self._matched(keyframe, features, expected, config.closure_search_radius, pose)
            if found is None or is_due(
                keyframes[keyframe], found.T_keyframe_cam, found, config.keyframes
            ):
                continue
            match = KeyframeMatch(keyframe, found)
            if self._may_link(found, expected, pose) and self._closes(measured, match, pose):
                return match
        return None

    def close_over_spans(
        self,
        features: Features,
        measured: RelativePose,
        pose: TrackedPose,
        spans: Sequence[WheelOnlySpan],
    ) -> KeyframeMatch | None:
        """Close the loop to the map from before a wheel-only stretch, if the frame matches it.

        Images came back on something new, as far off as the wheels may have spun. Rows of windows
        and fences look alike from place to place, so another view, turned well aside, must lead to
        the same place.

        Args:
            features: As for `close_nearby`.
            measured: As for `close_nearby`.
            pose: As for `close_nearby`.
            spans: Wheel-only stretches that no loop has closed, the oldest first.

        Returns:
            As `close_nearby`.
        """
        if not spans:
            self._doubted_first = None
            return None
        # What was mapped after the newest stretch tells nothing about any.
        for match in self._search.sure_matches(features, before=spans[-1].first):
            T_old_cam = self._map.poses[match.keyframe] @ match.pose.T_keyframe_cam
            slack = self._explaining_slack(match.keyframe, T_old_cam, pose, spans)
            if slack is not None:
                T_map_cam = pose.in_map(self._map.poses)
                confirmed = self._is_confirmed(slack[0], T_map_cam, T_old_cam)
                holds = confirmed and self._closes(measured, match, pose, slack)
                return match if holds else None
        return None

    def _explaining_slack(
        self, keyframe: int, T_old_cam: SE3, pose: TrackedPose, spans: Sequence[WheelOnlySpan]
    ) -> tuple[int, NDArray[np.float64]] | None:
        """The newest span since a keyframe on which wheels may have erred that much.

        Returns:
            The first keyframe after the span, and the bound (2,) of the error [m, rad].
        """
        gates = self._config.gates
        T_map_cam = pose.in_map(self._map.poses)
        error = pose_difference(T_map_cam, T_old_cam)
        for span in reversed(spans):
            bound = gates.wheel_gate + gates.wheel_only_error * span.motion
            heading = gates.wheel_gate + gates.wheel_only_error * span.turned_by_wheels
            bound[0] += heading * pose_difference(T_map_cam, self._map.poses[span.first])[0]
            if keyframe < span.first and (error <= bound).all():
                return span.first, bound
        return None

    def _is_confirmed(self, first: int, T_map_cam: SE3, T_old_cam: SE3) -> bool:
        """Whether most earlier hypotheses agree, one of them from a view turned well aside.

        Only those count that were made since the same span, up to keyframe `first`, was doubted.
        """
        agreement, count = (
            self._config.relocalisation.agreement,
            self._config.relocalisation.remembered_frames,
        )
        if first != self._doubted_first:
            self._hypotheses, self._doubted_first = [], first
        turns = [
            pose_difference(T_guess_cam, T_map_cam)[1]
            for T_old_map, T_guess_cam in self._hypotheses
            if (pose_difference(T_old_map @ T_map_cam, T_old_cam) <= agreement).all()
        ]
        most = 2 * len(turns) > len(self._hypotheses)
        newest = T_old_cam @ invert(T_map_cam), T_map_cam
        self._hypotheses = [*self._hypotheses, newest][-count:]
        return most and max(turns) >= self._config.keyframes.closure_angle

    def links(
        self, features: Features, measured: RelativePose | None, pose: TrackedPose
    ) -> dict[int, RelativePose]:
        """Measure a new keyframe in its reference, in the last few, and in the nearest older ones.

        Returns:
            The new camera in each keyframe that it may be linked to, by id.
        """
        config, keyframes = self._config, self._map
        T_map_cam = pose.in_map(keyframes.poses)
        links = {} if measured is None else {pose.reference: measured}
        near = keyframes.nearby(T_map_cam, but=pose.reference)
        recent = [keyframe for keyframe in near if keyframes.is_recent(keyframe)]
        older = [keyframe for keyframe in near if not keyframes.is_recent(keyframe)]
        for keyframe in recent + older[: config.keyframes.closures]:
            expected = invert(keyframes.poses[keyframe]) @ T_map_cam
            share = config.closure_search_radius if keyframe in older else config.search_radius
            found = self._matched(keyframe, features, expected, share, pose, once=True)
            if found is not None and self._may_link(found, expected, pose):
                links[keyframe] = found
        return links

    def _matched(
        self,
        keyframe: int,
        features: Features,
        expected: SE3,
        share: float,
        pose: TrackedPose,
        *,
        once: bool = False,
    ) -> RelativePose | None:
        now = self._map.dead_reckoned_from(keyframe, pose.dead_reckoned)
        return self._matcher.match(self._map[keyframe], features, expected, share, now, once=once)

    def _may_link(self, found: RelativePose, expected: SE3, pose: TrackedPose) -> bool:
        on_floor = None if pose.dead_reckoned is None else self._T_base_cam
        return may_link(found, expected, on_floor, self._config.gates)

    def _closes(
        self,
        measured: RelativePose,
        match: KeyframeMatch,
        pose: TrackedPose,
        wheel_slack: tuple[int, NDArray[np.float64]] | None = None,
    ) -> bool:
        """Link the reference to a keyframe; whether the graph accepts the loop."""
        link = chained(measured, reversed_pose(match.pose))
        return self._map.close_loop(pose.reference, match.keyframe, link, wheel_slack)
