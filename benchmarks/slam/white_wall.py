"""A white wall close before the camera: uneven light, a shadow, a switch, a skirting board.

Frame `wall` is the camera's where the wall was put up: the wall is its plane z = `DISTANCE`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from sim_stubs.realsense.colour_noise import noisy_colour
from sim_stubs.realsense.config import ColourNoiseConfig, DepthNoiseConfig
from sim_stubs.realsense.depth_noise import noisy_depth
from vizbot.core.geometry import back_project, invert, rotation_angle, transform
from vizbot.core.types import SE3, RGBDFrame

DISTANCE = 0.6
"""Distance of the wall along the optical axis where it is put up [m]."""
REACH, TURN = 0.25, 0.5
"""Motion of the camera after which the wall stands elsewhere [m, rad]."""
_PAINT, _GLOSS = np.array([215.0, 214.0, 208.0]), np.array([228.0, 228.0, 225.0])
_SKIRTING = 0.16
"""Upper edge of the skirting board below the optical axis [m], where the image still shows it."""
_PLATE, _ROCKER = 0.04, (0.018, 0.028)
"""Half of the sides of the switch's plate and rocker [m]."""
_GROOVE = 0.003
"""Width of the dark seams around switch and skirting board [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class WhiteWall:
    """A wall that stands still in the world.

    Attributes:
        T_world_wall: Pose of the camera that the wall was put up before.
        switch: Middle of the light switch (2,) in x and y of `wall` [m].
        shadow: Where the edge of the shadow crosses the x axis of `wall` [m].
    """

    T_world_wall: SE3
    switch: NDArray[np.float64]
    shadow: float

    @classmethod
    def before(cls, T_world_cam: SE3, rng: np.random.Generator) -> Self:
        """A wall square to the optical axis of a camera; `rng` draws its switch and shadow."""
        return cls(
            T_world_cam, rng.uniform((-0.2, -0.12), (0.2, 0.06)), float(rng.uniform(-0.25, 0.25))
        )

    def holds(self, T_world_cam: SE3) -> bool:
        """Whether the camera is still near enough to where the wall was put up before it."""
        T_wall_cam = invert(self.T_world_wall) @ T_world_cam
        return bool(
            np.linalg.norm(T_wall_cam[:3, 3]) <= REACH and rotation_angle(T_wall_cam) <= TURN
        )

    def seen(self, frame: RGBDFrame, T_world_cam: SE3, rng: np.random.Generator) -> RGBDFrame:
        """The frame with the wall in colour and depth, and the simulated camera's noise in both.

        Args:
            frame: Gives intrinsics, time and inertial samples.
            T_world_cam: Pose of the camera; the wall must hold for it.
            rng: Source of the noise.
        """
        camera = frame.intrinsics
        T_wall_cam = invert(self.T_world_wall) @ T_world_cam
        rays = back_project(np.ones((camera.height, camera.width), np.float32), camera)
        ahead = rays @ T_wall_cam[2, :3]
        depth = (DISTANCE - T_wall_cam[2, 3]) / ahead
        on_wall = transform(T_wall_cam, rays * depth[..., None])
        rgb = noisy_colour(
            self._painted(on_wall[..., 0], on_wall[..., 1]), 1.0, 0.0, ColourNoiseConfig(), rng
        )
        measured = noisy_depth(
            depth.astype(np.float32), rgb, camera, T_world_cam, DepthNoiseConfig(), rng
        )
        return replace(frame, rgb=rgb, depth=measured)

    def _painted(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Colours (H, W, 3) of places (H, W) on the wall [m]; y points down."""
        light = 1.0 - 0.15 * np.tanh(x + 0.5 * y)
        light *= 1.0 - 0.2 * expit((self.shadow + 0.3 * y - x) / 0.02)
        right, below = np.abs(x - self.switch[0]), np.abs(y - self.switch[1])
        beyond_plate = np.maximum(right, below) - _PLATE
        beyond_rocker = np.maximum(right - _ROCKER[0], below - _ROCKER[1])
        glossy = (beyond_plate < 0) | (y > _SKIRTING)
        for beyond in (beyond_plate, beyond_rocker, y - _SKIRTING):
            light[np.abs(beyond) < 0.5 * _GROOVE] *= 0.7
        colour = np.where(glossy[..., None], _GLOSS, _PAINT) * light[..., None]
        return np.asarray(colour.clip(max=247.0), np.uint8)
