"""A textured box room, ray cast, and paths of a robot through it."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, lru_cache
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.slam.config import SlamConfig
from mapping.slam.slam import Slam
from vizbot.config import PerceptionConfig
from vizbot.core.geometry import camera_mount, invert, planar, rotation_angle, transform, yaw_of
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import SE3, ImuSamples, Intrinsics, PoseEstimate, RGBDFrame
from vizbot.perception.perception import Perception

CAMERA = Intrinsics(320, 240, 307.0, 307.0, 159.5, 119.5)
T_BASE_CAM = camera_mount(height=0.6, forward=0.1, tilt=0.1)
ROOM = np.array([[-2.5, -2.0, 0.0], [2.5, 2.0, 2.4]])
TEXELS = 150.0
_V, _U = np.mgrid[: CAMERA.height, : CAMERA.width]
RAYS = np.stack(
    ((_U - CAMERA.cx) / CAMERA.fx, (_V - CAMERA.cy) / CAMERA.fy, np.ones(_U.shape)), axis=-1
)


WALLS, ELSEWHERE = 7, 8
"""Seeds of their textures."""


@cache
def textures(seed: int) -> list[NDArray[np.uint8]]:
    """Six walls of coloured rectangles on noise: lower and upper along x, then y, then z."""
    rng = np.random.default_rng(seed)
    walls = []
    for _ in range(6):
        wall = rng.normal(150, 12, (64, 64, 3))
        wall = cv2.resize(wall, (800, 800), interpolation=cv2.INTER_CUBIC)
        for _ in range(150):
            (u, v), (w, h) = rng.integers(0, 780, 2), rng.integers(8, 60, 2)
            wall[v : v + h, u : u + w] = rng.uniform(40, 230, 3)
        walls.append(cv2.GaussianBlur(np.clip(wall, 0, 255), (0, 0), 1.0).astype(np.uint8))
    return walls


def render(T_map_base: SE3, stamp: float, *, dark: bool = False, walls: int = WALLS) -> RGBDFrame:
    """What the camera sees, with noise of sensor and depth that a stamp repeats."""
    return _rendered(T_map_base.tobytes(), stamp, dark, walls)


@lru_cache(maxsize=256)  # many robots drive the same lap
def _rendered(T_map_base_bytes: bytes, stamp: float, dark: bool, walls: int) -> RGBDFrame:
    T_map_base = np.frombuffer(T_map_base_bytes).reshape(4, 4)
    rng = np.random.default_rng(round(stamp * 1000))
    T_map_cam = T_map_base @ T_BASE_CAM
    directions = RAYS @ T_map_cam[:3, :3].T
    with np.errstate(divide="ignore"):
        reach = (np.where(directions > 0, ROOM[1], ROOM[0]) - T_map_cam[:3, 3]) / directions
    axis = reach.argmin(axis=-1)
    depth = reach.min(axis=-1)
    points = transform(T_map_cam, RAYS * depth[..., None]) - ROOM[0]
    texels = [points[..., k].astype(np.float32) * np.float32(TEXELS) for k in range(3)]
    side = np.take_along_axis(directions > 0, axis[..., None], axis=-1)[..., 0]
    rgb = np.zeros((*depth.shape, 3), np.float64)
    for wall, texture in enumerate(textures(walls)):
        on = axis * 2 + side == wall
        if on.any():
            a, b = (texels[k] for k in range(3) if k != wall // 2)
            looked_up = cv2.remap(texture, a, b, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
            np.copyto(rgb, looked_up, where=on[..., None])
    if dark:
        rgb[:] = 3.0
    rgb += rng.normal(0, 3, rgb.shape)
    depth = depth + rng.normal(0, 1, depth.shape) * 0.003 * depth**2
    depth[rng.random(depth.shape) < 0.05] = 0.0
    return RGBDFrame(
        stamp,
        np.clip(rgb, 0, 255).astype(np.uint8),
        depth.astype(np.float32),
        CAMERA,
        ImuSamples.none(),
    )


def with_gyro(frame: RGBDFrame, turn: float) -> RGBDFrame:
    """The frame of a camera that turned by `turn` [rad] about the base's z axis in 0.2 s."""
    stamps = frame.stamp - 0.2 + np.arange(1, 41) * 0.005
    rates = np.tile(turn / 0.2 * T_BASE_CAM[2, :3], (40, 1))
    return replace(frame, imu=ImuSamples(stamps, rates, np.zeros(0), np.zeros((0, 3))))


def turns(Ts_map_base: Sequence[SE3]) -> list[float]:
    """The turn of the base up to each pose of a path [rad]."""
    return [0.0, *(yaw_of(invert(a) @ b) for a, b in pairwise(Ts_map_base))]


def lap(frames: int) -> list[SE3]:
    """T_map_base of one loop by 5 Hz frames, up to 0.3 m/s, back to the start."""
    angles = np.linspace(0, 2 * np.pi, frames)
    return [planar(0.9 * np.sin(a), 0.9 * (1 - np.cos(a)) - 0.9, a) for a in angles]


def dead_reckoning(
    Ts_map_base: Sequence[SE3], scale: float = 1.02, drift: float = 0.02
) -> list[SE3]:
    """Wheels that roll `scale` too far and turn by a fraction `drift` too far."""
    Ts_odom_base = [np.eye(4)]
    for T_map_last, T_map_base in pairwise(Ts_map_base):
        step = invert(T_map_last) @ T_map_base
        turn = np.arctan2(step[1, 0], step[0, 0]) * (1 + drift)
        Ts_odom_base.append(Ts_odom_base[-1] @ planar(step[0, 3] * scale, step[1, 3] * scale, turn))
    return Ts_odom_base


def follow(
    Ts_map_base: Sequence[SE3],
    Ts_odom_base: Sequence[SE3] | None,
    dark: range = range(0),
) -> tuple[Slam, list[PoseEstimate]]:
    """Poses estimated along a path, in the dark for some of its frames."""
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    estimates = [
        slam.track(
            render(T_map_base, 0.2 * i, dark=i in dark),
            None if Ts_odom_base is None else Ts_odom_base[i],
        )
        for i, T_map_base in enumerate(Ts_map_base)
    ]
    return slam, estimates


def errors(estimates: Sequence[PoseEstimate], Ts_map_base: Sequence[SE3]) -> NDArray[np.float64]:
    """(N, 2) distance [m] and angle [rad] between estimate and truth, from the common start."""
    T_map_start = Ts_map_base[0]
    rows = []
    for estimate, T_map_base in zip(estimates, Ts_map_base, strict=True):
        T_true = invert(T_map_start) @ T_map_base @ T_BASE_CAM
        T = invert(T_true) @ estimate.T_map_cam
        rows.append((np.linalg.norm(T[:3, 3]), rotation_angle(T)))
    return np.array(rows)


AT_ONCE = PerceptionConfig(embedding_latency=0.0)


def mapped(encoder, path, watch=lambda perception: None) -> Perception:
    """Work frames from a path through the box room into a new map."""
    wheels, perception = dead_reckoning(path), None
    for i, T_map_base in enumerate(path):
        frame = render(T_map_base, 0.2 * i)
        if perception is None:
            perception = Perception(frame, T_BASE_CAM, encoder, SimulatedClock(), AT_ONCE)
        perception.embed(frame, perception.update(frame, wheels[i]))
        watch(perception)
    perception.finish()
    return perception
