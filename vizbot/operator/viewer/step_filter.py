"""Which steps of a robot that rests are worth a picture: a day of the same one fills a disk."""

from __future__ import annotations

import numpy as np

from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.observer import Step

_EVERY = 10.0
"""While nothing changes one step is shown in so long [s]."""
_MOVED, _TURNED = 0.02, 0.02
"""A robot that rests was moved if it is off by more [m, rad]."""


class StepFilter:
    """Compares each step with the last one that was shown."""

    def __init__(self) -> None:
        """Nothing has been shown yet."""
        self._shown: Step | None = None

    def is_news(self, step: Step) -> bool:
        """Whether a step is to be shown, as it then is; call once for each."""
        shown = self._shown
        news = (
            shown is None
            or step.command is not None
            or step.frame.stamp - shown.frame.stamp >= _EVERY
            or _told(step) != _told(shown)
            or _has_moved(shown, step)
        )
        if news:
            self._shown = step
        return news


def _told(step: Step) -> tuple[object, ...]:
    sizes = len(step.points), len(step.keyframe_poses), len(step.closures)
    return step.goal, step.activity, step.estimate.tracking, *sizes


def _has_moved(shown: Step, step: Step) -> bool:
    T_shown_base = invert(shown.T_map_base) @ step.T_map_base
    moved = float(np.linalg.norm(T_shown_base[:3, 3]))
    return moved > _MOVED or rotation_angle(T_shown_base) > _TURNED
