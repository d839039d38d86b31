"""The pose graph over keyframes, solved incrementally with GTSAM's iSAM2.

Variables are poses of the base, T_map_base, so that the noise of wheels and floor is diagonal;
callers give and get poses of the camera. Only this module knows the order of GTSAM's Pose3 tangent
(rotation first, then translation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import gtsam
import numpy as np
from numpy.typing import NDArray

from mapping.keyframes.config import PoseGraphConfig
from vizbot.core.geometry import invert, planar, rotation_angle, yaw_of
from vizbot.core.types import SE3

_FREE = 1e3
"""Sigma of directions that a factor leaves free [rad or m]."""
_STEPS = 20
"""Most iterations of the solver when a loop closes."""


def pose_noise(
    rotation_sigma: float | Sequence[float], translation_sigma: float | Sequence[float]
) -> gtsam.noiseModel.Diagonal:
    """Noise of a `Pose3`: sigmas about x, y, z [rad], then x, y, z [m]; a number is for all."""
    rotation = np.broadcast_to(np.asarray(rotation_sigma, np.float64), 3)
    translation = np.broadcast_to(np.asarray(translation_sigma, np.float64), 3)
    return gtsam.noiseModel.Diagonal.Sigmas(np.concatenate((rotation, translation)))


@dataclass(frozen=True, slots=True, eq=False)
class _Link:
    """A motion between keyframes that may be removed from the graph.

    Attributes:
        T_i_j: Motion between their bases.
        factor: Index among the new factors, or, once settled, in the solver.
        settled: Whether the solver has it.
        loosened: Of a closure, pairs of the wheel-only links that give way to it: the original
            link, and the loose one that replaces it while the closure holds.
    """

    i: int
    j: int
    T_i_j: gtsam.Pose3
    noise: gtsam.noiseModel.Base
    factor: int
    settled: bool = False
    loosened: tuple[tuple[_Link, _Link], ...] = ()


class PoseGraph:
    """Poses of keyframes and the measured motions between them.

    Factors are collected until `update`, which solves for all poses.
    """

    def __init__(self, T_base_cam: SE3, config: PoseGraphConfig) -> None:
        self._config = config
        self._T_base_cam = T_base_cam
        self._adjoint = gtsam.Pose3(T_base_cam).AdjointMap()
        parameters = gtsam.ISAM2Params()
        parameters.setRelinearizeThreshold(0.01)
        parameters.relinearizeSkip = 1
        self._isam = gtsam.ISAM2(parameters)
        self._factors = gtsam.NonlinearFactorGraph()
        self._new = gtsam.Values()
        self._estimate = gtsam.Values()
        self._closures: list[_Link] = []
        self._wheel_only: list[_Link] = []

    def add_keyframe(self, keyframe: int, T_map_cam: SE3, *, fixed: bool = False) -> None:
        """Add a camera pose at its estimate; a `fixed` one, as the first, keeps it."""
        T_map_base = gtsam.Pose3(T_map_cam @ invert(self._T_base_cam))
        self._new.insert(keyframe, T_map_base)
        if fixed:
            noise = pose_noise(1e-4, 1e-4)
            self._factors.add(gtsam.PriorFactorPose3(keyframe, T_map_base, noise))

    def add_image_motion(
        self,
        i: int,
        j: int,
        T_i_j: SE3,
        covariance: NDArray[np.float64],
        *,
        closes: bool = False,
        wheel_slack: tuple[int, NDArray[np.float64]] | None = None,
    ) -> None:
        """Add the motion between cameras i and j by images.

        Args:
            i: Earlier keyframe.
            j: Later keyframe.
            T_i_j: The motion.
            covariance: (6, 6) of its right perturbation, rotation first.
            closes: Whether it closes a loop, which is removed if the graph contradicts it.
            wheel_slack: Id of the keyframe up to which wheels alone may have erred, and the bound
                (2,) of that error [m, rad], which holds as long as the loop is closed. Robust
                kernels alone do not suffice: seen from where wheels have spun to, a loop that
                closes far off is the outlier.
        """
        config = self._config
        least = np.repeat((config.image_rotation_sigma, config.image_translation_sigma), 3) ** 2
        noise = gtsam.noiseModel.Gaussian.Covariance(
            self._adjoint @ (covariance + np.diag(least)) @ self._adjoint.T
        )
        T_base_i_base_j = self._T_base_cam @ T_i_j @ invert(self._T_base_cam)
        if closes:
            pose = gtsam.Pose3(T_base_i_base_j)
            loosened = () if wheel_slack is None else self._loosened(*wheel_slack)
            factor = self._factors.size()
            self._closures.append(_Link(i, j, pose, noise, factor, loosened=loosened))
        self._between(i, j, T_base_i_base_j, _robust(noise, config.image_kernel))

    def add_wheel_motion(
        self, i: int, j: int, T_base_i_base_j: SE3, wheel_only: NDArray[np.float64] | None = None
    ) -> None:
        """Add the motion of the base between i and j by dead reckoning.

        `wheel_only` (2,) is distance and turn, to and fro, while no image was believed [m, rad];
        None where images measured the motion as well.
        """
        config = self._config
        step, turn = float(np.linalg.norm(T_base_i_base_j[:3, 3])), rotation_angle(T_base_i_base_j)
        if wheel_only is not None:
            step, turn = wheel_only.tolist()
        turn = config.wheel_rotation_sigma + config.wheel_slip * turn
        step = config.wheel_translation_sigma + config.wheel_slip * step
        sigmas = pose_noise(
            (config.floor_tilt_sigma, config.floor_tilt_sigma, turn),
            (step, step, config.floor_height_sigma),
        )
        noise = _robust(sigmas, config.wheel_kernel)
        if wheel_only is not None:
            pose = gtsam.Pose3(T_base_i_base_j)
            self._wheel_only.append(_Link(i, j, pose, noise, self._factors.size()))
        self._between(i, j, T_base_i_base_j, noise)

    def add_gyro_turn(self, i: int, j: int, T_base_i_base_j: SE3, sigma: float) -> None:
        """Add the turn of the base about its z axis between i and j; it constrains nothing else.

        `sigma` is the standard deviation of the turn [rad].
        """
        noise = pose_noise((_FREE, _FREE, sigma), _FREE)
        self._between(i, j, T_base_i_base_j, _robust(noise, self._config.gyro_kernel))

    def add_floor(self, keyframe: int, T_map_cam: SE3) -> None:
        """Add that the base stands level on the floor at a keyframe, estimated at `T_map_cam`.

        Height, roll and pitch do not depend on the heading, so they are measured against the
        estimate projected to the floor, whose own position and heading have no weight.
        """
        T_map_base = T_map_cam @ invert(self._T_base_cam)
        flat = planar(T_map_base[0, 3], T_map_base[1, 3], yaw_of(T_map_base))
        tilt, height = self._config.floor_tilt_sigma, self._config.floor_height_sigma
        noise = pose_noise((tilt, tilt, _FREE), (_FREE, _FREE, height))
        self._factors.add(gtsam.PriorFactorPose3(keyframe, gtsam.Pose3(flat), noise))

    def add_unknown_motion(self, i: int, j: int, T_i_j: SE3) -> None:
        """Hold j near its supposed pose, for want of any measurement."""
        noise = pose_noise(1.0, 1.0)
        self._factors.add(gtsam.BetweenFactorPose3(i, j, gtsam.Pose3(T_i_j), noise))

    @property
    def closures(self) -> list[tuple[int, int]]:
        """Pairs of keyframes between which a loop is closed."""
        return [(closure.i, closure.j) for closure in self._closures]

    def update(self) -> dict[int, SE3]:
        """Solve and remove closures that prove wrong; return T_map_cam of every keyframe by its id.

        A loop that closes after wheels have spun bends the graph in several steps, since robust
        weights change with each.
        """
        self._solve()
        # A closure that wheels gave way to may bend the graph so far that others seem wrong.
        self._remove([closure for closure in self._wrong() if closure.loosened])
        self._remove(self._wrong())
        values, keys = self._estimate, self._estimate.keys()
        return {key: values.atPose3(key).matrix() @ self._T_base_cam for key in keys}

    def _solve(self) -> None:
        result = self._isam.update(self._factors, self._new)
        indices = result.getNewFactorsIndices()
        settled = all(closure.settled for closure in self._closures)
        self._closures = _settled(self._closures, indices)
        self._wheel_only = _settled(self._wheel_only, indices)
        # iSAM2 keeps its factors: left in place here, each would count again.
        self._factors = gtsam.NonlinearFactorGraph()
        self._new = gtsam.Values()
        self._converge(1 if settled else _STEPS)

    def _converge(self, steps: int) -> None:
        for _ in range(steps):
            if self._isam.update().getVariablesRelinearized() == 0:
                break
        self._estimate = self._isam.calculateEstimate()

    def _loosened(
        self, keyframe: int, bound: NDArray[np.float64]
    ) -> tuple[tuple[_Link, _Link], ...]:
        """The wheel-only links up to a keyframe, before and after they are loosened."""
        tight = [x for x in self._wheel_only if x.j == keyframe and x.i < x.j and x.settled]
        noise = pose_noise((bound[1], bound[1], bound[1]), bound[0])
        loose = self._exchange(tight, [replace(link, noise=noise) for link in tight])
        self._wheel_only = [link for link in self._wheel_only if link not in tight]
        return tuple(zip(tight, loose, strict=True))

    def _remove(self, closures: Sequence[_Link]) -> None:
        """Remove closures, and tighten the links that gave way to them."""
        if not closures:
            return
        pairs = [pair for closure in closures for pair in closure.loosened]
        loose = [loose for _, loose in pairs]
        tight = [tight for tight, _ in pairs]
        self._wheel_only += self._exchange([*closures, *loose], tight)
        self._closures = [closure for closure in self._closures if closure not in closures]
        self._converge(_STEPS if pairs else 0)

    def _exchange(self, removed: Sequence[_Link], added: Sequence[_Link]) -> list[_Link]:
        """Replace links in the solver, all at once, so that no keyframe is ever unconnected."""
        factors = gtsam.NonlinearFactorGraph()
        for link in added:
            factors.add(gtsam.BetweenFactorPose3(link.i, link.j, link.T_i_j, link.noise))
        result = self._isam.update(factors, gtsam.Values(), [link.factor for link in removed])
        indices = result.getNewFactorsIndices()
        return [
            replace(link, factor=index, settled=True)
            for link, index in zip(added, indices, strict=True)
        ]

    def _wrong(self) -> list[_Link]:
        return [closure for closure in self._closures if self._contradicts(closure)]

    def _contradicts(self, closure: _Link) -> bool:
        """Whether the rest of the graph outweighs a closure."""
        T_i, T_j = (self._estimate.atPose3(key) for key in (closure.i, closure.j))
        error = gtsam.Pose3.Logmap(closure.T_i_j.between(T_i.between(T_j)))
        whitened = closure.noise.whiten(error)
        return bool(np.linalg.norm(whitened) > self._config.closure_limit)

    def _between(self, i: int, j: int, T_i_j: SE3, noise: gtsam.noiseModel.Base) -> None:
        self._factors.add(gtsam.BetweenFactorPose3(i, j, gtsam.Pose3(T_i_j), noise))


def _robust(noise: gtsam.noiseModel.Base, width: float) -> gtsam.noiseModel.Robust:
    kernel = gtsam.noiseModel.mEstimator.Cauchy.Create(width)
    return gtsam.noiseModel.Robust.Create(kernel, noise)


def _settled(links: Sequence[_Link], indices: Sequence[int]) -> list[_Link]:
    """The same links, each with its index in the solver: `indices` are of the new factors."""
    return [
        link if link.settled else replace(link, factor=indices[link.factor], settled=True)
        for link in links
    ]
