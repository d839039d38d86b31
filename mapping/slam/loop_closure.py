"""Loop closure: links to older keyframes that show what a frame or a new keyframe shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.frame import Frame, KeyframeMatch
from mapping.keyframes.keyframe_map import KeyframeMap
from mapping.keyframes.wheel_only_motion import WheelOnlySpan, pose_difference
from mapping.odometry.dead_reckoned_pose import may_link
from mapping.odometry.rgbd_odometry import RelativePose, chained, reversed_pose
from mapping.relocalisation.relocaliser import Relocaliser
from mapping.slam.config import SlamConfig
from vizbot.core.geometry import invert
from vizbot.core.types import SE3


class LoopClosure:
    """Closes loops in the map; it reads frames and does not change them."""

    def __init__(
        self,
        keyframe_map: KeyframeMap,
        relocaliser: Relocaliser,
        T_base_cam: SE3,
        config: SlamConfig,
    ) -> None:
        self._map = keyframe_map
        self._relocaliser = relocaliser
        self._T_base_cam = T_base_cam
        self._config = config
        self._hypotheses: list[tuple[SE3, SE3]] = []
        self._doubted_first: int | None = None

    def close(self, frame: Frame, spans: Sequence[WheelOnlySpan]) -> KeyframeMatch | None:
        """Close the loop to an older keyframe that shows the same as a frame.

        Keyframes near by come first. If none of them does, the frame may match the map from before
        a wheel-only stretch: images came back on something new, as far off as the wheels may have
        spun. Rows of windows and fences look alike from place to place, so another view, turned
        well aside, must lead to the same place.

        Args:
            frame: Measured in its reference, and due to become a keyframe.
            spans: Wheel-only stretches that no loop has closed, the oldest first.

        Returns:
            The older keyframe, which serves as the reference from now on; None if no loop closes.
        """
        config, keyframes = self._config, self._map
        near = keyframes.nearby(self._in_map(frame), but=frame.reference)
        for keyframe in near[: config.nearby_tries]:
            # A loop that does not hold may have moved the keyframes.
            T_map_cam = keyframes.poses[frame.reference] @ frame.T_reference_cam
            expected = invert(keyframes.poses[keyframe]) @ T_map_cam
            if not keyframes.is_covered(expected):
                continue
            matches = keyframes.matches(frame, {keyframe: (expected, config.closure_search_radius)})
            for found in matches.values():
                if keyframes.is_due(keyframe, found.T_keyframe_cam, found):
                    continue
                match = KeyframeMatch(keyframe, found)
                on_floor = None if frame.dead_reckoned is None else self._T_base_cam
                if not may_link(found, expected, on_floor, config.gates):
                    continue
                if self._closes(frame, match):
                    return match
        return self._close_over(spans, frame) if spans else None

    def _close_over(self, spans: Sequence[WheelOnlySpan], frame: Frame) -> KeyframeMatch | None:
        # Keyframes after the newest stretch say nothing about any stretch.
        for match in self._relocaliser.sure_matches(frame.features, before=spans[-1].first):
            T_old_cam = self._map.poses[match.keyframe] @ match.pose.T_keyframe_cam
            T_map_cam = self._in_map(frame)
            slack = self._explaining_slack(match.keyframe, T_old_cam, T_map_cam, spans)
            if slack is not None:
                confirmed = self._is_confirmed(slack[0], T_map_cam, T_old_cam)
                return match if confirmed and self._closes(frame, match, slack) else None
        return None

    def _explaining_slack(
        self, keyframe: int, T_old_cam: SE3, T_map_cam: SE3, spans: Sequence[WheelOnlySpan]
    ) -> tuple[int, NDArray[np.float64]] | None:
        """The newest span since a keyframe on which wheels may have erred that much.

        Returns:
            The first keyframe after the span, and the bound (2,) of the error [m, rad].
        """
        gates = self._config.gates
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

    def links(self, frame: Frame) -> dict[int, RelativePose]:
        """Measure a new keyframe in its reference, in the last few, and in the nearest older ones.

        Returns:
            The new camera in each keyframe that it may be linked to, by id.
        """
        config, keyframes = self._config, self._map
        T_map_cam = self._in_map(frame)
        near, newest = keyframes.nearby(T_map_cam, but=frame.reference), keyframes.recent()
        recent = [keyframe for keyframe in near if keyframe in newest]
        older = [keyframe for keyframe in near if keyframe not in newest]
        expected = {
            keyframe: (invert(keyframes.poses[keyframe]) @ T_map_cam, share)
            for some, share in (
                (recent, config.search_radius),
                (older[: config.keyframes.closures], config.closure_search_radius),
            )
            for keyframe in some
        }
        links = {} if frame.measured is None else {frame.reference: frame.measured}
        on_floor = None if frame.dead_reckoned is None else self._T_base_cam
        for keyframe, found in keyframes.matches(frame, expected, once=True).items():
            if may_link(found, expected[keyframe][0], on_floor, config.gates):
                links[keyframe] = found
        return links

    def _in_map(self, frame: Frame) -> SE3:
        return self._map.poses[frame.reference] @ frame.T_reference_cam

    def _closes(
        self,
        frame: Frame,
        match: KeyframeMatch,
        wheel_slack: tuple[int, NDArray[np.float64]] | None = None,
    ) -> bool:
        """Link the reference to a keyframe; whether the graph accepts the loop."""
        assert frame.measured is not None
        link = chained(frame.measured, reversed_pose(match.pose))
        return self._map.close_loop(frame.reference, match.keyframe, link, wheel_slack)
