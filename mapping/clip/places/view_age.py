"""Which views of places count no longer, since newer ones tell of the same.

A picture of long ago gives way to one that was taken from the same spot with the same heading. What
it showed of a place is in doubt, too, where two later pictures looked there from near and had the
very point in view: then they show the thing, or that it has gone. All of it follows from poses and
times alone, so that a loop closure needs no account of what was forgotten before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vizbot.core.types import SE3, Intrinsics

LATER = 300.0
"""A picture this much later than another one is news of what both show [s]."""
SPOT = 0.5
"""Edge of a spot, a cell of the plan on which the camera stands [m]."""
HEADINGS = 12
"""Headings of the camera on a spot that count as different views."""
NEAR_LOOK = 3.0
"""Looks from within this distance tell what a place shows today [m]."""


def view_of(T_map_cam: SE3) -> tuple[int, int, int]:
    """Column and row of the spot on which a picture was taken, and the number of its heading."""
    column, row, turn = _views_of(T_map_cam[None])[0].tolist()
    return column, row, turn


def _views_of(Ts_map_cam: NDArray[np.float64]) -> NDArray[np.int64]:
    """The same (F, 3) of many pictures (F, 4, 4)."""
    spots = np.floor(Ts_map_cam[:, :2, 3] / SPOT)
    headings = np.arctan2(Ts_map_cam[:, 1, 2], Ts_map_cam[:, 0, 2])
    turns = np.round(headings / (2 * np.pi / HEADINGS)) % HEADINGS
    return np.column_stack([spots, turns]).astype(np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class ViewAge:
    """How new views of places (R,) are.

    Attributes:
        retaken: (R,) whether the same picture was taken again later: the view counts no longer.
        doubted: (R,) whether two later pictures from near had its point in view: it counts where
            they, too, speak for what is asked for.
    """

    retaken: NDArray[np.bool_]
    doubted: NDArray[np.bool_]


def age_of_views(
    places: NDArray[np.int64],
    points: NDArray[np.float32],
    ranges: NDArray[np.float32],
    frame_of: NDArray[np.intp],
    Ts_map_cam: NDArray[np.float64],
    times: NDArray[np.float64],
    intrinsics: Intrinsics,
) -> ViewAge:
    """How new views of places (R,) are.

    Args:
        places: (R, 2) column, row of the place that each shows.
        points: (R, 3) of what each shows there, in `map` [m].
        ranges: (R,) distance of the place from the camera on the plan [m].
        frame_of: (R,) row of the frame that each is of, not falling.
        Ts_map_cam: (F, 4, 4) where the frames were taken.
        times: (F,) when, not falling [s].
        intrinsics: Of the camera.
    """
    doubted = np.zeros(len(places), np.bool_)
    if len(places) == 0 or times[frame_of[-1]] - times[frame_of[0]] < LATER:
        return ViewAge(doubted, doubted)
    low = places.min(axis=0)
    span = int(places[:, 0].max() - low[0]) + 1
    keys = (places[:, 1] - low[1]) * span + places[:, 0] - low[0]
    order = np.argsort(keys, kind="stable")
    starts = np.flatnonzero(np.diff(keys[order], prepend=-1, append=-1) != 0)
    c = intrinsics
    edges = np.array([[-c.cx, c.width - c.cx], [-c.cy, c.height - c.cy]])
    field = edges / np.array([[c.fx], [c.fy]])
    from mapping.clip.places.later_looks import mark_looked_twice  # loads numba

    mark_looked_twice(
        order, starts, points, ranges, frame_of, Ts_map_cam, times, field, doubted, LATER, NEAR_LOOK
    )
    return ViewAge(_retaken(frame_of, Ts_map_cam, times)[frame_of], doubted)


def _retaken(
    frame_of: NDArray[np.intp], Ts_map_cam: NDArray[np.float64], times: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Which frames (F,) were taken again later; frames that show no place are none again."""
    shows = np.flatnonzero(np.bincount(frame_of, minlength=len(times)))
    _, view = np.unique(_views_of(Ts_map_cam[shows]), axis=0, return_inverse=True)
    last = np.full(len(times), -np.inf)
    np.maximum.at(last, view.ravel(), times[shows])
    retaken = np.zeros(len(times), np.bool_)
    retaken[shows] = times[shows] + LATER <= last[view.ravel()]
    return retaken
