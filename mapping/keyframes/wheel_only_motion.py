"""The way that wheels alone had the word on: it bounds how far off the robot's place may be.

Wheels spin. However far they have, the robot is no farther from where they put it than some share
of the way that they told of, and that is how far off images are believed that show a known place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.selection import KeyframeConfig
from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True, eq=False)
class WheelOnlySpan:
    """A way so long that what lies before it is not to be looked for near by.

    Attributes:
        first: The first keyframe behind it.
        motion: How long it was (2,) [m, rad].
        turned_by_wheels: How much of the turning no gyroscope knows [rad].
    """

    first: int
    motion: NDArray[np.float64]
    turned_by_wheels: float


class WheelOnlyMotion:
    """How far the robot drove and turned, to and fro, while no image was believed (2,) [m, rad].

    Attributes:
        motion: Since images were last believed.
        adrift: Long ways, oldest first.
    """

    def __init__(self) -> None:
        self.motion = np.zeros(2)
        self.adrift: list[WheelOnlySpan] = []
        self._turned_by_wheels = 0.0
        self._goes_on = False
        self._at_reference = np.zeros(2)

    @property
    def since_reference(self) -> NDArray[np.float64]:
        """The part of `motion` that came after the keyframe was chosen that frames refer to."""
        return self.motion - self._at_reference

    def go(self, motion: SE3, by_gyro: bool) -> None:
        """One step by wheels, of which images know nothing yet, its turn perhaps by gyroscope."""
        step = apart(np.eye(4), motion)
        self.motion = self.motion + step
        self._turned_by_wheels += 0.0 if by_gyro else float(step[1])

    def end(self) -> None:
        """An image is believed."""
        self.motion, self._at_reference = np.zeros(2), np.zeros(2)
        self._turned_by_wheels = 0.0
        self._goes_on = False

    def reset_reference(self) -> None:
        """Frames refer to another keyframe from here on."""
        self._at_reference = self.motion

    def start_span(self, keyframe: int, config: KeyframeConfig) -> None:
        """A keyframe is new that no image links to another."""
        if (self.motion < (config.closure_distance, config.closure_angle)).all():
            return
        first = self.adrift.pop().first if self._goes_on else keyframe
        self.adrift.append(WheelOnlySpan(first, self.motion, self._turned_by_wheels))
        self._goes_on = True

    def branch_span(self) -> None:
        """Frames refer to an older keyframe of the dark: what comes begins another way there."""
        self.reset_reference()
        self._goes_on = False

    def close_spans(self, keyframe: int) -> None:
        """Images know the place in a keyframe: no way that came after it is open any more."""
        if self.adrift and keyframe < self.adrift[-1].first:
            self.adrift = [way for way in self.adrift if way.first <= keyframe]
            self._goes_on = False


def apart(T_a: SE3, T_b: SE3) -> NDArray[np.float64]:
    """(2,) how far two poses are apart, and how far turned [m, rad]."""
    T_a_b = invert(T_a) @ T_b
    return np.array([np.linalg.norm(T_a_b[:3, 3]), rotation_angle(T_a_b)])
