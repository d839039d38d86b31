"""A snapshot stays what the map was, whatever the run does meanwhile."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mapping import map_bundle
from mapping.odometry.features import Features
from tests.conftest import MeanColours
from tests.helpers.box_room import T_BASE_CAM, render
from tests.helpers.bundles import assert_same
from vizbot.config import PerceptionConfig
from vizbot.core.geometry import planar
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import PoseEstimate, Tracking
from vizbot.perception.interfaces import PerceptionParts
from vizbot.perception.perception import Perception

FRAME = render(planar(0.0, 0.0, 0.0), 0.0)


class ScriptedSlam:
    """Every second frame is a keyframe; all keyframes move when somebody says so."""

    def __init__(self, rng):
        self._rng, self._frames, self.closures = rng, 0, []
        self._poses, self._features = {}, {}

    def track(self, frame, T_odom_base):
        is_keyframe = self._frames % 2 == 0
        keyframe = self._frames // 2
        if is_keyframe:
            self._poses[keyframe] = planar(*self._rng.normal(size=3)) @ T_BASE_CAM
            count = int(self._rng.integers(0, 4))
            self._features[keyframe] = Features(
                self._rng.uniform(0, 300, (count, 2)),
                self._rng.integers(0, 2**60, (count, 4)).astype(np.uint64),
                self._rng.normal(size=(count, 3)),
            )
        T_keyframe_cam = np.eye(4) if is_keyframe else planar(*self._rng.normal(size=3))
        self._frames += 1
        T_map_cam = self._poses[keyframe] @ T_keyframe_cam
        return PoseEstimate(
            frame.stamp, T_map_cam, keyframe, T_keyframe_cam, is_keyframe, Tracking.TRACKING
        )

    def move(self):
        self._poses = {i: planar(*self._rng.normal(size=3)) @ T for i, T in self._poses.items()}

    def keyframe_poses(self):
        return dict(self._poses)

    def features(self):
        return dict(self._features)


@settings(max_examples=8, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.sampled_from(["frame", "frame", "move", "snapshot"]), min_size=4, max_size=14),
)
def test_a_snapshot_is_whole_and_stays_so_while_keyframes_move(seed, events):
    slam, encoder = ScriptedSlam(np.random.default_rng(seed)), MeanColours()
    config = PerceptionConfig(embedding_latency=0.0)
    parts = PerceptionParts(slam=slam)
    perception = Perception(FRAME, T_BASE_CAM, encoder, SimulatedClock(), config, parts)
    taken, stamp = [], 0.0
    for event in ["frame", *events, "snapshot", "frame", "move", "frame"]:
        if event == "frame":
            stamp += 0.2
            frame = replace(FRAME, stamp=stamp)
            perception.embed(frame, perception.update(frame, None))
        elif event == "move":
            slam.move()
        else:
            snapshot = perception.snapshot()
            taken.append((snapshot, snapshot.bundle()))
    perception.finish()
    with ThreadPoolExecutor(1) as beside:
        joined = list(beside.map(lambda snapshot: snapshot[0].bundle(), taken))
    for late, (_, at_once) in zip(joined, taken, strict=True):
        assert_same(late, at_once)
    with TemporaryDirectory() as folder:
        map_bundle.save(joined[-1], Path(folder) / "map")
        assert_same(map_bundle.load(Path(folder) / "map"), joined[-1])
