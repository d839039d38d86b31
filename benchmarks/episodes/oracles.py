"""Oracles: parts of the robot switched to the truth, one at a time, to see which one is to blame.

They read the simulated world, so that no part of the robot may use them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING, Self, TypeVar
from zlib import crc32

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.clip.reading import Reading
from mapping.keyframes.config import KeyframeConfig
from mapping.occupancy.config import DepthMapperConfig
from mapping.occupancy.depth_mapper import DepthMapper
from mapping.odometry.features import Features
from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.realsense.config import DepthNoiseConfig
from sim_stubs.scoring.success import GOALS, in_room, instances_of, judge, rooms_of
from sim_stubs.world.world import World
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import back_project, invert, rotation_angle, transform
from vizbot.core.interfaces import Clock, Devices, Pending
from vizbot.core.observer import Outcome, Step
from vizbot.core.types import (
    SE3,
    STOP,
    Intrinsics,
    OccupancyGrid,
    PoseEstimate,
    RGBDFrame,
    Tracking,
)
from vizbot.mission import SETTLING_TIME
from vizbot.objectnav.tasks import Errand, Goal
from vizbot.perception.interfaces import PerceptionParts
from vizbot.rehearsal.config import RehearsalConfig

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder
    from vizbot.pipeline import Pipeline

T = TypeVar("T")

ORACLES = ("pose", "depth", "encoder", "map")


@dataclass(frozen=True, slots=True, eq=False)
class OracleParts:
    """The parts that replace those of the robot in a run; None keeps the robot's part.

    Attributes:
        config: Settings, with or without the camera's depth noise.
        perception: Pose estimator that reads the true pose, or obstacle mapper that reads the
            true plan.
        encoder: Encoder that reads the true instances.
    """

    config: Config
    perception: PerceptionParts | None = None
    encoder: ClipEncoder | None = None


def oracle_parts(oracle: str | None, world: World, config: Config) -> OracleParts:
    """Switch one part to the truth; None switches none.

    Raises:
        ConfigError: there is no such oracle.
    """
    match oracle:
        case None | "stop":  # a perfect stop replaces no part: it ends the search
            return OracleParts(config)
        case "pose":
            slam = TruePose.in_world(world, config.perception.slam.keyframes)
            return OracleParts(config, PerceptionParts(slam=slam))
        case "depth":
            return OracleParts(without_depth_noise(config))
        case "encoder":
            return OracleParts(config, encoder=TrueEncoder(world, GOALS))
        case "map":
            depth_mapper = TrueMap(world, config.perception.depth_mapper)
            return OracleParts(config, PerceptionParts(depth_mapper=depth_mapper))
    raise ConfigError(f"no oracle {oracle!r}; give one of {', '.join(ORACLES)}")


def without_depth_noise(config: Config) -> Config:
    """Settings of a camera that measures the true depth at every pixel."""
    rehearsal = RehearsalConfig.read(config)
    camera = rehearsal.sim_camera.model_copy(update={"depth_noise": DepthNoiseConfig.none()})
    return rehearsal.model_copy(update={"sim_camera": camera}).within(config)


class TruePose:
    """A pose estimator that is told the truth."""

    def __init__(
        self, pose_at: Callable[[float], tuple[SE3, bool]], config: KeyframeConfig
    ) -> None:
        """`pose_at` a stamp [s] gives T_map_cam, and whether that is known: else it is lost."""
        self._pose_at = pose_at
        self._config = config
        self._Ts_map_keyframe: list[SE3] = []

    @classmethod
    def in_world(cls, world: World, config: KeyframeConfig) -> Self:
        """One that reads the world as it is when asked; `map` is the pose of the base now."""
        T_map_world = invert(world.T_world_base)
        return cls(lambda _: (T_map_world @ world.T_world_base @ world.T_base_cam, True), config)

    def track(self, frame: RGBDFrame, T_odom_base: SE3 | None) -> PoseEstimate:
        """The true pose of the camera; nothing has moved since the frame was taken."""
        return self.lift(frame.stamp)

    def lift(self, stamp: float) -> PoseEstimate:
        """The true pose of the camera while the robot is lifted."""
        T_map_cam, known = self._pose_at(stamp)
        due = not self._Ts_map_keyframe or (known and self._is_far(T_map_cam))
        if due:
            self._Ts_map_keyframe.append(T_map_cam)
        return PoseEstimate(
            stamp,
            T_map_cam,
            len(self._Ts_map_keyframe) - 1,
            invert(self._Ts_map_keyframe[-1]) @ T_map_cam,
            due,
            Tracking.TRACKING if known else Tracking.LOST,
        )

    def keyframe_poses(self) -> dict[int, SE3]:
        """T_map_cam of every keyframe by its id."""
        return dict(enumerate(self._Ts_map_keyframe))

    @property
    def closures(self) -> list[tuple[int, int]]:
        """No loop closures: the poses are true."""
        return []

    def features(self) -> dict[int, Features]:
        """None: this estimator recognises no place."""
        return {}

    def _is_far(self, T_map_cam: SE3) -> bool:
        T_keyframe_cam = invert(self._Ts_map_keyframe[-1]) @ T_map_cam
        distance = float(np.linalg.norm(T_keyframe_cam[:3, 3]))
        return distance > self._config.distance or rotation_angle(T_keyframe_cam) > (
            self._config.angle
        )


class TrueMap:
    """An obstacle mapper that reads the true plan, but only where the robot has looked.

    A map known from the start would leave nothing to explore. The truth is placed relative to the
    estimated pose, so that errors of the pose estimator stay in the map.
    """

    def __init__(self, world: World, config: DepthMapperConfig) -> None:
        self._world = world
        self._seen = DepthMapper(config)
        space = FreeSpace.from_house(world.house)
        self._plan = space.grid
        # Cells of the obstacle map are wider than those of the plan; none that they touch is lost.
        blocked = (space.clear == 0).astype(np.uint8)
        self._blocked = cv2.dilate(blocked, np.ones((3, 3), np.uint8)).astype(np.bool_)
        self._T_world_map = world.T_world_base

    def integrate(
        self,
        keyframe: int,
        T_keyframe_cam: SE3,
        T_map_cam: SE3,
        depth: NDArray[np.float32],
        intrinsics: Intrinsics,
    ) -> None:
        """Mark what the frame shows as seen."""
        self._seen.integrate(keyframe, T_keyframe_cam, T_map_cam, depth, intrinsics)
        T_world_cam = self._world.T_world_base @ self._world.T_base_cam
        self._T_world_map = T_world_cam @ invert(T_map_cam)

    def mark_obstacle(
        self, T_map_base: SE3, points: NDArray[np.float64], *, touched: bool = False
    ) -> None:
        """Do nothing: contacts are part of the true plan."""

    def infer_obstacle(self, T_map_base: SE3, points: NDArray[np.float64]) -> None:
        """Mark the points as seen: the true plan tells what stands there."""
        self._seen.infer_obstacle(T_map_base, points)

    def forget_touched(self) -> bool:
        """Do nothing."""
        return False

    def mark_free(self, T_map_base: SE3, radius: float) -> None:
        """Mark the floor around the base as seen."""
        self._seen.mark_free(T_map_base, radius)

    def follow(self, keyframe_poses: dict[int, SE3]) -> bool:
        """Move the seen area with the pose graph."""
        return self._seen.follow(keyframe_poses)

    def grid(self) -> OccupancyGrid:
        """The true plan where the robot has looked, unknown elsewhere."""
        seen = self._seen.grid()
        known = np.argwhere(seen.occupancy != 0.5)
        xy = seen.to_xy(known)
        p_world = transform(self._T_world_map, np.column_stack([xy, np.zeros(len(xy))]))
        column, row = np.floor(
            (p_world[:, :2] - self._plan.origin) / self._plan.resolution
        ).astype(np.int64).T  # fmt: skip
        inside = (row >= 0) & (row < self._plan.shape[0])
        inside &= (column >= 0) & (column < self._plan.shape[1])
        blocked = np.ones(len(known), np.bool_)
        blocked[inside] = self._blocked[row[inside], column[inside]]
        occupancy = np.full(seen.occupancy.shape, 0.5, np.float32)
        occupancy[known[:, 0], known[:, 1]] = blocked
        return OccupancyGrid(occupancy, seen.resolution, seen.origin)


class PerfectStop:
    """A pipeline whose search ends, as arrived, where the robot first stands where that is true.

    Where the search itself says before that it has arrived, or gives up, that counts.
    """

    def __init__(self, pipeline: Pipeline, devices: Devices, world: World) -> None:
        self._pipeline, self._devices, self._world = pipeline, devices, world
        self.goal, self.report = pipeline.goal, pipeline.report

    @property
    def steps(self) -> int:
        """Number of steps so far."""
        return self._pipeline.steps

    def tick(self, task: Errand) -> Step | None:
        """Do one step; the last one where a stop after it is a success."""
        step, base = self._pipeline.tick(task), self._devices.base
        assert isinstance(task, Goal) and base is not None
        if step is None or step.ended or not self._has_arrived(task):
            return step
        base.drive(STOP)
        self._devices.clock.sleep(SETTLING_TIME)  # it rolls on, and may have been at the edge
        if not self._has_arrived(task):
            return step
        return replace(step, ended=(Outcome.ARRIVED, "a stop here is a success"))

    def _has_arrived(self, goal: Goal) -> bool:
        return judge(self._world, goal.text, stopped=True).success


class AtOnce:
    """A clock whose work is done where it is started: the truth is that of this moment.

    Its result is ready after its latency all the same.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock, self.simulated = clock, clock.simulated
        self.now, self.sleep, self.repeat = clock.now, clock.sleep, clock.repeat

    def start(self, work: Callable[[], T], latency: float) -> Pending[T]:
        """Do `work`."""
        done: Future[T] = Future()
        try:
            done.set_result(work())
        except Exception as error:
            done.set_exception(error)
        return self._clock.start(done.result, latency)


_LIKE_NOTHING = ((0.1, sqrt(0.99)), (-0.1, sqrt(0.99)))
"""What other texts have on the axis of everything else, and on one that no picture has."""


class TrueEncoder:
    """A `ClipEncoder` that reads what each pixel shows.

    Each goal has an axis, and everything else has one. An image with the share s of a goal has the
    cosine sqrt(s / 2) with it, because a pixel belongs to one thing and one room at most.
    """

    model_id = "truth"
    log_odds: tuple[float, float] | None = (25.0, -8.0)
    """Even odds for a patch of which a fifth shows the goal, -8 for one that shows none of it."""
    notice: str | None = None
    threshold = sqrt(0.2 / 2)
    """The similarity of a patch of which a fifth shows the goal."""

    def __init__(self, world: World, goals: Sequence[str]) -> None:
        self._world = world
        self._goals = tuple(goals)
        self.dimension = len(goals) + 2

    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows, of patches of the frame that the robot has just taken.

        A patch is a NumPy view of the frame's image, which gives its position in the frame. Other
        pictures show nothing that is known.
        """
        embeddings = np.zeros((len(images), self.dimension), np.float32)
        if not images:
            return embeddings
        size = self._world.intrinsics.height, self._world.intrinsics.width
        shown: NDArray[np.bool_] | None = None
        for row, image in zip(embeddings, images, strict=True):
            frame = image if image.base is None else image.base
            assert isinstance(frame, np.ndarray)
            if frame.shape[:2] != size:
                row[-2] = 1.0
                continue
            shown = self._shown() if shown is None else shown
            v, offset = divmod(image.ctypes.data - frame.ctypes.data, frame.strides[0])
            u = offset // frame.strides[1]
            patch = shown[:, v : v + image.shape[0], u : u + image.shape[1]]
            row[:-2] = np.sqrt(patch.mean(axis=(1, 2)) / 2)
            row[-2] = sqrt(max(0.0, 1.0 - float(row @ row)))
        return np.asarray(embeddings / np.linalg.norm(embeddings, axis=1, keepdims=True))

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows; a text that is no goal is like nothing, to a tenth."""
        embeddings = np.zeros((len(texts), self.dimension), np.float32)
        for row, text in zip(embeddings, texts, strict=True):
            if text in self._goals:
                row[self._goals.index(text)] = 1.0
            else:
                row[-2:] = _LIKE_NOTHING[crc32(text.encode()) % 2]
        return embeddings

    def reading(self, text: str) -> Reading:
        """The text as it is."""
        return Reading(text)

    def _shown(self) -> NDArray[np.bool_]:
        """(goals, H, W) which pixels of the camera show each goal."""
        instance = self._world.segment()
        depth = self._world.render()[1]
        p_cam = back_project(depth, self._world.intrinsics)
        T_world_cam = self._world.T_world_base @ self._world.T_base_cam
        xy = transform(T_world_cam, p_cam.reshape(-1, 3))[:, :2]
        shown = np.zeros((len(self._goals), *instance.shape), np.bool_)
        for mask, goal in zip(shown, self._goals, strict=True):
            mask |= np.isin(instance, instances_of(self._world, goal))
            for room in rooms_of(self._world, goal):
                mask |= (depth > 0) & in_room(room, xy).reshape(depth.shape)
        return shown
