"""How far the robot has moved by wheels alone, which bounds the error of its pose.

Wheels spin. Even so, the robot is off from the pose that they give by no more than some share of
the distance and of the turns that they reported. Images of a known place are believed within that
bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.config import KeyframeConfig
from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True, eq=False)
class WheelOnlySpan:
    """A wheel-only stretch so long that loops to what lies before it are not searched near by.

    Attributes:
        first: Id of the first keyframe after the stretch.
        motion: (2,) length of the stretch [m, rad].
        turned_by_wheels: The part of its turns that no gyroscope measured [rad].
    """

    first: int
    motion: NDArray[np.float64]
    turned_by_wheels: float


class WheelOnlyMotion:
    """Distance and turn, to and fro, over which no image was believed (2,) [m, rad].

    Attributes:
        motion: Since images were last believed.
        spans: Long stretches that no loop has closed, the oldest first.
    """

    def __init__(self) -> None:
        self.motion = np.zeros(2)
        self.spans: list[WheelOnlySpan] = []
        self._turned_by_wheels = 0.0
        self._extends_last_span = False
        self._at_reference = np.zeros(2)

    @property
    def since_reference(self) -> NDArray[np.float64]:
        """The part of `motion` since frames refer to their present keyframe."""
        return self.motion - self._at_reference

    def add_step(self, motion: SE3, by_gyro: bool) -> None:
        """Add the motion from one frame to the next; `by_gyro` if the gyroscope gave its turn."""
        step = pose_difference(np.eye(4), motion)
        self.motion = self.motion + step
        self._turned_by_wheels += 0.0 if by_gyro else float(step[1])

    def reset(self) -> None:
        """Start at zero: an image is believed."""
        self.motion, self._at_reference = np.zeros(2), np.zeros(2)
        self._turned_by_wheels = 0.0
        self._extends_last_span = False

    def reset_reference(self) -> None:
        """Note that frames refer to another keyframe from now on."""
        self._at_reference = self.motion

    def start_span(self, keyframe: int, config: KeyframeConfig) -> None:
        """Note a new keyframe that no image links to another; it starts or extends a span."""
        if (self.motion < (config.closure_distance, config.closure_angle)).all():
            return
        first = self.spans.pop().first if self._extends_last_span else keyframe
        self.spans.append(WheelOnlySpan(first, self.motion, self._turned_by_wheels))
        self._extends_last_span = True

    def branch_span(self) -> None:
        """Note that frames refer to an older blank keyframe: the next span starts there."""
        self.reset_reference()
        self._extends_last_span = False

    def close_spans(self, keyframe: int) -> None:
        """Drop the spans after a keyframe in which images found the robot."""
        if self.spans and keyframe < self.spans[-1].first:
            self.spans = [span for span in self.spans if span.first <= keyframe]
            self._extends_last_span = False


def pose_difference(T_a: SE3, T_b: SE3) -> NDArray[np.float64]:
    """(2,) distance and angle between two poses [m, rad]."""
    T_a_b = invert(T_a) @ T_b
    return np.array([np.linalg.norm(T_a_b[:3, 3]), rotation_angle(T_a_b)])
