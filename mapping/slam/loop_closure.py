"""Loops: what a frame or a new keyframe shows that older keyframes show as well."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.selection import is_covered, is_due
from mapping.keyframes.tracked_pose import TrackedPose
from mapping.keyframes.wheel_only_motion import apart
from mapping.odometry.features import Features
from mapping.odometry.gating import may_link
from mapping.odometry.rgbd_odometry import RelativePose, chained, reversed_pose
from mapping.slam.config import SlamConfig
from mapping.slam.place_search import PlaceSearch
from vizbot.core.geometry import invert
from vizbot.core.types import SE3


class LoopClosure:
    """Closes loops; where one is closed from a frame, the older keyframe is the reference then."""

    def __init__(
        self, where: TrackedPose, search: PlaceSearch, T_base_cam: SE3, config: SlamConfig
    ) -> None:
        self._where = where
        self._T_base_cam = T_base_cam
        self._search = search
        self._config = config
        self._guesses: list[tuple[SE3, SE3]] = []
        self._doubted: int | None = None

    def fall_back(self, features: Features, measured: RelativePose) -> RelativePose | None:
        """Close the loop to an older keyframe near by that shows the same; the frame in it.

        Args:
            features: Of a frame that would become a keyframe.
            measured: It in the reference.
        """
        where, config = self._where, self._config
        near = where.places.nearby(where.T_map_cam, but=where.reference)
        for keyframe in near[: config.nearby_tries]:
            expected = invert(where.places.poses[keyframe]) @ where.T_map_cam
            if not is_covered(expected, config.keyframes):
                continue
            found = where.against(keyframe, features, expected, config.closure_search)
            if found is None or is_due(
                where.places[keyframe], found.T_keyframe_cam, found, config.keyframes
            ):
                continue
            if self._may_link(found, expected) and self._closes(measured, keyframe, found):
                return found
        return None

    def rejoin(self, features: Features, measured: RelativePose) -> RelativePose | None:
        """Close the loop to the map of before wheels alone had the word, if that shows the frame.

        Light came back on something new, as far off as the wheels may have spun. Rows of windows
        and fences look alike from place to place, so another view, turned well aside, must lead to
        the same. Arguments and result are those of `fall_back`.
        """
        where = self._where
        if not where.blind.adrift:
            self._doubted = None
            return None
        for keyframe, found in self._search.striking(features):
            T_old_cam = where.places.poses[keyframe] @ found.T_keyframe_cam
            way = self._way_that_explains(keyframe, T_old_cam)
            if way is not None:
                confirmed = self._is_confirmed(way[0], where.T_map_cam, T_old_cam)
                holds = confirmed and self._closes(measured, keyframe, found, way)
                return found if holds else None
        return None

    def _way_that_explains(
        self, keyframe: int, T_old_cam: SE3
    ) -> tuple[int, NDArray[np.float64]] | None:
        """The newest way since a keyframe on which wheels may have put the camera so far off.

        Returns:
            The first keyframe behind it, and how far off that may be (2,) [m, rad].
        """
        where, gates = self._where, self._config.gates
        apart_now = apart(where.T_map_cam, T_old_cam)
        for way in reversed(where.blind.adrift):
            off = gates.wheel_gate + gates.spin * way.motion
            heading = gates.wheel_gate + gates.spin * way.turned_by_wheels
            off[0] += heading * apart(where.T_map_cam, where.places.poses[way.first])[0]
            if keyframe < way.first and (apart_now <= off).all():
                return way.first, off
        return None

    def _is_confirmed(self, first: int, T_map_cam: SE3, T_old_cam: SE3) -> bool:
        """Whether most of the guesses before led the same way, one of them from well aside.

        Those count that were made since the same way was doubted, the one up to keyframe `first`.
        """
        agreement, count = (
            self._config.relocalisation.agreement,
            self._config.relocalisation.guesses,
        )
        if first != self._doubted:
            self._guesses, self._doubted = [], first
        turns = [
            apart(T_guess_cam, T_map_cam)[1]
            for T_old_map, T_guess_cam in self._guesses
            if (apart(T_old_map @ T_map_cam, T_old_cam) <= agreement).all()
        ]
        most = 2 * len(turns) > len(self._guesses)
        self._guesses = [*self._guesses, (T_old_cam @ invert(T_map_cam), T_map_cam)][-count:]
        return most and max(turns) >= self._config.keyframes.closure_angle

    def links(self, features: Features, measured: RelativePose | None) -> dict[int, RelativePose]:
        """A new keyframe in the reference, in the last few, and in the nearest of those before."""
        where, config = self._where, self._config
        links = {} if measured is None else {where.reference: measured}
        near = where.places.nearby(where.T_map_cam, but=where.reference)
        recent = [keyframe for keyframe in near if where.places.is_recent(keyframe)]
        older = [keyframe for keyframe in near if not where.places.is_recent(keyframe)]
        for keyframe in recent + older[: config.keyframes.closures]:
            expected = invert(where.places.poses[keyframe]) @ where.T_map_cam
            share = config.closure_search if keyframe in older else config.search
            found = where.against(keyframe, features, expected, share, once=True)
            if found is not None and self._may_link(found, expected):
                links[keyframe] = found
                where.blind.close_spans(keyframe)
        return links

    def _may_link(self, found: RelativePose, expected: SE3) -> bool:
        on_floor = None if self._where.reckoning is None else self._T_base_cam
        return may_link(found, expected, on_floor, self._config.gates)

    def _closes(
        self,
        measured: RelativePose,
        keyframe: int,
        found: RelativePose,
        doubt: tuple[int, NDArray[np.float64]] | None = None,
    ) -> bool:
        """Whether the loop to a keyframe holds; then it is the reference."""
        where, link = self._where, chained(measured, reversed_pose(found))
        if not where.places.close(where.reference, keyframe, link, doubt):
            return False
        where.refer_to(keyframe, found)
        return True
