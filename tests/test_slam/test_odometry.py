"""Relative poses from exact corners with known noise."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mapping.odometry.config import FeatureConfig, OdometryConfig
from mapping.odometry.features import NO_FEATURES, Features
from mapping.odometry.rgbd_odometry import RelativePose, chained, relative_pose
from vizbot.core.geometry import invert, rotation_angle, transform
from vizbot.core.types import SE3, Intrinsics

CAMERA = Intrinsics(640, 480, 600.0, 600.0, 319.5, 239.5)


def small_motion(rng: np.random.Generator, angle: float = 0.1, step: float = 0.2) -> SE3:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(rng.uniform(-angle, angle, 3)).as_matrix()
    T[:3, 3] = rng.uniform(-step, step, 3)
    return T


def views(
    T_k_c: SE3,
    rng: np.random.Generator,
    *,
    count: int = 300,
    outliers: float = 0.0,
    holes: float = 0.2,
    noise: float = 1.0,
) -> tuple[Features, Features]:
    """One cloud of corners seen from a keyframe and from a camera at T_k_c.

    `noise` scales the sigmas of `OdometryConfig`; `outliers` have the descriptor of another corner.
    """
    config = OdometryConfig()
    depth = rng.uniform(1.0, 5.0, count)
    pixels = rng.uniform((20, 20), (620, 460), (count, 2))
    rays = np.column_stack(((pixels - (CAMERA.cx, CAMERA.cy)) / CAMERA.fx, np.ones(count)))
    points = rays * depth[:, None]
    descriptors = rng.integers(0, 2**63, (count, 4), dtype=np.uint64)
    seen = []
    for T in (np.eye(4), T_k_c):
        p = transform(invert(T), points)
        uv = p[:, :2] / p[:, 2:] * CAMERA.fx + (CAMERA.cx, CAMERA.cy)
        uv += rng.normal(0, noise * config.pixel_sigma / np.sqrt(2), uv.shape)
        z = p[:, 2] + noise * rng.normal(0, config.depth_sigma, count) * p[:, 2] ** 2
        rays = np.column_stack(((uv - (CAMERA.cx, CAMERA.cy)) / CAMERA.fx, np.ones(count)))
        measured = rays * z[:, None]
        measured[rng.random(count) < holes] = 0.0
        seen.append(Features(uv, descriptors.copy(), measured))
    wrong = np.flatnonzero(rng.random(count) < outliers)
    seen[1].descriptors[wrong] = seen[1].descriptors[np.roll(wrong, 1)]
    inside = (seen[1].pixels > 0).all(axis=1) & (seen[1].pixels < (640, 480)).all(axis=1)
    second = Features(*(a[inside] for a in (seen[1].pixels, seen[1].descriptors, seen[1].points)))
    return seen[0], second


def measure(keyframe: Features, features: Features, radius: float = 150.0) -> RelativePose | None:
    return relative_pose(
        keyframe, features, np.eye(4), radius, CAMERA, FeatureConfig(), OdometryConfig()
    )


def error(T: SE3, T_true: SE3) -> np.ndarray:
    """Right perturbation (6,) from truth to estimate, rotation first."""
    T_true_found = invert(T_true) @ T
    rotation = Rotation.from_matrix(T_true_found[:3, :3]).as_rotvec()
    return np.concatenate((rotation, T_true_found[:3, 3]))


@settings(max_examples=30)
@given(seed=st.integers(0, 10_000))
def test_a_motion_is_found_among_wrong_matches(seed: int) -> None:
    rng = np.random.default_rng(seed)
    T_k_c = small_motion(rng)
    found = measure(*views(T_k_c, rng, outliers=0.4))
    assert found is not None
    off = error(found.T_keyframe_cam, T_k_c)
    assert np.linalg.norm(off[:3]) < 0.01
    assert np.linalg.norm(off[3:]) < 0.03


def test_without_noise_the_motion_is_exact() -> None:
    rng = np.random.default_rng(5)
    T_k_c = small_motion(rng)
    found = measure(*views(T_k_c, rng, noise=0.0))
    assert found is not None
    assert np.abs(error(found.T_keyframe_cam, T_k_c)).max() < 1e-6


@pytest.mark.parametrize("blind", ["keyframe", "camera"])
def test_depth_on_one_side_is_enough(blind: str) -> None:
    rng = np.random.default_rng(6)
    T_k_c = small_motion(rng)
    keyframe, features = views(T_k_c, rng)
    side = keyframe if blind == "keyframe" else features
    side.points[:] = 0.0
    found = measure(keyframe, features)
    assert found is not None
    assert np.linalg.norm(error(found.T_keyframe_cam, T_k_c)[3:]) < 0.02


def test_the_covariance_is_of_the_size_of_the_error() -> None:
    squared = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        T_k_c = small_motion(rng)
        found = measure(*views(T_k_c, rng, holes=0.0))
        assert found is not None
        off = error(found.T_keyframe_cam, T_k_c)
        squared.append(off @ np.linalg.inv(found.covariance) @ off)
    assert 3.0 < np.mean(squared) < 12.0, "six degrees of freedom"


def test_an_image_that_repeats_to_the_bit_is_not_known_exactly() -> None:
    seen, _ = views(np.eye(4), np.random.default_rng(0))
    found = measure(seen, seen)
    assert found is not None
    sigmas = np.sqrt(np.linalg.eigvalsh(found.covariance))
    assert sigmas.min() > 1e-7
    assert sigmas.max() < 1e-4


def test_what_has_nothing_in_common_has_no_pose() -> None:
    rng = np.random.default_rng(1)
    first, _ = views(np.eye(4), rng)
    second, _ = views(np.eye(4), rng)
    assert measure(first, second) is None
    assert measure(first, NO_FEATURES) is None
    assert measure(NO_FEATURES, first) is None


@pytest.mark.parametrize("lack", [{"count": OdometryConfig().min_inliers - 1}, {"holes": 1.1}])
def test_with_too_few_matches_or_without_any_depth_there_is_no_pose(lack: dict) -> None:
    assert measure(*views(np.eye(4), np.random.default_rng(2), **lack)) is None


def test_a_prediction_makes_a_narrow_search_enough() -> None:
    rng = np.random.default_rng(4)
    T_k_c = small_motion(rng, angle=0.3)
    keyframe, features = views(T_k_c, rng)
    narrow = 15.0
    found = relative_pose(
        keyframe, features, T_k_c, narrow, CAMERA, FeatureConfig(), OdometryConfig()
    )
    assert found is not None
    assert rotation_angle(T_k_c) > 0.1
    assert measure(keyframe, features, narrow) is None


@pytest.mark.slow
def test_uncertainty_adds_up_along_a_chain() -> None:
    rng = np.random.default_rng(8)
    T_a_b, T_b_c = small_motion(rng, 0.5, 1.0), small_motion(rng, 0.5, 1.0)
    sigmas = np.array([0.01, 0.02, 0.005, 0.01, 0.03, 0.02])
    sure = RelativePose(T_b_c, np.zeros((6, 6)), 50, 0.9)
    chain = chained(RelativePose(T_a_b, np.diag(sigmas**2), 40, 0.8), sure)
    samples = []
    for perturbation in rng.normal(0, sigmas, (20_000, 6)):
        T = np.eye(4)
        T[:3, :3] = Rotation.from_rotvec(perturbation[:3]).as_matrix()
        T[:3, 3] = perturbation[3:]
        samples.append(error(T_a_b @ T @ T_b_c, T_a_b @ T_b_c))
    assert np.allclose(chain.T_keyframe_cam, T_a_b @ T_b_c)
    assert chain.inliers == 40
    assert np.allclose(np.cov(np.array(samples).T), chain.covariance, atol=3e-5)
