"""A large bare room without a renderer: depth by plane geometry, for thousands of short drives."""

from __future__ import annotations

from math import floor

import numpy as np
from numpy.typing import NDArray

from sim_stubs.world.body import Body
from vizbot.core.closeable import Closeable
from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.geometry import back_project
from vizbot.core.interfaces import Clock
from vizbot.core.types import SE3, ImuSamples, Intrinsics, RGBDFrame

CAMERA = Intrinsics(160, 120, 154.25, 154.25, 79.5, 59.5)
"""A D435i's colour camera at a quarter of its resolution."""
HALF_WIDTH = 10.0
"""Distance of the walls from the middle of the room [m]."""
_GREY = 120


class BoxCamera(Closeable):
    """A `Camera` on a body in the room; its frames are grey and have no inertial samples."""

    def __init__(self, body: Body, clock: Clock, T_base_cam: SE3, rate: float) -> None:
        """Take `rate` frames a second."""
        self._body = body
        self._clock = clock
        self._T_base_cam = T_base_cam
        self._rate = rate
        self._frames = floor(clock.now() * rate + 1e-6)
        self._last = clock.now()
        unit_depth = np.ones((CAMERA.height, CAMERA.width), np.float32)
        self._rays_cam = back_project(unit_depth, CAMERA).reshape(-1, 3)
        self.intrinsics = CAMERA

    def read(self, timeout: float = 1.0) -> RGBDFrame:
        """The next frame when it is due; a caller who comes late gets one of now.

        Raises:
            DeviceTimeoutError: it is due later than `timeout` [s] from now.
        """
        wait = (self._frames + 1) / self._rate - self._clock.now()
        if wait > timeout + 1e-9:
            self._clock.sleep(timeout)
            raise DeviceTimeoutError(f"no frame within {timeout} s; take them faster")
        if wait > 0:
            self._clock.sleep(wait)
        stamp = self._clock.now()
        self._frames = floor(stamp * self._rate + 1e-6)
        stamps, self._last = np.linspace(self._last, stamp, 9)[1:], stamp
        still = np.zeros((len(stamps), 3))
        shape = CAMERA.height, CAMERA.width
        return RGBDFrame(
            stamp,
            np.full((*shape, 3), _GREY, np.uint8),
            self._depth().reshape(shape),
            CAMERA,
            ImuSamples(stamps, still, stamps, still - (0.0, 9.81, 0.0)),
        )

    def close(self) -> None:
        """Do nothing: the camera holds no resource."""

    def _depth(self) -> NDArray[np.float32]:
        """Along each ray (N,) to the floor or the nearest wall [m]."""
        T_world_cam = self._body.T_world_base @ self._T_base_cam
        rays, origin = self._rays_cam @ T_world_cam[:3, :3].T, T_world_cam[:3, 3]
        with np.errstate(divide="ignore"):
            to_floor = np.where(rays[:, 2] < 0.0, -origin[2] / rays[:, 2], np.inf)
            to_walls = (np.sign(rays[:, :2]) * HALF_WIDTH - origin[:2]) / rays[:, :2]
        depth = np.minimum(to_floor, np.nanmin(to_walls, axis=1))
        return np.asarray(np.clip(depth, 0.0, 65.0), np.float32)
