"""A simulated home with the robot, which drives, slips, bumps, and takes pictures.

The base moves kinematically against the true shapes of the house; pictures come from MuJoCo.
World frame: z up, floor at z = 0. Poses and names are the truth, for scoring and rendering alone.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property, partial
from math import sqrt
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.occupancy_slice import PlanGrid
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.world.body import Contacts, WorldConfig
from sim_stubs.world.lighting import Lighting
from sim_stubs.world.world_plan import D435I_COLOUR, HouseShape, WorldPlan
from vizbot.core.closeable import Closeable
from vizbot.core.diff_drive import rolled
from vizbot.core.geometry import camera_mount, planar, yaw_of
from vizbot.core.types import SE3, Intrinsics

if TYPE_CHECKING:  # loads MuJoCo
    from sim_stubs.world.renderer import Renderer

MOUNT = camera_mount(height=0.60, forward=0.05, tilt=0.15)
"""Usual place of the camera, T_base_cam."""


class World(Closeable):
    """A `Body` in a house.

    Attributes:
        house: The house.
        seed: Seed of all noise.
        T_base_cam: Mount of the camera.
        intrinsics: True intrinsics of the camera.
        reported_intrinsics: What the camera reports of itself.
        collisions: Number of collisions so far.
        notice: Lines about the world for the user; may be empty.
    """

    def __init__(
        self,
        house: House,
        config: WorldConfig,
        T_base_cam: SE3 = MOUNT,
        seed: int = 0,
        notice: str = "",
        intrinsics: Intrinsics = D435I_COLOUR,
        *,
        shape: Callable[[], HouseShape] | None = None,
    ) -> None:
        """Put the robot at the start of `house`.

        Args:
            house: The house.
            config: The robot's body.
            T_base_cam: True mount of the camera.
            seed: Seed of all noise.
            notice: Lines about the world for the user.
            intrinsics: True intrinsics of the camera, which always reports `D435I_COLOUR`.
            shape: Returns the shape of the house, where somebody else works it out while MuJoCo
                compiles.

        Raises:
            ConfigError: `shape` raises it.
            DeviceError: the machine cannot render.
        """
        from sim_stubs.world.renderer import Renderer

        self.house, self.seed, self.notice = house, seed, notice
        self.T_base_cam = T_base_cam
        self.intrinsics, self.reported_intrinsics = intrinsics, D435I_COLOUR
        self.collisions = 0
        self._config = config
        self._rng = np.random.default_rng((seed, 1))
        spread = config.wheel_scale_noise * self._rng.standard_normal(2)
        self._wheel_scale: list[float] = (config.wheel_scale * (1 + spread)).tolist()
        self._T_world_base = planar(*house.start)
        self._T_world_pictured = self._T_world_base
        self._felt: tuple[SE3, Contacts] | None = None
        self._target = (0.0, 0.0)
        self._speeds = [0.0, 0.0]
        self._travel = [0.0, 0.0]
        self._blocked = False
        self._motion: list[tuple[float, float, float]] = []
        outline = config.outline(float(T_base_cam[2, 3]), float(T_base_cam[0, 3]))
        known = cache(shape or partial(HouseShape.for_robot, house, outline, intrinsics))
        lighting = Lighting.drawn(np.random.default_rng((seed, 3)))
        self._eye: Renderer = Renderer(
            house, intrinsics, lighting, visibility=lambda: known().visibility
        )
        self._touch = known().touch

    @classmethod
    def of_plan(
        cls,
        plan: WorldPlan,
        config: WorldConfig,
        T_base_cam: SE3,
        shape: Callable[[], HouseShape],
    ) -> Self:
        """Open a planned world; arguments and errors are those of the constructor."""
        return cls(plan.house, config, T_base_cam, plan.seed, plan.notice, shape=shape)

    @property
    def instances(self) -> tuple[Instance, ...]:
        """Furniture of the house, for scoring alone."""
        return self.house.instances

    @property
    def attributions(self) -> list[str]:
        """Author and licence of each model that is not procedural."""
        return sorted({it.piece.attribution for it in self.instances if it.piece.attribution})

    @property
    def T_world_base(self) -> SE3:
        """True pose of the base, for scoring and rendering alone."""
        return self._T_world_base.copy()

    @property
    def T_world_pictured(self) -> SE3:
        """True pose of the base at the last picture, or at the start, for scoring alone."""
        return self._T_world_pictured.copy()

    @cached_property
    def free(self) -> tuple[NDArray[np.bool_], PlanGrid]:
        """Cells (rows, cols) of the plan where the robot can stand without contact."""
        return self._touch.free()

    @property
    def wheel_travel(self) -> tuple[float, float]:
        """Signed rim travel of the left and right wheel since the start [m], slip included."""
        return self._travel[0], self._travel[1]

    @property
    def contacts(self) -> Contacts:
        """Current contacts."""
        T = self._T_world_base
        if self._felt is None or self._felt[0] is not T:
            x, y = float(T[0, 3]), float(T[1, 3])
            self._felt = T, self._touch.contacts(x, y, yaw_of(T))
        return self._felt[1]

    def set_wheel_speeds(self, left: float, right: float) -> None:
        """Turn the wheels at these rim speeds [m/s] until the next command."""
        self._target = left, right

    def advance(self, seconds: float) -> None:
        """Let `seconds` pass: the wheels turn, the body moves, slips and bumps."""
        steps = max(1, int(np.ceil(seconds / self._config.step - 1e-9)))
        for _ in range(steps):
            self._advance_once(seconds / steps)

    def place(self, x: float, y: float, yaw: float) -> None:
        """Move the robot to another pose, even into an obstacle, without recording a motion."""
        self._T_world_base = planar(x, y, yaw)

    def drain_motion(self) -> NDArray[np.float64]:
        """True motion (N, 3) since the last call, in steps: seconds, v [m/s], yaw rate [rad/s]."""
        motion = np.array(self._motion, np.float64).reshape(-1, 3)
        self._motion.clear()
        return motion

    def render(self) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """The camera's colour (H, W, 3) and depth (H, W) [m], 0 without a surface."""
        self._T_world_pictured = self._T_world_base
        return self.render_from(self._T_world_base)

    def render_from(self, T_world_base: SE3) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """The camera's colour and depth with the robot at another pose."""
        return self._eye.render(T_world_base @ self.T_base_cam)

    def segment(self, turn: float = 0.0) -> NDArray[np.int32]:
        """Index in `instances` that each pixel (H, W) shows after a turn [rad]; else -1."""
        return self.segment_from(self._T_world_base @ planar(0, 0, turn))

    def segment_from(self, T_world_base: SE3) -> NDArray[np.int32]:
        """Index in `instances` that each pixel (H, W) shows from that pose; -1 for structure."""
        return self._eye.segment(T_world_base @ self.T_base_cam)

    def top_view(self) -> NDArray[np.uint8]:
        """Picture (H, W, 3) of the true home from above, north up."""
        return self._eye.plan(*self._seen_from_above())

    def _seen_from_above(self) -> tuple[NDArray[np.float64], float]:
        """Middle (2,) of the top view and its extent from south to north [m]."""
        rooms = [room.polygon for room in self.house.rooms]
        corners = np.concatenate(rooms or [triangles(self.house.parts()).reshape(-1, 3)[:, :2]])
        low, high = corners.min(axis=0), corners.max(axis=0)
        ratio = self.intrinsics.width / self.intrinsics.height
        extent = max(high[1] - low[1], (high[0] - low[0]) / ratio) + 0.8
        return (low + high) / 2, float(extent)

    def close(self) -> None:
        """Free the renderer."""
        self._eye.close()

    def _advance_once(self, dt: float) -> None:
        config = self._config
        change = config.wheel_acceleration * dt
        ways = [0.0, 0.0]
        for wheel, noise in enumerate(self._rng.standard_normal(2).tolist()):
            before = self._speeds[wheel]
            now = before + max(-change, min(change, self._target[wheel] - before))
            travel = (before + now) / 2 * dt
            self._speeds[wheel] = now
            self._travel[wheel] += travel
            slip = config.slip_noise * sqrt(abs(travel)) * noise
            ways[wheel] = travel * self._wheel_scale[wheel] + slip
        T_now_next = rolled(ways[0], ways[1], config.wheel_base)

        if any(self.contacts.wheel_drops):
            T_now_next = np.eye(4)  # a hanging wheel pushes nothing
        T_now_next, free = self._stopped_at_contact(T_now_next)
        if not free and not self._blocked:
            self.collisions += 1
        self._blocked = not free
        self._T_world_base = self._T_world_base @ T_now_next
        forward = float(np.copysign(sqrt(T_now_next[0, 3] ** 2 + T_now_next[1, 3] ** 2),
                                    T_now_next[0, 3]))  # fmt: skip
        self._motion.append((dt, forward / dt, yaw_of(T_now_next) / dt))

    def _stopped_at_contact(self, T_now_next: SE3) -> tuple[SE3, bool]:
        """The free part of a step, and whether all of it was free.

        A round body turns on the spot even in contact; it does not slide along what it touches.
        """
        T = self._T_world_base
        now = self._touch.gap(T[0, 3], T[1, 3], yaw_of(T))
        for share in (1.0, 0.75, 0.5, 0.25, 0.0):
            T_try = T_now_next.copy()
            T_try[:2, 3] *= share
            T_then = T @ T_try
            gap = self._touch.gap(T_then[0, 3], T_then[1, 3], yaw_of(T_then))
            # Out of an overlap (after `place`) every way that widens the gap is open.
            if gap >= min(0.0, now):
                return T_try, share == 1.0
        return np.eye(4), False
