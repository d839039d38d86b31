"""Where the frames of a recording were taken."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.episodes.oracles import TruePose
from benchmarks.slam.peers import VizbotEstimator
from drivers.tum_sequence import RecordedSequence
from mapping.calibration.floor_level import estimate_mount
from mapping.keyframes.config import KeyframeConfig
from mapping.slam.config import SlamConfig
from mapping.trajectory_error import MAX_GAP
from mapping.tum import read_trajectory
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import camera_mount, invert

log = logging.getLogger(__name__)

TRUTH = "groundtruth.txt"
"""File of the poses that were recorded with the images."""
BY_SLAM = ("our own SLAM", f"record poses, in {TRUTH}, to do without it")
"""Who makes poses where none were recorded, and what helps where it cannot."""
_LONGEST = 0.1
"""Longest time between two poses that are interpolated [s]. In the middle of it the camera of TUM's
fr1/rpy, which a hand turns by 6 degrees meanwhile, is off by 0.4 degrees at the median."""


def poses_at(
    wanted: NDArray[np.float64], stamps: NDArray[np.float64], Ts_world_cam: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Poses (F, 4, 4) at times (F,) between poses (N, 4, 4) at sorted stamps (N,) [s].

    Positions are interpolated linearly, rotations along the shortest arc. There is a pose where its
    neighbours are at most 0.1 s apart, or one is at most `MAX_GAP` away; elsewhere there is NaN.
    """
    poses = np.full((len(wanted), 4, 4), np.nan)
    if len(stamps) == 0:
        return poses
    after = np.searchsorted(stamps, wanted).clip(max=len(stamps) - 1)
    before = np.where(stamps[after] > wanted, after - 1, after).clip(min=0)
    apart = stamps[after] - stamps[before]
    off = np.minimum(np.abs(wanted - stamps[before]), np.abs(wanted - stamps[after]))
    known = (off <= MAX_GAP) | ((apart > 0) & (apart <= _LONGEST))
    share = ((wanted - stamps[before]) / np.where(apart > 0, apart, np.inf))[known, None]
    start, end = Ts_world_cam[before[known]], Ts_world_cam[after[known]]
    turned = Rotation.from_matrix(start[:, :3, :3].transpose(0, 2, 1) @ end[:, :3, :3]).as_rotvec()
    moved = end[:, :3, 3] - start[:, :3, 3]
    start[:, :3, :3] = start[:, :3, :3] @ Rotation.from_rotvec(share * turned).as_matrix()
    start[:, :3, 3] += share * moved
    poses[known] = start
    return poses


def recorded_poses(camera: RecordedSequence, folder: Path) -> NDArray[np.float64] | None:
    """True poses (F, 4, 4) of all frames, NaN where one has none; None where none were recorded.

    Raises:
        ConfigError: the file of poses cannot be read, or tells of less than half of the frames.
    """
    truth, stamps = folder / TRUTH, camera.stamps
    if not truth.is_file():
        return None
    true_stamps, Ts_world_cam = read_trajectory(truth)
    poses = poses_at(stamps, true_stamps, Ts_world_cam)
    spans = [f"{each.min():.3f} to {each.max():.3f} s" if len(each) else "no time"
             for each in (true_stamps, stamps)]  # fmt: skip
    require_most(
        ~np.isnan(poses[:, 0, 0]),
        f"{truth}, of {spans[0]},",
        f"the frames are of {spans[1]}: write both by one clock, with poses at most {_LONGEST} s"
        " apart, or take the file away to have poses estimated",
    )
    return poses


def estimated_poses(camera: RecordedSequence, config: SlamConfig) -> NDArray[np.float64]:
    """Poses (F, 4, 4) of all frames by our own SLAM, in its map; NaN where it is lost.

    Raises:
        ConfigError: it is lost in more than half of the frames.
    """
    estimator = VizbotEstimator(camera.frame(0), config)
    known = np.array([estimator.track(camera.frame(i))[1] for i in range(len(camera))])
    require_most(known, *BY_SLAM)
    return np.where(known[:, None, None], estimator.finish(), np.nan)


def require_most(known: NDArray[np.bool_], source: str, remedy: str) -> None:
    """Say in one line how many frames (F,) are left out because no pose of them is known.

    Raises:
        ConfigError: they are more than half of the frames.
    """
    missing = f"{source} has no pose of {np.sum(~known)} of {len(known)} frames"
    if 2 * np.sum(~known) > len(known):
        raise ConfigError(f"{missing}; {remedy}")
    if not known.all():
        log.warning("%s: they are left out", missing)


def told_poses(
    camera: RecordedSequence, Ts_world_cam: NDArray[np.float64], config: KeyframeConfig
) -> TruePose:
    """A pose estimator that is told these poses (F, 4, 4), and lost where they are NaN.

    Its `map` is, as that of `Slam`, where the base stands at the first frame, or at the first one
    with a pose.
    """
    known = ~np.isnan(Ts_world_cam[:, 0, 0])
    last = np.maximum.accumulate(np.where(known, np.arange(len(known)), np.argmax(known)))
    mount = estimate_mount(camera.frame(int(last[0])))
    T_base_cam = camera_mount(1.5, 0.0, 0.0) if mount is None else mount
    Ts_map_cam = T_base_cam @ invert(Ts_world_cam[last[0]]) @ Ts_world_cam[last]
    number = {stamp: i for i, stamp in enumerate(camera.stamps.tolist())}
    return TruePose(lambda stamp: (Ts_map_cam[number[stamp]], bool(known[number[stamp]])), config)
