"""What a calibration leaves: how the true robot of an episode differs from what it believes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import radians

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.episodes.episode import Episode, seed_of_home
from sim_stubs.homes.geometry.house import House
from sim_stubs.world.world import World
from sim_stubs.world.world_plan import D435I_COLOUR
from vizbot.config import Config
from vizbot.core.types import SE3, Intrinsics
from vizbot.rehearsal.config import RehearsalConfig

ANGLE, OFFSET = radians(0.4), 0.005
"""Errors of the mount that `vizbot calibrate` leaves [rad], [m]."""
WHEELS = 0.007
"""Relative error that it leaves of the wheel base and of the wheel scale."""
FOCAL_LENGTH = 0.005
"""Relative error of the camera's focal length."""


@dataclass(frozen=True, slots=True)
class CalibrationError:
    """How the true robot differs from what the robot's program believes.

    Attributes:
        rotation: Rotation vector, in `cam`, of the true camera in the believed one [rad].
        offset: Position, in `base`, of the true camera relative to the believed one [m].
        wheel_base: Relative error of the distance between the wheels.
        wheel_scale: Relative error of the way that a wheel rolls.
        focal_length: Relative error of the focal length.
    """

    rotation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    wheel_base: float = 0.0
    wheel_scale: float = 0.0
    focal_length: float = 0.0

    @staticmethod
    def drawn(episode: Episode) -> CalibrationError:
        """The error of an episode: directions and signs are drawn, sizes are fixed."""
        rng = np.random.default_rng(
            (seed_of_home(episode.home), 5, episode.number, *"".join(episode.goals[:1]).encode())
        )
        axis, direction = _direction(rng), _direction(rng)
        signs = rng.choice((-1.0, 1.0), 3)
        return CalibrationError(
            _triple(ANGLE * axis),
            _triple(OFFSET * direction),
            wheel_base=float(WHEELS * signs[0]),
            wheel_scale=float(WHEELS * signs[1]),
            focal_length=float(FOCAL_LENGTH * signs[2]),
        )

    def mount(self, T_base_cam: SE3) -> SE3:
        """The true mount of a camera that is believed to sit at `T_base_cam`."""
        T_true = T_base_cam.copy()
        T_true[:3, :3] = T_base_cam[:3, :3] @ Rotation.from_rotvec(self.rotation).as_matrix()
        T_true[:3, 3] += self.offset
        return T_true

    def intrinsics(self, believed: Intrinsics) -> Intrinsics:
        """The true intrinsics of a camera with these believed ones."""
        scale = 1.0 + self.focal_length
        return replace(believed, fx=scale * believed.fx, fy=scale * believed.fy)

    def world(self, house: House, config: Config, seed: int) -> World:
        """A world with the true robot."""
        believed = RehearsalConfig.read(config).world
        body = believed.model_copy(
            update={
                "wheel_base": believed.wheel_base * (1.0 + self.wheel_base),
                "wheel_scale": believed.wheel_scale * (1.0 + self.wheel_scale),
            }
        )
        mount = self.mount(config.mount.T_base_cam)
        return World(house, body, mount, seed, intrinsics=self.intrinsics(D435I_COLOUR))


EXACT = CalibrationError()
"""A robot that is just as it believes."""


def _direction(rng: np.random.Generator) -> NDArray[np.float64]:
    """A unit vector (3,) drawn from all directions."""
    vector = rng.standard_normal(3)
    return np.asarray(vector / np.linalg.norm(vector))


def _triple(vector: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z
