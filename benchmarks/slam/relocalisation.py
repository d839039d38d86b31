"""Random starts in a saved map of a simulated home: does the robot find out where it is?"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.episodes.calibration_error import CalibrationError
from benchmarks.episodes.episode import Episode
from benchmarks.episodes.homes import open_benchmark_home
from benchmarks.harness.tables import markdown_table
from mapping.keyframes.anchors import Keyframes, KeyframeViews
from mapping.relocalisation.local_map import LocalMap
from mapping.slam.slam import Slam
from sim_stubs.homes.geometry.occupancy_slice import reachable
from vizbot.config import Config
from vizbot.core.geometry import invert, rotation_angle, transform
from vizbot.core.types import SE3, OccupancyGrid, Tracking, Twist
from vizbot.rehearsal.config import RehearsalConfig
from vizbot.rehearsal.rig import Rig

STARTS = 10
"""Number of starts in each home."""
_RIGHT = 0.3
"""Largest error of a right pose [m, rad]."""
_TURN = 2 * np.pi
"""Angle that the robot turns before it gives up [rad]."""


@dataclass(frozen=True, slots=True)
class StartResult:
    """The result of one start.

    Attributes:
        home: Seed of the home.
        number: Number of the start in it.
        recognised: Whether the robot was relocalised.
        error: Error of its position [m]; None where it was not relocalised.
        turn: Error of its heading [degrees]; None where it was not relocalised.
        frames: Frames until it was relocalised or gave up.
        ms_worst: Longest processor time of one of those frames [ms].
    """

    home: int
    number: int
    recognised: bool
    error: float | None
    turn: float | None
    frames: int
    ms_worst: float

    @property
    def right(self) -> bool:
        """Whether the robot was relocalised in the right place."""
        return (
            self.error is not None
            and self.turn is not None
            and max(self.error, np.radians(self.turn)) <= _RIGHT
        )


def random_starts(
    home: int, saved: Slam, grid: OccupancyGrid, T_world_map: SE3, config: Config
) -> list[StartResult]:
    """Place the robot at random poses and let it turn until it is relocalised.

    It stands on floor that the map holds, because it cannot be relocalised elsewhere.

    Args:
        home: Seed of the home.
        saved: The pose estimator with the keyframes of the saved map.
        grid: The obstacle map of the saved map.
        T_world_map: True transform of the saved map, for scoring alone.
        config: Settings of the robot.
    """
    ids = sorted(saved.keyframe_poses())
    poses = np.array([saved.keyframe_poses()[i] for i in ids])
    keyframes, views = (
        Keyframes(np.array(ids, np.int32), np.zeros(len(ids)), poses),
        KeyframeViews.with_features(saved.features()),
    )
    mount, settings = config.mount.T_base_cam, config.perception
    results = []
    error = CalibrationError.drawn(Episode(home, ()))
    with (
        open_benchmark_home(home, config, error) as world,
        Rig(config, "sim", "sim", world) as rig,
    ):
        camera, base = rig.devices.camera, rig.devices.base
        assert base is not None
        free, plan = world.free
        entrance = plan.cell_of(*world.T_world_base[:2, 3])
        assert entrance is not None
        places = plan.pixels_to_xy(
            np.argwhere(reachable(free, entrance))[:, ::-1].astype(np.float64)
        )
        in_map = transform(invert(T_world_map), np.pad(places, ((0, 0), (0, 1))))[:, :2]
        places = places[_is_floor(grid, in_map)]
        for number in range(STARTS):
            rng = np.random.default_rng((home, 5, number))
            x, y = places[rng.integers(len(places))].tolist()
            world.place(x, y, float(rng.uniform(-np.pi, np.pi)))
            around = LocalMap(lambda: grid, settings.depth_mapper, settings.local_map)
            slam = Slam(world.reported_intrinsics, mount, settings.slam, around)
            slam.start_in_map(keyframes, views)
            rate = config.objectnav.recognising_rate
            limit = int(_TURN / rate * RehearsalConfig.read(config).sim_camera.rate)
            found, times = None, list[float]()
            while found is None and len(times) < limit:
                frame = camera.read()
                assert frame is not None
                T_odom_base = base.read().T_odom_base
                began = time.process_time()
                estimate = slam.track(frame, T_odom_base)
                times.append(1000.0 * (time.process_time() - began))
                if estimate.tracking is Tracking.RELOCALISED:
                    T_world_cam = world.T_world_base @ world.T_base_cam
                    found = invert(T_world_cam) @ T_world_map @ estimate.T_map_cam
                base.drive(Twist(0.0, rate))
            results.append(
                StartResult(
                    home,
                    number,
                    found is not None,
                    None if found is None else round(float(np.linalg.norm(found[:3, 3])), 3),
                    None if found is None else round(float(np.degrees(rotation_angle(found))), 2),
                    len(times),
                    round(max(times), 1),
                )
            )
    return results


def _is_floor(grid: OccupancyGrid, xy: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points (N, 2) in `map` [m] are free in the map (N,)."""
    cells = grid.to_cells(xy)
    inside = grid.contains(cells)
    floor = np.zeros(len(xy), np.bool_)
    floor[inside] = grid.occupancy[tuple(cells[inside].T)] < 0.4
    return floor


def starts_table(results: Sequence[StartResult]) -> str:
    """A table of the recognised starts and the frames that they took."""
    recognised = [result for result in results if result.recognised]
    right = sum(result.right for result in results)
    frames = [result.frames for result in recognised] or [0]
    header = ("random starts in a saved map", "right place", "wrong place", "not recognised",
              "frames until then, median", "most", "slowest frame [ms]")  # fmt: skip
    row = [
        len(results),
        right,
        len(recognised) - right,
        len(results) - len(recognised),
        f"{np.median(frames):.0f}",
        max(frames),
        f"{max(result.ms_worst for result in results):.0f}",
    ]
    return markdown_table(header, [row])
