"""Faults of sensors, put into a recording while it is replayed.

A white wall close before the camera has uneven light, a shadow, a switch and a skirting board.
Frame `wall` is the camera's where the wall was put up: the wall is its plane z = `DISTANCE`.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from benchmarks.slam.replays import ReplayFrame, delayed
from sim_stubs.realsense.config import ColourNoiseConfig, DepthNoiseConfig, SimulatedRealSenseConfig
from sim_stubs.realsense.depth_noise import noisy_colour, noisy_depth
from sim_stubs.world.body import WorldConfig
from vizbot.config import Config
from vizbot.core.diff_drive import rolled
from vizbot.core.geometry import back_project, invert, planar, rotation_angle, transform, yaw_of
from vizbot.core.types import SE3, ImuSamples, RGBDFrame
from vizbot.rehearsal.config import RehearsalConfig

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


@dataclass(frozen=True, slots=True)
class Span:
    """A part of a recording, in time since its first frame [s]."""

    start: float
    end: float

    def holds(self, moment: ReplayFrame, first: ReplayFrame) -> bool:
        """Whether a frame lies in the span."""
        return self.start <= moment.frame.stamp - first.frame.stamp < self.end


Fault = Callable[[Iterable[ReplayFrame]], Iterator[ReplayFrame]]


def dark(span: Span) -> Fault:
    """No light: only noise in colour; depth stays, because its projector gives light."""

    def change(moment: ReplayFrame) -> ReplayFrame:
        frame = moment.frame
        rng = np.random.default_rng(round(1000 * frame.stamp))
        rgb = np.clip(rng.normal(3.0, 2.0, frame.rgb.shape), 0, 255).astype(np.uint8)
        return replace(moment, frame=replace(frame, rgb=rgb))

    return _within(span, change)


def white_wall(span: Span) -> Fault:
    """A white wall close before the camera, in colour and depth.

    It stands still in the world until the camera has moved by `REACH` or turned by `TURN`. Then
    another one stands before it, because the recorded path leads on, where no wall is.
    """

    def fault(moments: Iterable[ReplayFrame]) -> Iterator[ReplayFrame]:
        wall: WhiteWall | None = None

        def change(moment: ReplayFrame) -> ReplayFrame:
            nonlocal wall
            rng = np.random.default_rng(round(1000 * moment.frame.stamp))
            if wall is None or not wall.holds(moment.T_world_cam):
                wall = WhiteWall.before(moment.T_world_cam, rng)
            return replace(moment, frame=wall.seen(moment.frame, moment.T_world_cam, rng))

        return _within(span, change)(moments)

    return fault


def slipping(span: Span, share: float) -> Fault:
    """Wheels that count a `share` more than the robot moves and turns."""

    def fault(moments: Iterable[ReplayFrame]) -> Iterator[ReplayFrame]:
        first: ReplayFrame | None = None
        before, T_slipped = np.eye(4), np.eye(4)
        for moment in moments:
            if first is None:
                first, before, T_slipped = moment, moment.T_odom_base, moment.T_odom_base
            step = invert(before) @ moment.T_odom_base
            before = moment.T_odom_base
            faulty = span.holds(moment, first)
            if faulty:
                x, y = (1 + share) * step[:2, 3]
                step = planar(x, y, (1 + share) * yaw_of(step))
            T_slipped = T_slipped @ step
            yield replace(moment, T_odom_base=T_slipped, faulty=faulty)

    return fault


def gyro_off(span: Span) -> Fault:
    """No samples of gyroscope and accelerometer."""
    return _within(
        span, lambda moment: replace(moment, frame=replace(moment.frame, imu=ImuSamples.none()))
    )


def gyro_biased(span: Span, rate: float) -> Fault:
    """A gyroscope that reads `rate` [rad/s] too much about each axis."""

    def change(moment: ReplayFrame) -> ReplayFrame:
        imu = replace(moment.frame.imu, gyro=moment.frame.imu.gyro + rate)
        return replace(moment, frame=replace(moment.frame, imu=imu))

    return _within(span, change)


def wheels_stuck(span: Span) -> Fault:
    """Encoders that stand still while the robot moves, as when it is lifted or pushed."""
    return slipping(span, -1.0)


def twins(
    first: Iterable[ReplayFrame],
    again: Iterable[ReplayFrame],
    corridor: float,
    config: Config,
    seed: int,
) -> Iterator[ReplayFrame]:
    """A home, and behind a dark corridor another one that looks the same.

    The wheels err in the corridor as the simulated ones do. No image repeats an earlier one bit for
    bit: the corridor and the second home have the camera's noise once more.

    Args:
        first: Frames in the first home.
        again: Frames in the second home, equal to those in the first.
        corridor: Length of the corridor [m]. The robot drives straight through it at 0.3 m/s, so
            that the gyroscope reads what it read while the robot stood at the start.
        config: Mount of the camera in the recordings, errors of wheels and camera.
        seed: Seed of those errors.
    """
    rng = np.random.default_rng((seed, 5))
    T_base_cam = config.mount.T_base_cam
    start: ReplayFrame | None = None
    end: ReplayFrame | None = None
    at_rest = list[RGBDFrame]()
    period = 0.2
    for moment in first:
        start = start or moment
        if end is not None and np.allclose(moment.T_odom_base, start.T_odom_base, atol=1e-9):
            at_rest.append(moment.frame)
        end = moment
        yield moment
    if end is None:
        return
    read = itertools.cycle(at_rest or [replace(end.frame, imu=ImuSamples.none())])
    travelled = np.append(np.arange(0.0, corridor, 0.3 * period), corridor)
    rehearsal = RehearsalConfig.read(config)
    counted = _counted_straight(np.diff(travelled), rehearsal.world, rng)
    for number, (x, T_end_base) in enumerate(zip(travelled[1:], counted, strict=True), start=1):
        stamp, rest = end.frame.stamp + number * period, next(read)
        image = _noisier(end.frame, rehearsal.sim_camera, rng)
        moved = ReplayFrame(
            replace(image, stamp=stamp, imu=delayed(rest.imu, stamp - rest.stamp)),
            end.T_odom_base @ T_end_base,
            end.T_world_cam @ invert(T_base_cam) @ planar(x, 0.0, 0.0) @ T_base_cam,
        )
        yield next(dark(Span(0.0, np.inf))([moved]))
    entered: ReplayFrame | None = None
    for moment in again:
        entered = entered or moment
        later = moved.frame.stamp + period - entered.frame.stamp
        image = _noisier(moment.frame, rehearsal.sim_camera, rng)
        yield ReplayFrame(
            replace(image, stamp=image.stamp + later, imu=delayed(image.imu, later)),
            moved.T_odom_base @ invert(entered.T_odom_base) @ moment.T_odom_base,
            moved.T_world_cam @ invert(entered.T_world_cam) @ moment.T_world_cam,
        )


def _counted_straight(
    steps: NDArray[np.float64], world: WorldConfig, rng: np.random.Generator
) -> list[SE3]:
    """Poses of the base by its wheels, from where it was, after true steps (N,) straight on [m]."""
    scale = 1.0 + world.wheel_scale_noise * rng.standard_normal(2)
    slip = world.slip_noise * np.sqrt(steps)[:, None] * rng.standard_normal((len(steps), 2))
    rolls = (steps[:, None] - slip) / scale
    turns = (rolled(left, right, world.wheel_base) for left, right in rolls)
    return list(itertools.accumulate(turns, np.matmul))


def _noisier(
    frame: RGBDFrame, camera: SimulatedRealSenseConfig, rng: np.random.Generator
) -> RGBDFrame:
    """The frame with the camera's noise in colour and disparity once more; its holes stay."""
    errors = camera.depth_noise
    disparity = DepthNoiseConfig.none().model_copy(
        update={
            "baseline": errors.baseline,
            "disparity_noise": errors.disparity_noise,
            "disparity_step": errors.disparity_step,
        }
    )
    rgb = noisy_colour(frame.rgb, 1.0, 0.0, camera.colour_noise, rng)
    depth = noisy_depth(frame.depth, rgb, frame.intrinsics, np.eye(4), disparity, rng)
    return replace(frame, rgb=rgb, depth=depth)


def _within(span: Span, change: Callable[[ReplayFrame], ReplayFrame]) -> Fault:
    def fault(moments: Iterable[ReplayFrame]) -> Iterator[ReplayFrame]:
        first: ReplayFrame | None = None
        for moment in moments:
            first = first or moment
            held = span.holds(moment, first)
            yield replace(change(moment), faulty=True) if held else moment

    return fault


def kidnapped(span: Span) -> Fault:
    """A robot that is carried, without frames, to where it is at the end of the span.

    Wheels and gyroscope do not sense the motion. The first frame after it counts as faulty.
    """

    def fault(moments: Iterable[ReplayFrame]) -> Iterator[ReplayFrame]:
        first: ReplayFrame | None = None
        T_left: SE3 | None = None
        T_arrived = np.eye(4)
        for moment in moments:
            first = first or moment
            if span.holds(moment, first):
                continue
            if moment.frame.stamp - first.frame.stamp < span.start:
                T_left = moment.T_odom_base
                yield moment
                continue
            arrives = T_left is not None
            if T_left is not None:
                T_arrived, T_left = T_left @ invert(moment.T_odom_base), None
            yield replace(moment, T_odom_base=T_arrived @ moment.T_odom_base, faulty=arrives)

    return fault
