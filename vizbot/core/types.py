"""Data that crosses folders. SI units and radians throughout.

Frames: `map` (z up, fixed where the robot started), `odom` (dead reckoning), `base` (x forward,
y left, z up, on the floor between the wheels; REP 103), `cam` (x right, y down, z forward).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, StrEnum
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

SE3: TypeAlias = NDArray[np.float64]
"""(4, 4) rigid transform. `T_a_b` maps points in frame b to frame a: p_a = T_a_b @ p_b."""


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """A pinhole camera without distortion.

    Attributes:
        width: Image width [px].
        height: Image height [px].
        fx: Focal length along the rows [px].
        fy: Focal length along the columns [px].
        cx: Principal point, column [px]; pixel centres are whole numbers.
        cy: Principal point, row [px].
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    @property
    def K(self) -> NDArray[np.float64]:
        """(3, 3) intrinsic matrix of the paper's equation 2."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, slots=True, eq=False)
class ImuSamples:
    """Inertial samples in arrival order, in the axes of `cam`.

    Attributes:
        gyro_stamps: (N,) float64 [s], the clock of the frames.
        gyro: (N, 3) float64 angular rate [rad/s].
        accel_stamps: (M,) float64 [s].
        accel: (M, 3) float64 specific force [m/s^2]; a level camera at rest reads (0, -9.8, 0).
    """

    gyro_stamps: NDArray[np.float64]
    gyro: NDArray[np.float64]
    accel_stamps: NDArray[np.float64]
    accel: NDArray[np.float64]

    @staticmethod
    def none() -> ImuSamples:
        """No samples, for cameras without an IMU."""
        return ImuSamples(np.zeros(0), np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)))


@dataclass(frozen=True, slots=True, eq=False)
class RGBDFrame:
    """One colour image and the depth image registered to it.

    Attributes:
        stamp: Capture time [s] on the device's clock.
        rgb: (H, W, 3) uint8.
        depth: (H, W) float32, distance along the optical axis [m]; 0 where nothing was measured.
        intrinsics: Shared by both images.
        imu: Samples since the previous frame.
    """

    stamp: float
    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    intrinsics: Intrinsics
    imu: ImuSamples


@dataclass(frozen=True, slots=True)
class Twist:
    """Velocity of a planar base in its own frame.

    Attributes:
        linear: Along x, forward [m/s].
        angular: About z, counter-clockwise [rad/s].
    """

    linear: float
    angular: float


STOP = Twist(0.0, 0.0)


class BaseMode(IntEnum):
    """Open Interface modes of the Roomba (manual p. 7, packet 35)."""

    OFF = 0
    PASSIVE = 1
    SAFE = 2
    FULL = 3

    @property
    def obeys(self) -> bool:
        """Whether the base drives as it is commanded."""
        return self in (BaseMode.SAFE, BaseMode.FULL)


class Feedback(StrEnum):
    """What a base can show by light and sound."""

    LISTENING = "listening"
    FOUND = "found"
    NOT_FOUND = "not found"
    STUCK = "stuck"
    DOUBT = "doubt"


class Button(StrEnum):
    """Buttons of the base (manual p. 27, packet 18); the 600 series has the first three."""

    CLEAN = "clean"
    SPOT = "spot"
    DOCK = "dock"
    MINUTE = "minute"
    HOUR = "hour"
    DAY = "day"
    SCHEDULE = "schedule"
    CLOCK = "clock"


class Charging(StrEnum):
    """State of the charger (manual p. 28, packet 21)."""

    NOT_CHARGING = "not charging"
    RECONDITIONING = "reconditioning"
    FULL_CHARGING = "full charging"
    TRICKLE = "trickle"
    WAITING = "waiting"
    FAULT = "fault"


@dataclass(frozen=True, slots=True, eq=False)
class BaseState:
    """What the base reports about itself.

    Attributes:
        stamp: Time of the newest sensor frame [s] on the clock the base was opened with.
        T_odom_base: Dead reckoning from the wheel encoders since the base was opened.
        cliffs: Left, front left, front right, right: no floor below.
        wheel_drops: Left, right: the wheel hangs.
        battery: State of charge, 0 to 1; None when the base does not report it.
        virtual_wall: The beam of a virtual wall is received.
        overcurrents: Left, right: the wheel is stuck and its motor draws too much.
        light_bumpers: Left, front left, centre left, centre right, front right, right: something
            reflects right in front of the bumper.
        rolls: Whether the caster wheel at the front measures motion ahead; None where it is too
            dirty. It measures neither turns nor motion backwards.
        docked: The base stands on the contacts of a dock that has power.
        plugged_in: The cable of a charger is plugged in.
        infrared: Characters received from all around, from the left and from the right; 0 is none.
        voltage: Voltage of the battery [V].
        current: Into the battery [A]; negative while it is drained.
        maybe_moved: It left the mode in which it obeys while nobody heard it, so that somebody may
            have moved it. It rests until it is asked to obey again.
    """

    stamp: float
    T_odom_base: SE3
    bump_left: bool
    bump_right: bool
    cliffs: tuple[bool, bool, bool, bool]
    wheel_drops: tuple[bool, bool]
    battery: float | None
    mode: BaseMode
    virtual_wall: bool = False
    overcurrents: tuple[bool, bool] = (False, False)
    light_bumpers: tuple[bool, bool, bool, bool, bool, bool] = (
        False,
        False,
        False,
        False,
        False,
        False,
    )
    rolls: bool | None = None
    buttons: frozenset[Button] = frozenset()
    charging: Charging = Charging.NOT_CHARGING
    docked: bool = False
    plugged_in: bool = False
    infrared: tuple[int, int, int] = (0, 0, 0)
    voltage: float | None = None
    current: float | None = None
    song_playing: bool = False
    maybe_moved: bool = False

    @property
    def bumped(self) -> bool:
        """Whether the bumper is pressed anywhere."""
        return self.bump_left or self.bump_right

    @property
    def on_charger(self) -> bool:
        """Whether the base stands on a dock with power, or a charger is plugged in."""
        charges = self.charging not in (Charging.NOT_CHARGING, Charging.FAULT)
        return self.docked or self.plugged_in or charges

    @property
    def blocked(self) -> bool:
        """Whether a bump, a virtual wall or a stuck wheel keeps the base from driving ahead."""
        return self.bumped or self.virtual_wall or any(self.overcurrents)


class Tracking(StrEnum):
    """How far a pose can be trusted."""

    TRACKING = "tracking"
    WHEELS_ONLY = "wheels only"
    LOST = "lost"
    RELOCALISED = "relocalised"

    @property
    def by_images(self) -> bool:
        """Whether the pose comes from matched images."""
        return self in (Tracking.TRACKING, Tracking.RELOCALISED)


@dataclass(frozen=True, slots=True, eq=False)
class PoseEstimate:
    """Where a frame was taken.

    Attributes:
        stamp: Stamp of the frame [s].
        T_map_cam: Best estimate when the frame arrived (the online pose).
        keyframe: Id of the keyframe the frame is anchored to.
        T_keyframe_cam: Where the camera was relative to that keyframe; a graph update leaves it.
        is_keyframe: Whether this frame itself became that keyframe.
        tracking: Whether images, only wheels, or nothing supports the pose.
        covariance: (6, 6) of the right perturbation of `T_keyframe_cam`, rotation [rad] first,
            then translation [m], estimated from images; None where the pose is not from images.
    """

    stamp: float
    T_map_cam: SE3
    keyframe: int
    T_keyframe_cam: SE3
    is_keyframe: bool
    tracking: Tracking
    covariance: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class OccupancyGrid:
    """A 2D obstacle map; only its methods convert between metres (x, y) and cells (row, col).

    Attributes:
        occupancy: (rows, cols) float32 in [0, 1]; 0.5 unknown; row grows with y, col with x.
        resolution: Width of a cell [m].
        origin: (2,) x, y of the outer corner of cell [0, 0] in `map` [m].
        zones: Polygons (K, 2) of corners x, y in `map` [m] that people forbid the robot to enter.
    """

    occupancy: NDArray[np.float32]
    resolution: float
    origin: NDArray[np.float64]
    zones: tuple[NDArray[np.float32], ...] = ()

    def to_cells(self, xy: NDArray[np.float64]) -> NDArray[np.int64]:
        """Cells (..., 2) row, col of points (..., 2) x, y [m] in `map`; they may lie outside."""
        return np.floor((xy[..., ::-1] - self.origin[::-1]) / self.resolution).astype(np.int64)

    def to_xy(self, cells: NDArray[np.int64]) -> NDArray[np.float64]:
        """Centres (..., 2) x, y [m] in `map` of cells (..., 2) row, col."""
        return (cells[..., ::-1] + 0.5) * self.resolution + self.origin

    def contains(self, cells: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which cells (..., 2) row, col lie inside, as (...) bool."""
        return np.asarray(((cells >= 0) & (cells < np.array(self.occupancy.shape))).all(axis=-1))
