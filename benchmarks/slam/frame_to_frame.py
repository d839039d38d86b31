"""Odometry from each frame to the next by parts of known libraries, for `bench slam`.

They have no map and no wheels. None of them is a dependency of vizbot.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.geometry import invert, rotation_angle
from vizbot.core.types import SE3, Intrinsics, RGBDFrame

MAX_DEPTH = 8.0
"""Largest depth that OpenCV and Open3D use [m], as in our estimator."""
MAX_STEP, MAX_TURN = 0.5, np.radians(30.0)
"""Largest motions from frame to frame in a walk, for frame-to-frame peers [m, rad]."""
_LEAST_MATCHES = 12
"""Matches below which feature odometry finds no motion."""


class FrameToFrame:
    """A chain of motions from each frame to the next; a motion that is not found counts as zero."""

    def __init__(
        self,
        prepare: Callable[[RGBDFrame], Any],
        motion: Callable[[Any, Any], SE3 | None],
    ) -> None:
        """`motion` gives T_previous_cam of two prepared frames; None when it is not found."""
        self._prepare, self._motion = prepare, motion
        self._previous: Any = None
        self._Ts_map_cam: list[SE3] = []

    def track(self, frame: RGBDFrame) -> tuple[SE3 | None, bool]:
        """Do as `Estimator` says."""
        prepared = self._prepare(frame)
        T_previous_cam: SE3 | None = np.eye(4)
        if self._Ts_map_cam:
            T_previous_cam = self._motion(self._previous, prepared)
        matched = T_previous_cam is not None
        before = self._Ts_map_cam[-1] if self._Ts_map_cam else np.eye(4)
        self._Ts_map_cam.append(before if T_previous_cam is None else before @ T_previous_cam)
        self._previous = prepared
        return self._Ts_map_cam[-1], matched

    def finish(self) -> NDArray[np.float64]:
        """Do as `Estimator` says."""
        return np.array(self._Ts_map_cam)


def opencv_odometry(intrinsics: Intrinsics) -> FrameToFrame:
    """OpenCV's RGB-D odometry."""
    settings = cv2.OdometrySettings()
    settings.setCameraMatrix(intrinsics.K.astype(np.float32))
    settings.setMaxDepth(MAX_DEPTH)
    settings.setMaxTranslation(MAX_STEP)
    settings.setMaxRotation(np.degrees(MAX_TURN))
    odometry = cv2.Odometry(cv2.OdometryType_RGB_DEPTH, settings, cv2.OdometryAlgoType_COMMON)

    def prepare(frame: RGBDFrame) -> cv2.OdometryFrame:
        depth = np.where(frame.depth > 0, frame.depth, np.float32(np.nan))
        prepared = cv2.OdometryFrame(depth, frame.rgb)
        odometry.prepareFrame(prepared)
        return prepared

    def motion(previous: cv2.OdometryFrame, now: cv2.OdometryFrame) -> SE3 | None:
        found, T_now_previous = odometry.compute(previous, now)
        return invert(T_now_previous) if found else None

    return FrameToFrame(prepare, motion)


def open3d_odometry(intrinsics: Intrinsics) -> FrameToFrame | None:
    """Open3D's odometry on colour and depth (Park et al. 2017); None where it is not installed.

    It has no limits of motion, so that large ones are rejected here, as OpenCV rejects them.
    """
    if importlib.util.find_spec("open3d") is None:
        return None
    import open3d as o3d

    camera = o3d.camera.PinholeCameraIntrinsic(
        intrinsics.width, intrinsics.height, intrinsics.K.astype(np.float64)
    )
    odometry = o3d.pipelines.odometry
    option = odometry.OdometryOption(depth_max=MAX_DEPTH)

    def prepare(frame: RGBDFrame) -> Any:
        return o3d.geometry.RGBDImage.create_from_color_and_depth(
            o3d.geometry.Image(frame.rgb),
            o3d.geometry.Image(frame.depth),
            depth_scale=1.0,
            depth_trunc=MAX_DEPTH,
        )

    def motion(previous: Any, now: Any) -> SE3 | None:
        found, T_previous_now, _ = odometry.compute_rgbd_odometry(
            now, previous, camera, np.eye(4), odometry.RGBDOdometryJacobianFromHybridTerm(), option
        )
        T = np.asarray(T_previous_now)
        wild = np.linalg.norm(T[:3, 3]) > MAX_STEP or rotation_angle(T) > MAX_TURN
        return T if found and not wild else None

    return FrameToFrame(prepare, motion)


def feature_odometry(intrinsics: Intrinsics) -> FrameToFrame:
    """Plain feature odometry of OpenCV's parts: ORB, matches both ways, and PnP with RANSAC.

    The points of a frame come from its depth; the next frame's pose is the one that sees them
    where they are matched. There is no map, no keyframe and no wheel in it.
    """
    detector = cv2.ORB.create(nfeatures=2000)
    matcher = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True)
    K = intrinsics.K.astype(np.float64)

    def prepare(frame: RGBDFrame) -> _Features:
        grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY)
        keypoints, descriptors = detector.detectAndCompute(grey, None)
        pixels = np.array([keypoint.pt for keypoint in keypoints]).reshape(-1, 2)
        columns, rows = np.rint(pixels).astype(int).T
        depth = frame.depth[rows.clip(0, grey.shape[0] - 1), columns.clip(0, grey.shape[1] - 1)]
        rays = np.column_stack([pixels, np.ones(len(pixels))]) @ np.linalg.inv(K).T
        return _Features(pixels, rays * depth[:, None].astype(np.float64), descriptors)

    def motion(previous: _Features, now: _Features) -> SE3 | None:
        if previous.descriptors is None or now.descriptors is None:
            return None
        matches = matcher.match(previous.descriptors, now.descriptors)
        of, to = np.array([(m.queryIdx, m.trainIdx) for m in matches], int).reshape(-1, 2).T
        depth = previous.points[of, 2]
        near = (depth > 0) & (depth <= MAX_DEPTH)
        if near.sum() < _LEAST_MATCHES:
            return None
        points, pixels = previous.points[of[near]], now.pixels[to[near]]
        cv2.setRNGSeed(0)
        found, turn, shift, inliers = cv2.solvePnPRansac(
            points, pixels, K, None, iterationsCount=300, reprojectionError=2.0
        )
        if not found or inliers is None or len(inliers) < _LEAST_MATCHES:
            return None
        inside = inliers.ravel()
        turn, shift = cv2.solvePnPRefineLM(points[inside], pixels[inside], K, None, turn, shift)
        T_now_previous = np.eye(4)
        T_now_previous[:3, :3], T_now_previous[:3, 3] = cv2.Rodrigues(turn)[0], shift.ravel()
        wild = np.linalg.norm(shift) > MAX_STEP or rotation_angle(T_now_previous) > MAX_TURN
        return None if wild else invert(T_now_previous)

    return FrameToFrame(prepare, motion)


@dataclass(frozen=True, slots=True, eq=False)
class _Features:
    """Pixels (N, 2), points (N, 3) in the camera's frame [m], and descriptors, None without any."""

    pixels: NDArray[np.float64]
    points: NDArray[np.float64]
    descriptors: NDArray[np.uint8] | None
