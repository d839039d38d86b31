"""ROS bags, which are recognised by their name and folder, and refused."""

from __future__ import annotations

from pathlib import Path

from vizbot.core.errors import ConfigError

_MCAP = ".mcap"
_LISTING = "metadata.yaml"
"""What rosbag2 writes beside the files of a bag."""


def not_read(path: Path, kind: str = "a ROS 2 bag") -> ConfigError:
    """The error for a bag at `path`."""
    return ConfigError(
        f"recording {path}: {kind}, which is not read; write its images as a folder in TUM's"
        " layout, or record with the RealSense SDK (.db3)"
    )


def require_no_bag(path: Path) -> None:
    """Refuse a ROS 2 bag by its name and its folder; nothing is opened.

    Raises:
        ConfigError: it is one.
    """
    if path.suffix.lower() == _MCAP:
        raise not_read(path, "a ROS 2 bag (MCAP)")
    listed = path.is_dir() and (path / _LISTING).is_file()
    if listed and any(each.suffix.lower() in (_MCAP, ".db3") for each in path.iterdir()):
        raise not_read(path)
