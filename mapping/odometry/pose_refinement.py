"""Robust least squares on the pose of a camera in a keyframe's camera, and its covariance.

Minimises the reprojection both ways and the difference in depth, each in units of its own noise,
with Cauchy weights, by Gauss-Newton.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from vizbot.core.program.kernels import kernel
from vizbot.core.types import SE3

Matches: TypeAlias = tuple[
    NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]
]
"""Pixels (M, 2) and points (M, 3) in the keyframe, then pixels and points in the other image."""

_CAUCHY = 4.0
"""Squared error, in units of the noise, at which a view has half its weight."""
_OUTLIER = 16.0
"""Squared error from which a match does not agree."""
_ITERATIONS = 10


@kernel()
def _share(depth_k: float, depth_c: float) -> float:
    """A match with depth on both sides is seen twice; each view counts half."""
    return 0.5 if depth_k > 0 and depth_c > 0 else 1.0


@kernel()
def _squared(residual: NDArray[np.float64], rows: int) -> float:
    error = 0.0
    for k in range(rows):
        error += residual[k] * residual[k]
    return error


# Inlined, and without arrays of its own: it is called some thousand times per pose.
@kernel(inline="always")
def _view(
    rotation: NDArray[np.float64],
    t: NDArray[np.float64],
    inverse: bool,
    pixel_k: NDArray[np.float64],
    point_k: NDArray[np.float64],
    pixel_c: NDArray[np.float64],
    point_c: NDArray[np.float64],
    camera: NDArray[np.float64],
    pixel_sigma: float,
    depth_sigma: float,
    own: NDArray[np.float64],
    turned: NDArray[np.float64],
    jacobian: NDArray[np.float64],
    residual: NDArray[np.float64],
) -> int:
    """Where the keyframe's point lies in the other image; `inverse`: the other's in the keyframe.

    Writes the (3, 6) Jacobian and the (3,) residual, in units of the noise. Returns how many of
    their rows count: 2, with depth on both sides 3, without depth or behind the camera 0. Works in
    `own` and `turned`, both (3, 6), which are zero at first.
    """
    point, other, pixel = (
        (point_c, point_k[2], pixel_k) if inverse else (point_k, point_c[2], pixel_c)
    )
    if not point[2] > 0:
        return 0
    if inverse:
        px, py, pz = point[0], point[1], point[2]
        x = rotation[0, 0] * px + rotation[0, 1] * py + rotation[0, 2] * pz + t[0]
        y = rotation[1, 0] * px + rotation[1, 1] * py + rotation[1, 2] * pz + t[1]
        z = rotation[2, 0] * px + rotation[2, 1] * py + rotation[2, 2] * pz + t[2]
    else:
        dx, dy, dz = point[0] - t[0], point[1] - t[1], point[2] - t[2]
        x = rotation[0, 0] * dx + rotation[1, 0] * dy + rotation[2, 0] * dz
        y = rotation[0, 1] * dx + rotation[1, 1] * dy + rotation[2, 1] * dz
        z = rotation[0, 2] * dx + rotation[1, 2] * dy + rotation[2, 2] * dz
    if z < 0.05:
        return 0
    # Motion of (x, y, z) with the perturbation (rotation, translation): by the inverse, that of the
    # camera's own point, turned into the keyframe.
    sign, (px, py, pz) = (1.0, (px, py, pz)) if inverse else (-1.0, (x, y, z))
    own[0, 1], own[0, 2], own[1, 0] = sign * pz, -sign * py, -sign * pz
    own[1, 2], own[2, 0], own[2, 1] = sign * px, sign * py, -sign * px
    own[0, 3] = own[1, 4] = own[2, 5] = sign
    motion = np.dot(rotation, own, turned) if inverse else own
    residual[0] = (camera[0] * x / z + camera[2] - pixel[0]) / pixel_sigma
    residual[1] = (camera[1] * y / z + camera[3] - pixel[1]) / pixel_sigma
    for a in range(6):
        along = motion[2, a]
        jacobian[0, a] = camera[0] / z * (motion[0, a] - x / z * along) / pixel_sigma
        jacobian[1, a] = camera[1] / z * (motion[1, a] - y / z * along) / pixel_sigma
    if not other > 0:
        return 2
    sigma = depth_sigma * np.sqrt(1.0 + z**4 + other**4)
    residual[2] = (z - other) / sigma
    for a in range(6):
        jacobian[2, a] = motion[2, a] / sigma
    return 3


@kernel()
def _moved(T: SE3, step: NDArray[np.floating]) -> SE3:
    """T with a right perturbation, rotation first."""
    w = step[:3]
    angle = np.sqrt((w * w).sum())
    cross = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    first = np.sin(angle) / angle if angle > 1e-9 else 1.0
    second = (1.0 - np.cos(angle)) / (angle * angle) if angle > 1e-6 else 0.5
    rotation = np.ascontiguousarray(T[:3, :3])
    moved = np.eye(4)
    moved[:3, 3] = T[:3, 3] + rotation @ np.ascontiguousarray(step[3:])
    moved[:3, :3] = rotation @ (np.eye(3) + first * cross + second * (cross @ cross))
    return moved


def refine(
    T_k_c: SE3,
    matches: Matches,
    camera: NDArray[np.float64],
    pixel_sigma: float,
    depth_sigma: float,
) -> tuple[SE3, NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """The pose that fits matches best.

    Its covariance is inv(H) S inv(H), with the cost's Hessian H and the scatter S of the gradients
    of the matches (the sandwich estimator, Huber 1967): true whatever the distribution of errors,
    if matches err independently.

    Args:
        T_k_c: A pose near it.
        matches: What agrees; the z of a point is 0 where its depth is unknown.
        camera: (4,) fx, fy, cx, cy of both [px].
        pixel_sigma: Noise of a corner [px].
        depth_sigma: Noise of depth at 1 m [m].

    Returns:
        The pose; for each match 1 (agrees), 0 (does not) or -1 (has no depth in either image); and
        the (6, 6) Hessian of the cost and (6, 6) scatter of the gradients, both of the pose's right
        perturbation, rotation first.
    """
    T, agrees = T_k_c.copy(), np.full(len(matches[0]), -1)
    hessian, scatter = np.zeros((6, 6)), np.zeros((6, 6))
    _refine(T, *matches, camera, pixel_sigma, depth_sigma, agrees, hessian, scatter)
    return T, agrees, hessian, scatter


# A kernel returns no tuple with arrays: an interrupt while numba wraps one ends in a crash.
@kernel(
    "void(f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[::1], f8, f8,"
    "i8[::1], f8[:,::1], f8[:,::1])"
)
def _refine(
    T_k_c: SE3,
    pixels_k: NDArray[np.float64],
    points_k: NDArray[np.float64],
    pixels_c: NDArray[np.float64],
    points_c: NDArray[np.float64],
    camera: NDArray[np.float64],
    pixel_sigma: float,
    depth_sigma: float,
    agrees: NDArray[np.int64],
    hessian: NDArray[np.float64],
    scatter: NDArray[np.float64],
) -> None:
    """Do what `refine` says: the pose is changed, the last three arrays are filled."""
    T = T_k_c
    own, turned = np.zeros((3, 6)), np.zeros((3, 6))
    jacobian, residual = np.zeros((3, 6)), np.zeros(3)
    information = np.zeros((6, 6))
    for _ in range(_ITERATIONS):
        rotation, t = np.ascontiguousarray(T[:3, :3]), T[:3, 3]
        information[:] = 0.0
        gradient = np.zeros(6)
        for i in range(len(pixels_k)):
            share = _share(points_k[i, 2], points_c[i, 2])
            for inverse in range(2):
                rows = _view(
                    rotation, t, inverse == 1, pixels_k[i], points_k[i], pixels_c[i], points_c[i],
                    camera, pixel_sigma, depth_sigma, own, turned, jacobian, residual,
                )  # fmt: skip
                weight = share / (1.0 + _squared(residual, rows) / _CAUCHY)
                for k in range(rows):
                    for a in range(6):
                        weighted = weight * jacobian[k, a]
                        gradient[a] += weighted * residual[k]
                        for b in range(6):
                            information[a, b] += weighted * jacobian[k, b]
        if np.linalg.det(information) < 1e-9:
            break
        step = -np.linalg.solve(information, gradient)
        T = _moved(T, step)
        if np.abs(step).max() < 1e-7:
            break
    T_k_c[:] = T
    rotation, t = np.ascontiguousarray(T[:3, :3]), T[:3, 3]
    for i in range(len(pixels_k)):
        of_match = np.zeros(6)
        has_k, has_c = points_k[i, 2] > 0, points_c[i, 2] > 0
        agrees[i] = 1 if has_k or has_c else -1
        share = _share(points_k[i, 2], points_c[i, 2])
        for inverse in range(2):
            rows = _view(
                rotation, t, inverse == 1, pixels_k[i], points_k[i], pixels_c[i], points_c[i],
                camera, pixel_sigma, depth_sigma, own, turned, jacobian, residual,
            )  # fmt: skip
            error = _squared(residual, rows)
            if (has_c if inverse else has_k) and (rows == 0 or error > _OUTLIER):
                agrees[i] = 0
            weight = share / (1.0 + error / _CAUCHY)
            pull = np.zeros(6)
            for k in range(rows):
                for a in range(6):
                    pull[a] += weight * jacobian[k, a] * residual[k]
                    for b in range(6):
                        hessian[a, b] += weight * jacobian[k, a] * jacobian[k, b]
            hessian -= 2.0 / (share * _CAUCHY) * np.outer(pull, pull)
            of_match += pull
        scatter += np.outer(of_match, of_match)
