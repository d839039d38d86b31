"""RGB-D odometry: the pose of a camera in the camera of a keyframe, from matched corners.

RANSAC over minimal 3D-2D poses finds the matches that agree; a robust Gauss-Newton then minimises
the reprojection both ways and the difference in depth, each in units of its own noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import BaseModel

from mapping.features import FeatureConfig, Features, match
from vizbot.core.geometry import invert, transform
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
    ransac_error: float = 4.0
    """Reprojection error of a match that agrees with a minimal pose [px]."""
    ransac_iterations: int = 1000
    """Minimal poses tried at most."""
    min_agreeing: int = 10
    """Matches that must agree with a minimal pose before it is looked at more closely."""
    verify_radius: float = 10.0
    """Radius of the search [px] for the matches that verify and refine a minimal pose."""
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
        predicted = _predicted_pixels(keyframe, T, intrinsics)
        pairs = match(keyframe, predicted, features, within, feature_config)
        a, b = pairs.T
        return keyframe.pixels[a], keyframe.points[a], features.pixels[b], features.points[b]

    camera = np.array([intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy])
    T = _minimal_pose(matched(T_keyframe_cam, radius), intrinsics, config)
    if T is None:
        return None
    # Matches around a known pose are more and better: they judge it, and refine it.
    matches = matched(T, config.verify_radius)
    T, information, agrees = _refine(T, *matches, camera, config.pixel_sigma, config.depth_sigma)
    inliers, usable = int((agrees == 1).sum()), int((agrees >= 0).sum())
    if inliers < config.min_inliers or inliers < config.min_inlier_fraction * usable:
        return None
    if not np.isfinite(T).all() or np.linalg.cond(information) > 1e12:
        return None
    return RelativePose(T, np.linalg.inv(information), inliers, inliers / usable)


def chained(first: RelativePose, second: RelativePose) -> RelativePose:
    """The pose of c in a, from b in a and c in b; as well supported as the weaker of the two."""
    weaker = min(first, second, key=lambda pose: pose.inliers)
    T_b_c = second.T_keyframe_cam
    # Right perturbations of a_b move to c by the adjoint of T_c_b (Barfoot 2017, section 7.1.4).
    R_c_b, t_c_b = T_b_c[:3, :3].T, invert(T_b_c)[:3, 3]
    cross = np.array(
        [[0.0, -t_c_b[2], t_c_b[1]], [t_c_b[2], 0.0, -t_c_b[0]], [-t_c_b[1], t_c_b[0], 0.0]]
    )
    adjoint = np.block([[R_c_b, np.zeros((3, 3))], [cross @ R_c_b, R_c_b]])
    return RelativePose(
        first.T_keyframe_cam @ T_b_c,
        adjoint @ first.covariance @ adjoint.T + second.covariance,
        weaker.inliers,
        weaker.inlier_fraction,
    )


def _predicted_pixels(
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


def _minimal_pose(matches: Matches, intrinsics: Intrinsics, config: OdometryConfig) -> SE3 | None:
    """T_keyframe_cam by RANSAC, from whichever image has more depth at the matches."""
    pixels_k, points_k, pixels_c, points_c = matches
    depth_k, depth_c = points_k[:, 2] > 0, points_c[:, 2] > 0
    forward = depth_k.sum() >= depth_c.sum()
    points = points_k[depth_k] if forward else points_c[depth_c]
    pixels = pixels_c[depth_k] if forward else pixels_k[depth_c]
    if len(points) < config.min_agreeing:
        return None
    found, rotation, translation, agreeing = cv2.solvePnPRansac(
        points,
        pixels,
        intrinsics.K,
        None,
        iterationsCount=config.ransac_iterations,
        reprojectionError=config.ransac_error,
        confidence=0.999,
        flags=cv2.SOLVEPNP_AP3P,
    )
    if not found or len(agreeing) < config.min_agreeing:
        return None
    T_pixels_points = np.eye(4)
    T_pixels_points[:3, :3] = cv2.Rodrigues(rotation)[0]
    T_pixels_points[:3, 3] = translation[:, 0]
    return invert(T_pixels_points) if forward else T_pixels_points


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
