"""Steps of a run that leaves its map for another one: `OLD`, then `EMPTY` or `KEPT`."""

from dataclasses import replace

import numpy as np

from tests.helpers.served import scored
from tests.helpers.served import step as standing
from vizbot.core.geometry import planar

RNG = np.random.default_rng(0)
BOX = np.array([8, 4, 16, 12], np.int32)


def mapped(index, number, keyframes, frames, points=None, map_number=0):
    """A step with the frame of this number, and elements of these frames."""
    step = standing(index, 0.1 * index)
    newest = keyframes[-1]
    points = RNG.uniform(-3, 3, (len(frames), 3)) if points is None else points
    return scored(
        step,
        points,
        np.full(len(frames), 0.4),
        frame_number=number,
        map_number=map_number,
        estimate=replace(step.estimate, keyframe=newest, is_keyframe=True),
        keyframe_poses={i: planar(0.1 * i, 0.0, 0.0) for i in keyframes},
        frames=np.array(frames, np.int32),
        boxes=np.tile(BOX, (len(frames), 1)),
    )


POINTS = RNG.uniform(-3, 3, (40, 3))
OLD = [
    mapped(0, 0, [0], [0, 0], POINTS[:2]),
    mapped(1, 4, [0, 4], [0, 0, 4], POINTS[:3]),
    mapped(2, 9, [0, 4, 9], [0, 0, 4, 9], POINTS[:4]),
]
KEPT_FRAMES = [0, 0, 4, 9, 20, 20, 25, 31]
EMPTY = mapped(3, 0, [0], [], map_number=1)
EMPTY_ON = mapped(4, 1, [0], [0], map_number=1)
KEPT = mapped(3, 40, [0, 4, 9, 30, 40], KEPT_FRAMES, map_number=1)
KEPT_ON = mapped(
    4,
    41,
    [0, 4, 9, 30, 40],
    [*KEPT_FRAMES, 40],
    np.vstack([KEPT.points, POINTS[:1]]),
    map_number=1,
)
