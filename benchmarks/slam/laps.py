"""Laps through all rooms of a simulated home, recorded once and replayed as often as needed.

The robot is driven by its true pose. Its devices are those of a dry run: camera, gyroscope and
wheels, with all their noise. A recording is a folder in TUM layout, which any program can read,
with `odometry.txt`, `gyroscope.txt` and `accelerometer.txt` beside the images. What a calibration
leaves is drawn for each home: mount, intrinsics and wheels are not quite what the robot believes.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from benchmarks.episodes.calibration_error import CalibrationError
from benchmarks.episodes.episode import Episode
from benchmarks.episodes.homes import open_benchmark_home
from benchmarks.slam.replays import SENSORS, ReplayFrame
from mapping.tum import write_trajectory
from nav.astar import plan
from nav.config import CostmapConfig, FollowerConfig
from nav.costmap import Costmap, build_costmap
from nav.follower import follow_path
from sim_stubs.world.world import World
from vizbot.config import Config
from vizbot.core.errors import VizbotError
from vizbot.core.files import write_whole
from vizbot.core.interfaces import Devices
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3, STOP, OccupancyGrid
from vizbot.rehearsal.config import RehearsalConfig
from vizbot.rehearsal.rig import Rig

_JPEG_QUALITY = 95
_DEPTH_SCALE = 1000
_ARRIVED = 0.1
_PATIENCE = 120.0
"""Longest time of the path to one room [s]."""
_FREE_CELLS = CostmapConfig(robot_radius=0.1, margin=0.02, map_tolerance=0.09)
"""Cells of the true map are free for the robot's centre, so that little distance is needed."""


class LapConfig(BaseModel):
    """Settings of the recording of a home."""

    model_config = SETTINGS

    laps: int = Field(default=3, gt=0)
    """Number of laps from the entrance through the rooms and back."""
    rooms: int | None = None
    """Number of the nearest rooms to drive to; None for all rooms."""
    rate: float = Field(default=5.0, gt=0.0)
    """Frame rate [1/s]."""
    standing: float = Field(default=3.0, ge=0.0)
    """Time that the robot stands at the start, for the gyroscope's bias [s]."""
    follower: FollowerConfig = FollowerConfig()
    """Speeds of the robot."""


def record_laps(
    seed: int, folder: Path, config: Config, laps: LapConfig, error: CalibrationError | None = None
) -> None:
    """Record a home, unless `folder` holds it already.

    Args:
        seed: Seed of the home.
        folder: Of the recording.
        config: Settings of the robot.
        laps: What is driven.
        error: How the true robot differs from the settings; None for what is drawn for the home.

    Raises:
        VizbotError: the robot does not get through the home.
    """
    lists = folder / "associations.txt"
    if lists.exists():  # it is written last
        return
    for kind in ("rgb", "depth"):
        (folder / kind).mkdir(parents=True, exist_ok=True)
    rehearsal = RehearsalConfig.read(config)
    camera = rehearsal.sim_camera.model_copy(update={"rate": laps.rate})
    config = rehearsal.model_copy(update={"sim_camera": camera}).within(config)
    error = error or CalibrationError.drawn(Episode(seed, ()))
    with (
        open_benchmark_home(seed, config, error) as world,
        Rig(config, "sim", "sim", world) as rig,
    ):
        recording = _RecordingWriter(folder)
        for frame in _drive_laps(world, rig.devices, laps):
            recording.add(frame)
        reported = world.reported_intrinsics
        recording.finish()
    calibration = asdict(reported) | {"depth_scale": _DEPTH_SCALE}
    write_whole(folder / "camera.json", json.dumps(calibration).encode())
    write_whole(lists, recording.associations().encode())


class _RecordingWriter:
    """Writes frames to a folder as they come."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._stamps: list[float] = []
        self._Ts_odom_base: list[SE3] = []
        self._Ts_world_cam: list[SE3] = []
        self._samples: dict[str, list[NDArray[np.float64]]] = {kind: [] for kind in SENSORS}

    def add(self, replayed: ReplayFrame) -> None:
        frame, number = replayed.frame, len(self._stamps)
        bgr = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2BGR)
        depth = np.rint(frame.depth * _DEPTH_SCALE).astype(np.uint16)
        rgb_file, depth_file = self._files(number)
        cv2.imwrite(str(self._folder / rgb_file), bgr, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
        cv2.imwrite(str(self._folder / depth_file), depth, [cv2.IMWRITE_PNG_COMPRESSION, 1])
        self._stamps.append(round(frame.stamp, 6))
        self._Ts_odom_base.append(replayed.T_odom_base)
        self._Ts_world_cam.append(replayed.T_world_cam)
        imu = frame.imu
        for kind, stamps, values in zip(
            SENSORS, (imu.gyro_stamps, imu.accel_stamps), (imu.gyro, imu.accel), strict=True
        ):
            self._samples[kind].append(np.column_stack((stamps, values)))

    def finish(self) -> None:
        stamps = np.array(self._stamps)
        write_trajectory(self._folder / "odometry.txt", stamps, np.array(self._Ts_odom_base))
        write_trajectory(self._folder / "groundtruth.txt", stamps, np.array(self._Ts_world_cam))
        for kind, parts in self._samples.items():
            np.savetxt(self._folder / f"{kind}.txt", np.concatenate(parts), "%.6f")

    def associations(self) -> str:
        """The text of `associations.txt`."""
        rows = ((f"{stamp:.6f}", *self._files(number)) for number, stamp in enumerate(self._stamps))
        return "".join(f"{stamp} {rgb} {stamp} {depth}\n" for stamp, rgb, depth in rows)

    def _files(self, number: int) -> tuple[str, str]:
        return f"rgb/{number:06d}.jpg", f"depth/{number:06d}.png"


def _drive_laps(world: World, devices: Devices, config: LapConfig) -> Iterator[ReplayFrame]:
    """Drive all laps and yield each frame."""
    assert devices.base is not None
    costmap = _true_costmap(world)
    home = world.T_world_base[:2, 3]
    tour = _tour(world, costmap, home)[: config.rooms]
    ends = [*tour, home] * config.laps
    began = devices.clock.now()
    set_out = began + config.standing
    while True:
        frame = devices.camera.read()
        assert frame is not None
        state = devices.base.read()
        yield ReplayFrame(frame, state.T_odom_base, world.T_world_base @ world.T_base_cam)
        now, position = devices.clock.now(), world.T_world_base[:2, 3]
        if now < began + config.standing:
            devices.base.drive(STOP)
            continue
        if np.linalg.norm(ends[0] - position) < _ARRIVED:
            ends, set_out = ends[1:], now
            if not ends:
                return
        path = plan(costmap, position, ends[0][None])
        if path is None or now - set_out > _PATIENCE:
            raise VizbotError(
                f"home {world.seed}: the lap does not get from {position.round(2)} to"
                f" {ends[0].round(2)}, which is a bug; report it"
            )
        devices.base.drive(follow_path(path.xy, world.T_world_base, config.follower))


def _true_costmap(world: World) -> Costmap:
    free, plan_grid = world.free
    occupancy = np.where(free, np.float32(0), np.float32(1))
    return build_costmap(
        OccupancyGrid(occupancy, plan_grid.resolution, plan_grid.origin), _FREE_CELLS
    )


def _tour(world: World, costmap: Costmap, home: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """The roomiest place of each room; each next place is the nearest one that is left."""
    cells = np.argwhere(np.isfinite(costmap.cost))
    places = costmap.grid.to_xy(cells)
    clearance = costmap.clearance[tuple(cells.T)]
    left = []
    for room in world.house.rooms:
        polygon = room.polygon.astype(np.float32)
        inside = np.array([cv2.pointPolygonTest(polygon, (x, y), False) > 0 for x, y in places])
        if inside.any():
            left.append(places[inside][clearance[inside].argmax()])
    tour, position = [], home
    while left:
        path = plan(costmap, position, np.array(left))
        if path is None:
            break
        position = left.pop(path.goal)
        tour.append(position)
    return tour
