import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mapping.trajectory_error import (
    absolute_trajectory_error,
    associate,
    normalised_errors,
    relative_error,
)
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import from_quat_xyzw


def walk(rng: np.random.Generator, count: int = 30) -> NDArray[np.float64]:
    """Poses (N, 4, 4) along a random walk."""
    Ts_map_cam = np.tile(np.eye(4), (count, 1, 1))
    Ts_map_cam[:, :3, 3] = rng.normal(0, 0.5, (count, 3)).cumsum(axis=0)
    return Ts_map_cam


@given(seed=st.integers(0, 10_000))
def test_a_moved_and_turned_trajectory_has_no_error(seed: int) -> None:
    rng = np.random.default_rng(seed)
    Ts_map_cam, stamps = walk(rng), np.arange(30.0)
    T = from_quat_xyzw(rng.normal(0, 5, 3), Rotation.random(random_state=rng).as_quat())
    assert absolute_trajectory_error(stamps, T @ Ts_map_cam, stamps, Ts_map_cam) < 1e-9
    moved, turned = relative_error(stamps, T @ Ts_map_cam, stamps, Ts_map_cam) or (1.0, 1.0)
    assert moved < 1e-9
    assert turned < 1e-6


def test_scale_is_not_forgiven() -> None:
    Ts_map_cam, stamps = np.tile(np.eye(4), (3, 1, 1)), np.arange(3.0)
    Ts_map_cam[:, 0, 3] = -1, 0, 1
    twice = Ts_map_cam.copy()
    twice[:, 0, 3] *= 2
    error = absolute_trajectory_error(stamps, twice, stamps, Ts_map_cam)
    assert error == pytest.approx(np.sqrt(2 / 3))


def test_a_mirrored_trajectory_is_not_a_turned_one() -> None:
    Ts_map_cam, stamps = walk(np.random.default_rng(1)), np.arange(30.0)
    mirrored = Ts_map_cam.copy()
    mirrored[:, 2, 3] *= -1
    assert absolute_trajectory_error(stamps, mirrored, stamps, Ts_map_cam) > 0.1


def test_noise_comes_out_as_its_rms() -> None:
    rng = np.random.default_rng(3)
    Ts_map_cam, stamps = walk(rng, 3000), np.arange(3000.0)
    noisy = Ts_map_cam.copy()
    noisy[:, :3, 3] += rng.normal(0, 0.1, (3000, 3))
    error = absolute_trajectory_error(stamps, noisy, stamps, Ts_map_cam)
    assert error == pytest.approx(0.1 * np.sqrt(3), rel=0.03)


def test_stamps_are_associated_with_the_nearest_within_the_gap() -> None:
    a = np.array([0.0, 1.004, 2.5, 3.0])
    b = np.array([0.995, 1.006, 2.0, 3.009, 4.0])
    in_a, in_b = associate(a, b)
    assert in_a.tolist() == [1, 3]
    assert in_b.tolist() == [1, 3]
    in_b, in_a = associate(b, a)
    assert in_a.tolist() == [1, 3]
    assert in_b.tolist() == [1, 3]


@pytest.mark.parametrize("common", [0, 1, 2])
def test_fewer_than_three_common_stamps_are_an_error(common: int) -> None:
    Ts_map_cam, stamps = walk(np.random.default_rng(0), 5), np.arange(5.0)
    later = stamps + 0.5
    later[:common] = stamps[:common]
    with pytest.raises(ConfigError, match=f"share {common} time stamps"):
        absolute_trajectory_error(stamps, Ts_map_cam, later, Ts_map_cam)
    later[:3] = stamps[:3]
    assert absolute_trajectory_error(stamps, Ts_map_cam, later, Ts_map_cam) < 1e-9


def test_relative_error_is_of_the_motion_over_a_metre() -> None:
    stamps = np.arange(31.0)
    straight = np.tile(np.eye(4), (31, 1, 1))
    straight[:, 0, 3] = 0.125 * stamps
    long, bent = straight.copy(), straight.copy()
    long[:, 0, 3] *= 1.02
    angles = np.radians(0.5) * stamps
    bent[:, :3, :3] = Rotation.from_rotvec(np.outer(angles, (0, 0, 1))).as_matrix()
    assert relative_error(stamps, long, stamps, straight) == pytest.approx((0.02, 0.0))
    assert (relative_error(stamps, bent, stamps, straight) or (0.0, 0.0))[1] == pytest.approx(
        np.radians(4.0)
    )
    assert relative_error(stamps[:8], long[:8], stamps[:8], straight[:8]) is None


def test_errors_drawn_from_their_covariance_have_a_mean_square_of_six() -> None:
    rng = np.random.default_rng(4)
    Ts_map_cam = walk(rng, 4000)
    Ts_map_cam[:, :3, :3] = Rotation.random(4000, random_state=rng).as_matrix()
    roots = rng.normal(0, 0.01, (4000, 6, 6))
    covariances = roots @ roots.transpose(0, 2, 1) + 1e-6 * np.eye(6)
    errors = np.einsum("nij,nj->ni", np.linalg.cholesky(covariances), rng.normal(0, 1, (4000, 6)))
    moved = np.tile(np.eye(4), (4000, 1, 1))
    moved[:, :3, :3] = Rotation.from_rotvec(errors[:, :3]).as_matrix()
    moved[:, :3, 3] = errors[:, 3:]
    squared = normalised_errors(Ts_map_cam, covariances, Ts_map_cam @ moved)
    assert squared.mean() == pytest.approx(6.0, abs=0.2)
    assert normalised_errors(Ts_map_cam, 4 * covariances, Ts_map_cam @ moved).mean() < 2.0
