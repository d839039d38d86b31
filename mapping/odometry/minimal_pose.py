"""A first pose from matched corners: RANSAC over minimal 3D-2D poses (P3P)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.odometry.config import MinimalPoseConfig
from vizbot.core.geometry import invert
from vizbot.core.types import SE3, Intrinsics


def minimal_pose(
    pixels_k: NDArray[np.float64],
    points_k: NDArray[np.float64],
    pixels_c: NDArray[np.float64],
    points_c: NDArray[np.float64],
    intrinsics: Intrinsics,
    config: MinimalPoseConfig,
    seed: int,
) -> SE3 | None:
    """T_k_c between two images, from whichever has more depth; None when too few matches agree.

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
