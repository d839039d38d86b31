"""Views of places of a map that was saved without them, as well as its elements tell.

The depth images are gone: each finest patch stands for the place of its mean point, which is
between a thing and what is behind it where a patch shows both.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mapping.clip.footprint import patch_footprint
from mapping.clip.mapper import ClipElements
from mapping.clip.place_rows import PlaceMap, PlaceRows
from vizbot.core.geometry import invert, transform
from vizbot.core.types import SE3

_MOST_PATCHES = 1024
"""A frame with more elements is left out: no camera and no scales give as many."""


def place_rows_of(
    elements: ClipElements,
    Ts_keyframe_cam: NDArray[np.float64],
    keyframe_poses: Mapping[int, SE3],
) -> PlaceRows:
    """The views of places that the elements of a map give.

    Args:
        elements: Of the map, those of a frame one after another.
        Ts_keyframe_cam: (F, 4, 4) of all frames in their keyframes.
        keyframe_poses: T_map_cam of every keyframe.
    """
    places, frames = PlaceMap(), elements.frames
    cuts = np.flatnonzero(np.diff(frames)) + 1
    for rows in np.split(np.arange(len(frames)), cuts):
        if not 0 < len(rows) <= _MOST_PATCHES:
            continue
        keyframe, T_keyframe_cam = (
            int(elements.keyframes[rows[0]]),
            Ts_keyframe_cam[frames[rows[0]]],
        )
        T_map_cam = keyframe_poses[keyframe] @ T_keyframe_cam
        if places.is_new_view(T_map_cam):
            points_cam = transform(invert(T_keyframe_cam), elements.points_keyframe[rows])
            shown = patch_footprint(points_cam, T_map_cam, elements.boxes[rows])
            places.add(keyframe, T_keyframe_cam, T_map_cam, shown, int(rows[0]))
    return places.rows
