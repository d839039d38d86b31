"""Worlds in files: homes drawn in Sweet Home 3D, and MuJoCo's own format."""

from __future__ import annotations

from pathlib import Path

from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.sweet_home.home import read_home
from sim_stubs.world.world_spec import MJCF, require_world


def read_world(
    path: Path, labels: Path | None = None, start: tuple[float, float, float] | None = None
) -> House:
    """The world in a file: MJCF (`.xml`, `.mjcf`), `.sh3d`, or an example home in a `.jar`.

    Args:
        path: The file.
        labels: File with labels of what is in an MJCF file.
        start: x, y [m], yaw [rad] of the robot in an MJCF file that may not say it.

    Raises:
        ConfigError: it is none of these, or cannot be read.
    """
    require_world(str(path), labels)
    if path.suffix in MJCF:
        from sim_stubs.world.mjcf import read_mjcf  # loads MuJoCo

        return read_mjcf(path, labels, start)
    return read_home(path)
