"""Pose estimators that `bench slam` compares: ours, and ORB-SLAM3.

All get the same frames one by one. ORB-SLAM3 is under the GPL, no dependency of vizbot, and takes
part only where `pyorbslam3` is installed and a vocabulary is given.
"""

from __future__ import annotations

import importlib.util
import os
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from mapping.calibration.floor_level import estimate_mount
from mapping.keyframes.anchors import poses_in_map
from mapping.slam.config import SlamConfig
from mapping.slam.slam import Slam
from mapping.tum import read_trajectory
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import camera_mount
from vizbot.core.types import SE3, Intrinsics, PoseEstimate, RGBDFrame

_SETTINGS = """%YAML:1.0
File.version: "1.0"
Camera.type: "PinHole"
Camera1.fx: {fx}
Camera1.fy: {fy}
Camera1.cx: {cx}
Camera1.cy: {cy}
Camera1.k1: 0.0
Camera1.k2: 0.0
Camera1.p1: 0.0
Camera1.p2: 0.0
Camera.width: {width}
Camera.height: {height}
Camera.fps: {rate}
Camera.RGB: 1
Stereo.ThDepth: 40.0
Stereo.b: 0.07732
RGBD.DepthMapFactor: 1.0
ORBextractor.nFeatures: 1000
ORBextractor.scaleFactor: 1.2
ORBextractor.nLevels: 8
ORBextractor.iniThFAST: 20
ORBextractor.minThFAST: 7
Viewer.KeyFrameSize: 0.05
Viewer.KeyFrameLineWidth: 1.0
Viewer.GraphLineWidth: 0.9
Viewer.PointSize: 2.0
Viewer.CameraSize: 0.08
Viewer.CameraLineWidth: 3.0
Viewer.ViewpointX: 0.0
Viewer.ViewpointY: -0.7
Viewer.ViewpointZ: -1.8
Viewer.ViewpointF: 500.0
"""
"""Settings of ORB-SLAM3, from its examples for a D435i. Those of the viewer are read, too."""


class Estimator(Protocol):
    """Estimates where frames were taken."""

    def track(self, frame: RGBDFrame) -> tuple[SE3 | None, bool]:
        """T_map_cam, None if unknown, and whether it comes from matched images."""
        ...

    def finish(self) -> NDArray[np.float64]:
        """T_map_cam (F, 4, 4) of all frames after the last; NaN where there is none."""
        ...


class VizbotEstimator:
    """`mapping.slam.slam`, without wheels and gyroscope."""

    def __init__(self, first: RGBDFrame, config: SlamConfig) -> None:
        mount = estimate_mount(first)
        T_base_cam = camera_mount(1.5, 0.0, 0.0) if mount is None else mount
        self._slam = Slam(first.intrinsics, T_base_cam, config)
        self._estimates: list[PoseEstimate] = []

    def track(self, frame: RGBDFrame) -> tuple[SE3 | None, bool]:
        """Do as `Estimator` says."""
        estimate = self._slam.track(frame, None)
        self._estimates.append(estimate)
        return estimate.T_map_cam, estimate.tracking.by_images

    def finish(self) -> NDArray[np.float64]:
        """Do as `Estimator` says."""
        return poses_in_map(
            np.array([estimate.T_keyframe_cam for estimate in self._estimates]),
            np.array([estimate.keyframe for estimate in self._estimates], np.int32),
            self._slam.keyframe_poses(),
        )


class OrbSlam3:
    """ORB-SLAM3 through `pyorbslam3`; a context manager, because it runs threads.

    Raises:
        ConfigError: it is not installed, or the vocabulary cannot be read.
    """

    def __init__(self, intrinsics: Intrinsics, rate: float, vocabulary: Path) -> None:
        """`rate` is that of the frames [Hz], in whole numbers; it chooses keyframes by it."""
        if importlib.util.find_spec("pyorbslam3") is None:
            raise ConfigError(
                "--vocabulary is for ORB-SLAM3, which is not installed: pip install pyorbslam3"
            )
        _require_vocabulary(vocabulary)
        import pyorbslam3

        self._folder = tempfile.TemporaryDirectory()
        settings = Path(self._folder.name) / "settings.yaml"
        f, c = (intrinsics.fx, intrinsics.fy), (intrinsics.cx, intrinsics.cy)
        settings.write_text(
            _SETTINGS.format(
                fx=f[0], fy=f[1], cx=c[0], cy=c[1],
                width=intrinsics.width, height=intrinsics.height, rate=max(1, round(rate)),
            )
        )  # fmt: skip
        with _stdout_to_stderr():
            self._slam = pyorbslam3.Slam(vocabulary, settings, pyorbslam3.Sensor.RGBD)
        self._stamps: list[float] = []

    def track(self, frame: RGBDFrame) -> tuple[SE3 | None, bool]:
        """Do as `Estimator` says."""
        with _stdout_to_stderr():
            found = self._slam.track_rgbd(frame.rgb, frame.depth, frame.stamp)
        self._stamps.append(frame.stamp)
        return (np.asarray(found.pose_wc), True) if found.pose_valid else (None, False)

    def finish(self) -> NDArray[np.float64]:
        """Do as `Estimator` says."""
        path = Path(self._folder.name) / "trajectory.txt"
        with _stdout_to_stderr():
            self._slam.shutdown()
            self._slam.save_trajectory_tum(str(path))
        stamps, Ts_map_cam = read_trajectory(path)
        final = np.full((len(self._stamps), 4, 4), np.nan)
        if len(stamps):
            nearest = np.abs(np.array(self._stamps)[:, None] - stamps).argmin(axis=0)
            final[nearest] = Ts_map_cam
        return final

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        with _stdout_to_stderr():
            self._slam.shutdown()
        self._folder.cleanup()


def _require_vocabulary(path: Path) -> None:
    """Reject a file that is no vocabulary, because ORB-SLAM3 would end the whole program.

    The first line holds four numbers (DBoW2's text format): branching factor, depth, scoring and
    weighting.
    """
    if not path.is_file():
        raise ConfigError(f"vocabulary {path}: no such file; give ORBvoc.txt")
    with path.open("rb") as lines:
        begins = lines.readline(100)
    if not re.fullmatch(rb"\s*\d+(\s+\d+){3}\s*", begins):
        raise ConfigError(
            f"vocabulary {path} is none of ORB-SLAM3: its first line is not four numbers as in"
            " ORBvoc.txt ('10 6 0 0'); unpack ORBvoc.txt.tar.gz and give ORBvoc.txt"
        )


@contextmanager
def _stdout_to_stderr() -> Iterator[None]:
    """Redirect the standard output of a C++ library to standard error; results go to the former."""
    sys.stdout.flush()
    stdout = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        os.dup2(stdout, 1)
        os.close(stdout)
