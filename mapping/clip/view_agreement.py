"""Agreement of several keyframes on what stands at a place.

A single view may mislead: a patch at an odd angle, or one that shows a door frame and a chair
behind it and has its mean between the two. What truly stands at a place is seen from further
keyframes, too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

MOST = 1500
"""Number of elements used at most, the most similar ones: the time grows with its square."""


@dataclass(frozen=True, slots=True)
class AgreementRule:
    """How the views of keyframes are combined at a place.

    Attributes:
        floor: Similarity of a keyframe that shows nothing better there.
        radius: Distance on the plan up to which elements belong to a place [m].
        views: Number of keyframes averaged; one gives the best similarity near by.
        falloff: Loss of an element's similarity with its distance from the place [1/m].
    """

    floor: float
    radius: float
    views: int
    falloff: float = 0.0


def agreed_similarities(
    at_xy: NDArray[np.float64],
    points: NDArray[np.float64],
    similarities: NDArray[np.float32],
    keyframes: NDArray[np.int32],
    rule: AgreementRule,
) -> NDArray[np.float32]:
    """Mean of the best similarity in each of the best `rule.views` keyframes around places.

    Args:
        at_xy: (M, 2) the places in `map` [m].
        points: (N, 3) of elements in `map` [m].
        similarities: (N,) of the elements to a query.
        keyframes: (N,) ids of the elements' keyframes.
        rule: How they are combined.

    Returns:
        (M,) `rule.floor` or more.
    """
    chosen = np.flatnonzero(similarities > rule.floor)
    if len(chosen) > MOST:
        chosen = chosen[np.argpartition(similarities[chosen], -MOST)[-MOST:]]
    chosen = chosen[np.argsort(keyframes[chosen], kind="stable")]
    result = np.empty(len(at_xy), np.float32)
    _means(
        result,
        np.ascontiguousarray(at_xy, np.float64),
        np.ascontiguousarray(points[chosen, :2]),
        similarities[chosen],
        keyframes[chosen],
        rule.floor,
        rule.radius,
        rule.views,
        rule.falloff,
    )
    return result


@njit(  # type: ignore[untyped-decorator]
    "void(f4[::1], f8[:,::1], f8[:,::1], f4[::1], i4[::1], f8, f8, i8, f8)",
    cache=True,
    nogil=True,
)
def _means(
    result: NDArray[np.float32],
    at_xy: NDArray[np.float64],
    xy: NDArray[np.float64],
    similarities: NDArray[np.float32],
    keyframes: NDArray[np.int32],
    floor: float,
    radius: float,
    views: int,
    falloff: float,
) -> None:
    """Fill `result`; the elements are ordered by keyframe."""
    best = np.empty(views)
    for i in range(len(at_xy)):
        best[:] = floor
        j = 0
        while j < len(xy):
            keyframe, most = keyframes[j], floor
            while j < len(xy) and keyframes[j] == keyframe:
                dx, dy = xy[j, 0] - at_xy[i, 0], xy[j, 1] - at_xy[i, 1]
                distance = np.sqrt(dx * dx + dy * dy)
                if distance <= radius:
                    most = max(most, similarities[j] - falloff * distance)
                j += 1
            least = np.argmin(best)
            best[least] = max(best[least], most)
        result[i] = best.mean()
