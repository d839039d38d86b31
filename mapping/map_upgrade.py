"""Maps of the former schema, 5: they have no table of the frames that were mapped.

All frames of the run are in their trajectory instead, by whose rows the elements name theirs.
"""

from __future__ import annotations

from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

FORMER_SCHEMA = 5
"""Schema of the maps that are read like those of today."""
ADDED = ("frames.numbers", "frames.keyframes", "frames.Ts_keyframe_cam", "frames.times")
"""Arrays that such maps do not have, with `places.frames`."""


def upgraded(arrays: dict[str, NDArray[Any]], created: datetime) -> dict[str, NDArray[Any]]:
    """Arrays as of today, of a map of the former schema that was `created` then.

    Raises:
        ValueError: they refer to frames, or elements, that are not there.
    """
    frame_of, seen_in = arrays["elements.frames"], arrays["places.elements"]
    stamps = arrays["trajectory.stamps"]
    within = frame_of.min(initial=0) >= 0 and frame_of.max(initial=-1) < len(stamps)
    if not within:
        raise ValueError("elements.frames refers to a frame that is not there")
    if not (seen_in.min(initial=0) >= 0 and seen_in.max(initial=-1) < len(frame_of)):
        raise ValueError("places.elements refers to an element that is not there")
    numbers = np.unique(frame_of)
    ago = stamps.max(initial=0.0) - stamps[numbers]
    added = (
        numbers.astype(np.int32),
        arrays["trajectory.keyframes"][numbers],
        arrays["trajectory.Ts_keyframe_cam"][numbers],
        created.timestamp() - ago,
    )
    return (
        arrays | dict(zip(ADDED, added, strict=True)) | {"places.frames": frame_of[seen_in[:, 0]]}
    )
