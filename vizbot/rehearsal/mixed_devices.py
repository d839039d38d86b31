"""Wrappers for rehearsals with one real and one simulated device."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import TYPE_CHECKING

from vizbot.core.closeable import Closeable
from vizbot.core.geometry import yaw_of
from vizbot.core.interfaces import Base, Camera
from vizbot.core.types import BaseState, Feedback, ImuSamples, Intrinsics, RGBDFrame, Twist

if TYPE_CHECKING:  # its module loads MuJoCo
    from sim_stubs.world.world import World

log = logging.getLogger(__name__)


_CONTACT = (
    "simulated contact: the robot touches something in its world alone, and the real base backs off"
    " as from a wall; keep 1 m around it free, or start it elsewhere with --start"
)


class WithoutImu(Closeable):
    """A camera without its IMU, which does not turn with the simulated base."""

    def __init__(self, camera: Camera) -> None:
        self._camera = camera

    @property
    def intrinsics(self) -> Intrinsics:
        """Intrinsics of the camera."""
        return self._camera.intrinsics

    def read(self, timeout: float = 1.0) -> RGBDFrame | None:
        """The camera's frame without inertial samples."""
        frame = self._camera.read(timeout)
        return None if frame is None else replace(frame, imu=ImuSamples.none())

    def close(self) -> None:
        """Close the camera."""
        self._camera.close()


class FollowedBase(Closeable):
    """A real base whose encoders move the simulated robot.

    Simulated contacts are added to the real ones, so that the simulated robot does not drive
    through walls.
    """

    def __init__(self, base: Base, world: World) -> None:
        """Begin where the real robot starts.

        Args:
            base: The real base.
            world: Its robot stands where the real one starts.
        """
        self._base = base
        self._world = world
        self._T_world_odom = world.T_world_base
        self._touched = self._told = False

    def drive(self, twist: Twist) -> None:
        """Drive the real base."""
        self._base.drive(twist)

    def resume(self) -> None:
        """Ask the real base to obey again."""
        self._base.resume()

    def dock(self) -> None:
        """Make the real base look for its dock."""
        self._base.dock()

    def show(self, feedback: Feedback) -> None:
        """Show feedback on the real base."""
        self._base.show(feedback)

    def read(self) -> BaseState:
        """The real base's state with the bumps of the world added."""
        state = self._base.read()
        T_world_base = self._T_world_odom @ state.T_odom_base
        self._world.place(
            float(T_world_base[0, 3]), float(T_world_base[1, 3]), yaw_of(T_world_base)
        )
        contacts = self._world.contacts
        touches = contacts.bump_left or contacts.bump_right
        if touches and not self._touched:
            level = logging.INFO if self._told else logging.WARNING
            log.log(level, _CONTACT)
            self._told = True
        self._touched = touches
        return replace(
            state,
            bump_left=state.bump_left or contacts.bump_left,
            bump_right=state.bump_right or contacts.bump_right,
        )

    def close(self) -> None:
        """Close the real base."""
        self._base.close()
