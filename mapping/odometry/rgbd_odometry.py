"""RGB-D odometry: the pose of a camera in the camera of a keyframe, from matched corners.

Matching searches around the pixel where a corner is predicted. A minimal pose finds the matches
that agree; robust least squares then refine it (`mapping.odometry.pose_refinement`).
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.odometry.config import FeatureConfig, MinimalPoseConfig, OdometryConfig
from mapping.odometry.features import Features
from mapping.odometry.pose_refinement import Matches, refine
from vizbot.core.geometry import invert, rotation_angle, transform
from vizbot.core.program.kernels import kernel
from vizbot.core.types import SE3, Intrinsics

_CELL = 16
"""Edge [px] of the cells by which the search for a match is indexed."""


@dataclass(frozen=True, slots=True, eq=False)
class RelativePose:
    """A camera in the camera of a keyframe, by images.

    Attributes:
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

    The prediction `T_keyframe_cam` guides the search for matches, within `radius` [px].
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
        T = _minimal_pose(*guided, intrinsics, config.minimal, attempt)
        if T is None:
            break
        # Matches around a known pose are more and better: they judge it, and refine it.
        found = _refined(T, matched(T, config.verify_radius), camera, config)
        if found is None:
            continue
        # Less half the squared Mahalanobis distance between the pose and its prediction.
        off = invert(T_keyframe_cam) @ found.T_keyframe_cam
        step = float(np.linalg.norm(off[:3, 3])) / config.motion_sigma
        turn = rotation_angle(off) / config.turn_sigma
        score = found.inliers - 0.5 * (step**2 + turn**2)
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
            np.ones(len(keyframe.pixels)),
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


def match(
    features: Features,
    predicted: NDArray[np.float64],
    others: Features,
    radius: float,
    config: FeatureConfig,
) -> NDArray[np.int64]:
    """Pairs (M, 2) of indices into `features` and `others` that are each other's best match.

    Args:
        features: Corners to look for.
        predicted: (N, 2) pixel in the other image where each should lie; NaN to leave it out.
        others: Corners of the other image.
        radius: Of the search around the prediction [px].
        config: Limits of a match.
    """
    if len(features.pixels) == 0 or len(others.pixels) == 0:
        return np.zeros((0, 2), np.int64)
    best: NDArray[np.int64] = _match(
        features.descriptors,
        predicted,
        others.descriptors,
        others.pixels,
        radius,
        config.max_hamming,
        config.ratio,
    )
    matched = np.flatnonzero(best >= 0)
    return np.column_stack((matched, best[matched]))


@kernel()
def _bits(word: np.uint64) -> np.int64:
    """Number of ones, the parallel count of Hacker's Delight, figure 5-2."""
    word = word - ((word >> np.uint64(1)) & np.uint64(0x5555555555555555))
    word = (word & np.uint64(0x3333333333333333)) + (
        (word >> np.uint64(2)) & np.uint64(0x3333333333333333)
    )
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return np.int64((word * np.uint64(0x0101010101010101)) >> np.uint64(56))


@kernel("i8[::1](u8[:,::1], f8[:,::1], u8[:,::1], f8[:,::1], f8, i8, f8)")
def _match(
    descriptors: NDArray[np.uint64],
    predicted: NDArray[np.float64],
    other_descriptors: NDArray[np.uint64],
    other_pixels: NDArray[np.float64],
    radius: float,
    max_hamming: int,
    ratio: float,
) -> NDArray[np.int64]:
    """Index (N,) of each corner's match, -1 for none."""
    columns = int(other_pixels[:, 0].max()) // _CELL + 1
    rows = int(other_pixels[:, 1].max()) // _CELL + 1
    first = np.full((rows, columns), -1)
    following = np.full(len(other_pixels), -1)
    for j in range(len(other_pixels)):
        row, column = int(other_pixels[j, 1]) // _CELL, int(other_pixels[j, 0]) // _CELL
        following[j] = first[row, column]
        first[row, column] = j
    best = np.full(len(descriptors), -1)
    owner = np.full(len(other_pixels), -1)
    owner_distance = np.full(len(other_pixels), 257)
    for i in range(len(descriptors)):
        u, v = predicted[i, 0], predicted[i, 1]
        if not (np.isfinite(u) and np.isfinite(v)):
            continue
        nearest, distance, second = -1, np.int64(257), np.int64(257)
        for row in range(
            max(0, int((v - radius) // _CELL)), min(rows - 1, int((v + radius) // _CELL)) + 1
        ):
            for column in range(
                max(0, int((u - radius) // _CELL)), min(columns - 1, int((u + radius) // _CELL)) + 1
            ):
                j = first[row, column]
                while j >= 0:
                    du, dv = other_pixels[j, 0] - u, other_pixels[j, 1] - v
                    if du * du + dv * dv <= radius * radius:
                        hamming = np.int64(0)
                        for k in range(4):
                            hamming += _bits(descriptors[i, k] ^ other_descriptors[j, k])
                        if hamming < distance:
                            nearest, distance, second = j, hamming, distance
                        elif hamming < second:
                            second = hamming
                    j = following[j]
        if nearest < 0 or distance > max_hamming or distance > ratio * second:
            continue
        if distance < owner_distance[nearest]:
            if owner[nearest] >= 0:
                best[owner[nearest]] = -1
            owner[nearest], owner_distance[nearest], best[i] = i, distance, nearest
    return best


def _minimal_pose(
    pixels_k: NDArray[np.float64],
    points_k: NDArray[np.float64],
    pixels_c: NDArray[np.float64],
    points_c: NDArray[np.float64],
    intrinsics: Intrinsics,
    config: MinimalPoseConfig,
    seed: int,
) -> SE3 | None:
    """T_k_c between two images by RANSAC over minimal 3D-2D poses (P3P).

    The points are those of the image that has more depth; None when too few matches agree.

    Args:
        pixels_k: (M, 2) of the matches in image k [px].
        points_k: (M, 3) in its camera [m]; (0, 0, 0) without depth.
        pixels_c: (M, 2) of the matches in image c [px].
        points_c: (M, 3) in its camera [m]; (0, 0, 0) without depth.
        intrinsics: Of both images.
        config: Limits.
        seed: Of the samples; equal seeds give equal poses.
    """
    depth_k, depth_c = points_k[:, 2] > 0, points_c[:, 2] > 0
    forward = depth_k.sum() >= depth_c.sum()
    points = points_k[depth_k] if forward else points_c[depth_c]
    pixels = pixels_c[depth_k] if forward else pixels_k[depth_c]
    if len(points) < config.agreeing:
        return None
    parameters = cv2.UsacParams()
    parameters.confidence = 0.999
    parameters.isParallel = False
    parameters.loMethod = cv2.LOCAL_OPTIM_NULL
    parameters.final_polisher = cv2.NONE_POLISHER
    parameters.maxIterations = config.iterations
    parameters.randomGeneratorState = seed
    parameters.sampler = cv2.SAMPLING_UNIFORM
    parameters.score = cv2.SCORE_METHOD_MSAC
    parameters.threshold = config.error
    found, _, rotation, translation, agreeing = cv2.solvePnPRansac(
        points, pixels, intrinsics.K, np.zeros(4), params=parameters
    )
    if not found or agreeing is None or len(agreeing) < config.agreeing:
        return None
    T_pixels_points = np.eye(4)
    T_pixels_points[:3, :3] = cv2.Rodrigues(rotation)[0]
    T_pixels_points[:3, 3] = translation[:, 0]
    return invert(T_pixels_points) if forward else T_pixels_points
