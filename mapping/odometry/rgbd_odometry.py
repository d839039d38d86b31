"""RGB-D odometry: the pose of a camera in the camera of a keyframe, from matched corners.

A minimal pose finds the matches that agree; robust least squares then refine it
(`mapping.odometry.pose_refinement`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.odometry.config import FeatureConfig, OdometryConfig
from mapping.odometry.features import Features, match
from mapping.odometry.minimal_pose import minimal_pose
from mapping.odometry.pose_refinement import Matches, refine
from vizbot.core.geometry import invert, rotation_angle, transform
from vizbot.core.types import SE3, Intrinsics


@dataclass(frozen=True, slots=True, eq=False)
class RelativePose:
    """A camera in the camera of a keyframe, by images.

    Attributes:
        T_keyframe_cam: The pose.
        covariance: (6, 6) of the right perturbation, rotation [rad] first, then translation [m].
        inliers: Number of matches that agree with it.
        inlier_fraction: Their share of all matches.
    """

    T_keyframe_cam: SE3
    covariance: NDArray[np.float64]
    inliers: int
    inlier_fraction: float

    def heading_variance(self, T_base_cam: SE3) -> float:
        """Variance of the turn about the base's z axis [rad^2]."""
        up = T_base_cam[2, :3]
        return float(up @ self.covariance[:3, :3] @ up)


def relative_pose(
    keyframe: Features,
    features: Features,
    T_keyframe_cam: SE3,
    radius: float,
    intrinsics: Intrinsics,
    feature_config: FeatureConfig,
    config: OdometryConfig,
) -> RelativePose | None:
    """Pose of a camera in a keyframe's camera; None when too few matches agree.

    Args:
        keyframe: Corners of the keyframe.
        features: Corners of the other image.
        T_keyframe_cam: Prediction, which guides the search for matches.
        radius: Of that search [px].
        intrinsics: Of both images.
        feature_config: Limits of a match.
        config: Limits of a pose.
    """

    def matched(T: SE3, within: float) -> Matches:
        predicted = _projected(points, T, intrinsics)
        pairs = match(keyframe, predicted, features, within, feature_config)
        a, b = pairs.T
        return keyframe.pixels[a], keyframe.points[a], features.pixels[b], features.points[b]

    points = _points(keyframe, intrinsics)
    camera = np.array([intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy])
    guided = matched(T_keyframe_cam, radius)
    best, best_score = None, -np.inf
    for attempt in range(config.attempts):
        T = minimal_pose(*guided, intrinsics, config.minimal, attempt)
        if T is None:
            break
        # Matches around a known pose are more and better: they judge it, and refine it.
        found = _refined(T, matched(T, config.verify_radius), camera, config)
        if found is None:
            continue
        score = found.inliers - _surprise(found.T_keyframe_cam, T_keyframe_cam, config)
        if score > best_score:
            best, best_score = found, score
        if found.inliers >= config.sure_inliers:
            break
    return best


def _refined(
    T: SE3, matches: Matches, camera: NDArray[np.float64], config: OdometryConfig
) -> RelativePose | None:
    T, agrees, hessian, scatter = refine(T, matches, camera, config.pixel_sigma, config.depth_sigma)
    inliers, usable = int((agrees == 1).sum()), int((agrees >= 0).sum())
    if inliers < config.min_inliers or inliers < config.min_inlier_fraction * usable:
        return None
    if not np.isfinite(T).all() or not np.isfinite(hessian).all():
        return None
    eigenvalues = np.linalg.eigvalsh(hessian)
    if eigenvalues[0] < 1e-12 * eigenvalues[-1]:
        return None  # some motion leaves all matches as they are
    inverse = np.linalg.inv(hessian)
    scatter = scatter + config.min_error**2 * hessian
    covariance = config.covariance_factor * inverse @ scatter @ inverse
    return RelativePose(T, covariance, inliers, inliers / usable)


def _surprise(T_keyframe_cam: SE3, predicted: SE3, config: OdometryConfig) -> float:
    """Half the squared Mahalanobis distance between a pose and its prediction."""
    T_predicted_cam = invert(predicted) @ T_keyframe_cam
    step = float(np.linalg.norm(T_predicted_cam[:3, 3])) / config.motion_sigma
    return 0.5 * (step**2 + (rotation_angle(T_predicted_cam) / config.turn_sigma) ** 2)


def chained(first: RelativePose, second: RelativePose) -> RelativePose:
    """The pose of c in a, from b in a and c in b; as well supported as the weaker of the two."""
    weaker = min(first, second, key=lambda pose: pose.inliers)
    T_b_c = second.T_keyframe_cam
    # Right perturbations of a_b move to c by the adjoint of T_c_b (Barfoot 2017, section 7.1.4).
    moved = _adjoint(invert(T_b_c))
    return RelativePose(
        first.T_keyframe_cam @ T_b_c,
        moved @ first.covariance @ moved.T + second.covariance,
        weaker.inliers,
        weaker.inlier_fraction,
    )


def reversed_pose(pose: RelativePose) -> RelativePose:
    """The pose of a in b, from b in a."""
    moved = _adjoint(pose.T_keyframe_cam)
    return RelativePose(
        invert(pose.T_keyframe_cam),
        moved @ pose.covariance @ moved.T,
        pose.inliers,
        pose.inlier_fraction,
    )


def _adjoint(T: SE3) -> NDArray[np.float64]:
    """(6, 6) of a transform, rotation first."""
    rotation, (x, y, z) = T[:3, :3], T[:3, 3]
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.block([[rotation, np.zeros((3, 3))], [cross @ rotation, rotation]])


def predicted_pixels(
    keyframe: Features, T_keyframe_cam: SE3, intrinsics: Intrinsics
) -> NDArray[np.float64]:
    """Where the keyframe's corners should lie (N, 2) [px]; NaN behind the camera.

    A corner without depth is taken to lie at the median depth of the others.
    """
    return _projected(_points(keyframe, intrinsics), T_keyframe_cam, intrinsics)


def _points(keyframe: Features, intrinsics: Intrinsics) -> NDArray[np.float64]:
    """Where the keyframe's corners are taken to lie (N, 3), in its camera [m]."""
    measured = keyframe.points[:, 2] > 0
    median = float(np.median(keyframe.points[measured, 2])) if measured.any() else 2.0
    rays = np.column_stack(
        (
            (keyframe.pixels[:, 0] - intrinsics.cx) / intrinsics.fx,
            (keyframe.pixels[:, 1] - intrinsics.cy) / intrinsics.fy,
            np.ones(len(keyframe)),
        )
    )
    return np.where(measured[:, None], keyframe.points, rays * median)


def _projected(
    points: NDArray[np.float64], T_keyframe_cam: SE3, intrinsics: Intrinsics
) -> NDArray[np.float64]:
    """Where a camera sees points of a keyframe's camera (N, 2) [px]; NaN behind it."""
    x, y, z = transform(invert(T_keyframe_cam), points).T
    z = np.where(z > 0.05, z, np.nan)
    return np.column_stack(
        (intrinsics.fx * x / z + intrinsics.cx, intrinsics.fy * y / z + intrinsics.cy)
    )
