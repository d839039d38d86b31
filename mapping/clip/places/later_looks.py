"""The kernel that finds views of places at which later pictures looked again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vizbot.core.program.kernels import kernel


@kernel(
    "void(i8[::1], i8[::1], f4[:,::1], f4[::1], i8[::1], f8[:,:,::1], f8[::1], f8[:,::1], b1[::1], "
    "f8, f8)"
)
def mark_looked_twice(
    order: NDArray[np.int64],
    starts: NDArray[np.int64],
    points: NDArray[np.float32],
    ranges: NDArray[np.float32],
    frame_of: NDArray[np.int64],
    Ts_map_cam: NDArray[np.float64],
    times: NDArray[np.float64],
    field: NDArray[np.float64],
    doubted: NDArray[np.bool_],
    later: float,
    near: float,
) -> None:
    """Mark the rows at whose point two frames looked that were taken `later` [s], from `near` [m].

    `order` (R,) sorts the rows by place, `starts` says where each place begins in it and where the
    last one ends; `field` (2, 2) is the camera's view: least and most x / z, and y / z.
    """
    for place in range(len(starts) - 1):
        for i in order[starts[place] : starts[place + 1]]:
            looks, before = 0, -1
            for k in range(starts[place + 1] - 1, starts[place] - 1, -1):
                j = order[k]
                frame = frame_of[j]
                if times[frame] < times[frame_of[i]] + later:
                    break
                if ranges[j] > near or frame == before:
                    continue
                T = Ts_map_cam[frame]
                x, y, z = 0.0, 0.0, 0.0
                for axis in range(3):
                    off = points[i, axis] - T[axis, 3]
                    x += T[axis, 0] * off
                    y += T[axis, 1] * off
                    z += T[axis, 2] * off
                if (
                    z > 0.0
                    and field[0, 0] * z <= x <= field[0, 1] * z
                    and field[1, 0] * z <= y <= field[1, 1] * z
                ):
                    looks, before = looks + 1, frame
                    if looks == 2:
                        doubted[i] = True
                        break
