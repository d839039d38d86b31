"""Trajectories in the TUM format: one line a pose, `stamp x y z qx qy qz qw`.

Source: the TUM RGB-D benchmark's file formats; `evo` reads the same.
"""

from __future__ import annotations

from math import hypot
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vizbot.core.camera_limits import is_stamp
from vizbot.core.errors import ConfigError
from vizbot.core.files import read_regular, write_whole
from vizbot.core.geometry import from_quat_xyzw, to_quat_xyzw
from vizbot.core.types import SE3


def heading_of(frame: str) -> str:
    """The first line of a file with the poses of the `camera` or the `base` in `map`."""
    return f"# of the {frame} in map: timestamp tx ty tz qx qy qz qw\n"


_MOST_BYTES = 64 << 20
"""Largest file: some days of frames."""
_FARTHEST = 1e8
"""Largest coordinate [m]: of places on Earth even geocentric ones are less than a tenth."""
_NORMS = 1e-6, 1e6
"""Norms of what counts as a quaternion that is not normalised."""
_UNIT_TOLERANCE = 1e-3
"""Of the norm of a quaternion that nothing has cut short."""


def write_trajectory(
    path: Path,
    stamps: NDArray[np.float64],
    Ts_map_frame: NDArray[np.float64],
    frame: str = "camera",
) -> None:
    """Write poses (N, 4, 4) at stamps (N,) [s], with fixed decimals: a run repeats to the byte.

    `frame` is what they are the poses of, which the first line says.

    Raises:
        ConfigError: the file cannot be written.
    """
    lines = [heading_of(frame), *map(pose_line, stamps, Ts_map_frame)]
    write_whole(path, "".join(lines).encode("ascii"))


def pose_line(stamp: float, T_map_cam: SE3) -> str:
    """The line of a pose at a stamp [s], with its end."""
    numbers = np.round((*T_map_cam[:3, 3], *to_quat_xyzw(T_map_cam)), 6) + 0.0
    return f"{stamp:.6f} " + " ".join(f"{number:.6f}" for number in numbers) + "\n"


def read_trajectory(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Read stamps (N,) [s] and poses (N, 4, 4), sorted by stamp.

    Empty lines and `#` comments are skipped, and after other poses a last line that a killed
    program has left without its end, unless it is a pose of unit length all the same.

    Raises:
        ConfigError: the file is missing or a line is not a stamp and a pose.
    """
    try:
        text = read_regular(path, _MOST_BYTES).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: not readable as a TUM trajectory ({error})") from error
    stamps: list[float] = []
    Ts_map_cam: list[NDArray[np.float64]] = []
    lines = text.splitlines()
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            row = np.array([float(word) for word in line.split()])
        except ValueError:
            row = np.zeros(0)
        is_cut = bool(stamps) and number == len(lines) and not text.endswith("\n")
        if is_cut and (len(row) != 8 or abs(hypot(*row[4:]) - 1.0) > _UNIT_TOLERANCE):
            continue
        if len(row) != 8 or not _is_stamped_pose(row):
            raise ConfigError(
                f"{path}, line {number}: {line.strip()[:60]!r} is not a pose;"
                " expected 'stamp x y z qx qy qz qw'"
            )
        stamps.append(float(row[0]))
        Ts_map_cam.append(from_quat_xyzw(row[1:4], row[4:]))
    order = np.argsort(stamps, kind="stable")
    return np.array(stamps)[order], np.array(Ts_map_cam).reshape(-1, 4, 4)[order]


def _is_stamped_pose(row: NDArray[np.float64]) -> bool:
    """Whether (8,) stamp [s], x, y, z [m] and a quaternion can be some."""
    least, most = _NORMS
    near = (np.abs(row[1:4]) <= _FARTHEST).all()
    return bool(is_stamp(row[0]) and near and least <= hypot(*row[4:]) <= most)
