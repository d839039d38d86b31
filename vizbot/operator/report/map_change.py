"""When a run leaves its map for another one: an empty one, or one that was kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import Step

_EMBEDDED = 2
"""Frames whose elements may arrive in one step: one that was under way, and the step's own."""
_COMPARED = 16
"""So many elements are enough to tell two pictures apart."""
_RIGID = 1e-5
"""Elements of one frame keep their distances, whatever the graph does [m]."""


class MapChange:
    """Tells from the steps alone whether another map has begun: ids and numbers start anew then."""

    def __init__(self) -> None:
        """No step yet."""
        self._before: Step | None = None

    def begins_with(self, step: Step) -> bool:
        """Whether a step is the first of another map than the step before it; call once for each.

        A map only grows: it keeps its keyframes and its elements, and counts its frames.
        """
        before, self._before = self._before, step
        return before is not None and not _goes_on(before, step)


def _goes_on(before: Step, step: Step) -> bool:
    known = len(before.frames)
    return (
        step.frame_number >= before.frame_number
        and before.keyframe_poses.keys() <= step.keyframe_poses.keys()
        and np.array_equal(step.frames[:known], before.frames)
        and np.array_equal(step.boxes[:known], before.boxes)
        and len(np.unique(step.frames[known:])) <= _EMBEDDED
        and np.allclose(_spread(before), _spread(step)[: len(_spread(before))], atol=_RIGID)
    )


def _spread(step: Step) -> NDArray[np.float64]:
    """Distances [m] from the first element to the next ones of its frame."""
    first = step.points[:_COMPARED][step.frames[:_COMPARED] == step.frames[:1]]
    return np.asarray(np.linalg.norm(first - first[:1], axis=1))
