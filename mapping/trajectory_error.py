"""Errors of a trajectory against a reference (Sturm et al., IROS 2012, section V)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from vizbot.core.errors import ConfigError
from vizbot.core.geometry import invert, rotation_angle

MAX_GAP = 0.01
"""Largest difference of stamps that are associated [s]."""


def associate(
    stamps_a: NDArray[np.float64], stamps_b: NDArray[np.float64], max_gap: float = MAX_GAP
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Indices (M,) into both (sorted) lists of the stamps that lie within `max_gap` [s].

    Each stamp of the shorter list is associated with the nearest one of the other.
    """
    if len(stamps_a) > len(stamps_b):
        in_b, in_a = associate(stamps_b, stamps_a, max_gap)
        return in_a, in_b
    if len(stamps_a) == 0:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    after = np.clip(np.searchsorted(stamps_b, stamps_a), 1, max(len(stamps_b) - 1, 1))
    after = np.minimum(after, len(stamps_b) - 1)
    before = np.maximum(after - 1, 0)
    closer = np.abs(stamps_b[before] - stamps_a) <= np.abs(stamps_b[after] - stamps_a)
    nearest = np.where(closer, before, after)
    near = np.flatnonzero(np.abs(stamps_b[nearest] - stamps_a) <= max_gap)
    return near, nearest[near]


def align(
    positions_a: NDArray[np.float64], positions_b: NDArray[np.float64]
) -> NDArray[np.float64]:
    """T_b_a (4, 4) that brings positions (N, 3) of a nearest to those of b (Umeyama 1991)."""
    mean_a, mean_b = positions_a.mean(axis=0), positions_b.mean(axis=0)
    left, _, right = np.linalg.svd((positions_b - mean_b).T @ (positions_a - mean_a))
    mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(left) * np.linalg.det(right))])
    T_b_a = np.eye(4)
    T_b_a[:3, :3] = left @ mirror @ right
    T_b_a[:3, 3] = mean_b - T_b_a[:3, :3] @ mean_a
    return T_b_a


def absolute_trajectory_error(
    stamps_a: NDArray[np.float64],
    Ts_a: NDArray[np.float64],
    stamps_b: NDArray[np.float64],
    Ts_b: NDArray[np.float64],
) -> float:
    """RMSE [m] of positions after rigid alignment without scale, as `evo_ape tum -a`.

    Args:
        stamps_a: (N,) [s], sorted.
        Ts_a: (N, 4, 4) the estimate.
        stamps_b: (M,) [s], sorted.
        Ts_b: (M, 4, 4) the reference.

    Raises:
        ConfigError: fewer than three stamps can be associated.
    """
    in_a, in_b = associate(stamps_a, stamps_b)
    if len(in_a) < 3:
        raise ConfigError(
            f"trajectories share {len(in_a)} time stamps, at least 3 are needed;"
            " check that both are of the same sequence"
        )
    positions_a, positions_b = Ts_a[in_a, :3, 3], Ts_b[in_b, :3, 3]
    T_b_a = align(positions_a, positions_b)
    error = positions_a @ T_b_a[:3, :3].T + T_b_a[:3, 3] - positions_b
    return float(np.sqrt((error**2).sum(axis=1).mean()))


def relative_error(
    stamps_a: NDArray[np.float64],
    Ts_a: NDArray[np.float64],
    stamps_b: NDArray[np.float64],
    Ts_b: NDArray[np.float64],
    distance: float = 1.0,
) -> tuple[float, float] | None:
    """RMSE [m] and [rad] of the motion over every stretch of `distance` [m] of the reference.

    Arguments as of `absolute_trajectory_error`. A stretch starts at each pose and ends at the first
    one that is `distance` of path away. None if the reference is shorter than that.
    """
    in_a, in_b = associate(stamps_a, stamps_b)
    Ts_a, Ts_b = Ts_a[in_a], Ts_b[in_b]
    steps = np.linalg.norm(np.diff(Ts_b[:, :3, 3], axis=0), axis=1)
    path = np.concatenate([np.zeros(1), np.cumsum(steps)])
    ends = np.searchsorted(path, path + distance)
    errors = [
        invert(invert(Ts_b[start]) @ Ts_b[end]) @ invert(Ts_a[start]) @ Ts_a[end]
        for start, end in enumerate(ends)
        if end < len(path)
    ]
    if not errors:
        return None
    moved = np.array([error[:3, 3] for error in errors])
    turned = np.array([rotation_angle(error) for error in errors])
    return float(np.sqrt((moved**2).sum(axis=1).mean())), float(np.sqrt((turned**2).mean()))


def normalised_errors(
    Ts_a: NDArray[np.float64], covariances: NDArray[np.float64], Ts_b: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Squared errors (N,) of poses in units of their covariance (NEES, Bar-Shalom 2001, 5.4.2).

    Their mean is 6 where the covariances are true.

    Args:
        Ts_a: (N, 4, 4) the estimate.
        covariances: (N, 6, 6) of its right perturbation, rotation [rad] first, then translation
            [m].
        Ts_b: (N, 4, 4) the truth.
    """
    off = np.linalg.inv(Ts_a) @ Ts_b
    error = np.column_stack((Rotation.from_matrix(off[:, :3, :3]).as_rotvec(), off[:, :3, 3]))
    return np.asarray(np.einsum("ni,nij,nj->n", error, np.linalg.inv(covariances), error))
