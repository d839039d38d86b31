"""RGB-D odometry: the pose of a camera in the camera of a keyframe, from matched corners.

A minimal pose finds the matches that agree; a robust Gauss-Newton then minimises the reprojection
both ways and the difference in depth, each in units of its own noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import BaseModel

from mapping.features import FeatureConfig, Features, match
from mapping.minimal_pose import MinimalPoseConfig, minimal_pose
from vizbot.core.geometry import invert, rotation_angle, transform
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, Intrinsics

Matches: TypeAlias = tuple[
    NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]
]
"""Pixels (M, 2) and points (M, 3) in the keyframe, then pixels and points in the other image."""


class OdometryConfig(BaseModel):
    """When matched corners make a pose."""

    model_config = SETTINGS
    pixel_sigma: float = 1.0
    """Noise of a matched corner [px]."""
    depth_sigma: float = 0.003
    """Noise of depth at 1 m [m]; that of a stereo camera grows with the square of depth."""
    minimal: MinimalPoseConfig = MinimalPoseConfig()
    """The search for a first pose."""
    verify_radius: float = 10.0
    """Radius of the search [px] for the matches that verify and refine a minimal pose."""
    sure_inliers: int = 60
    """With fewer agreeing matches than this, other minimal poses are tried as well: a few matches
    that repeat, as tiles do, agree with several ..."""
    attempts: int = 8
    """... so many times in all; the pose with most agreeing matches wins, less ..."""
    motion_sigma: float = 0.15
    """... what it is away from the prediction [m] ..."""
    turn_sigma: float = 0.1
    """... and turned away from it [rad], in these units."""
    min_inliers: int = 15
    """Matches that must agree in the end, or there is no pose."""
    min_inlier_fraction: float = 0.4
    """Fraction of those matches that must agree."""


@dataclass(frozen=True, slots=True, eq=False)
class RelativePose:
    """A camera in the camera of a keyframe, as images have it.

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
        predicted = predicted_pixels(keyframe, T, intrinsics)
        pairs = match(keyframe, predicted, features, within, feature_config)
        a, b = pairs.T
        return keyframe.pixels[a], keyframe.points[a], features.pixels[b], features.points[b]

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
    T, information, agrees = _refine(T, *matches, camera, config.pixel_sigma, config.depth_sigma)
    inliers, usable = int((agrees == 1).sum()), int((agrees >= 0).sum())
    if inliers < config.min_inliers or inliers < config.min_inlier_fraction * usable:
        return None
    if not np.isfinite(T).all() or np.linalg.cond(information) > 1e12:
        return None
    return RelativePose(T, np.linalg.inv(information), inliers, inliers / usable)


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
    measured = keyframe.points[:, 2] > 0
    median = float(np.median(keyframe.points[measured, 2])) if measured.any() else 2.0
    rays = np.column_stack(
        (
            (keyframe.pixels[:, 0] - intrinsics.cx) / intrinsics.fx,
            (keyframe.pixels[:, 1] - intrinsics.cy) / intrinsics.fy,
            np.ones(len(keyframe)),
        )
    )
    points = np.where(measured[:, None], keyframe.points, rays * median)
    x, y, z = transform(invert(T_keyframe_cam), points).T
    z = np.where(z > 0.05, z, np.nan)
    return np.column_stack(
        (intrinsics.fx * x / z + intrinsics.cx, intrinsics.fy * y / z + intrinsics.cy)
    )


@njit(cache=True)  # type: ignore[untyped-decorator]
def _refine(
    T_k_c: SE3,
    pixels_k: NDArray[np.float64],
    points_k: NDArray[np.float64],
    pixels_c: NDArray[np.float64],
    points_c: NDArray[np.float64],
    camera: NDArray[np.float64],
    pixel_sigma: float,
    depth_sigma: float,
) -> tuple[SE3, NDArray[np.float64], NDArray[np.int64]]:
    """Robust Gauss-Newton on T_k_c with Cauchy weights.

    Returns the pose, the (6, 6) information of its right perturbation (rotation first), and for
    each match 1 (agrees), 0 (does not) or -1 (has no depth in either image).
    """
    fx, fy, cx, cy = camera
    T = T_k_c.copy()
    information = np.zeros((6, 6))
    agrees = np.full(len(pixels_k), -1)
    jacobian = np.zeros((3, 6))
    residual = np.zeros(3)
    for iteration in range(11):
        information[:] = 0.0
        gradient = np.zeros(6)
        R_k_c, t_k_c = T[:3, :3].copy(), T[:3, 3].copy()
        for i in range(len(pixels_k)):
            has_k, has_c = points_k[i, 2] > 0, points_c[i, 2] > 0
            agrees[i] = 1 if has_k or has_c else -1
            # A match with depth on both sides is seen twice; each view counts half.
            share = 0.5 if has_k and has_c else 1.0
            for inverse in range(2):
                if (inverse == 0 and not has_k) or (inverse == 1 and not has_c):
                    continue
                if inverse == 0:
                    q = R_k_c.T @ (points_k[i] - t_k_c)
                    other, pixel = points_c[i, 2], pixels_c[i]
                else:
                    q = R_k_c @ points_c[i] + t_k_c
                    other, pixel = points_k[i, 2], pixels_k[i]
                if q[2] < 0.05:
                    agrees[i] = 0
                    continue
                # Motion of q with the perturbation: motion = dq / d(rotation, translation).
                motion = np.zeros((3, 6))
                p = q if inverse == 0 else points_c[i]
                motion[0, 1], motion[0, 2], motion[1, 0] = p[2], -p[1], -p[2]
                motion[1, 2], motion[2, 0], motion[2, 1] = p[0], p[1], -p[0]
                motion[0, 3] = motion[1, 4] = motion[2, 5] = 1.0
                motion = -motion if inverse == 0 else R_k_c @ motion
                z = q[2]
                residual[0] = (fx * q[0] / z + cx - pixel[0]) / pixel_sigma
                residual[1] = (fy * q[1] / z + cy - pixel[1]) / pixel_sigma
                jacobian[0] = fx / z * (motion[0] - q[0] / z * motion[2]) / pixel_sigma
                jacobian[1] = fy / z * (motion[1] - q[1] / z * motion[2]) / pixel_sigma
                rows = 2
                if other > 0:
                    sigma = depth_sigma * np.sqrt(1.0 + z**4 + other**4)
                    residual[2] = (z - other) / sigma
                    jacobian[2] = motion[2] / sigma
                    rows = 3
                error = 0.0
                for k in range(rows):
                    error += residual[k] * residual[k]
                if error > 16.0:
                    agrees[i] = 0
                weight = share / (1.0 + error / 4.0)
                for k in range(rows):
                    for a in range(6):
                        gradient[a] += weight * jacobian[k, a] * residual[k]
                        for b in range(6):
                            information[a, b] += weight * jacobian[k, a] * jacobian[k, b]
        if iteration == 10 or np.linalg.det(information) < 1e-9:
            break
        step = -np.linalg.solve(information, gradient)
        w = step[:3]
        angle = np.sqrt((w * w).sum())
        cross = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
        first = np.sin(angle) / angle if angle > 1e-9 else 1.0
        second = (1.0 - np.cos(angle)) / (angle * angle) if angle > 1e-6 else 0.5
        T[:3, 3] = t_k_c + R_k_c @ step[3:]
        T[:3, :3] = R_k_c @ (np.eye(3) + first * cross + second * (cross @ cross))
        if np.abs(step).max() < 1e-7:
            break
    return T, information, agrees
