"""Maps, and calibrations of encoders, made up to be saved."""

import os
from dataclasses import fields

import numpy as np
from scipy.spatial.transform import Rotation

from mapping import map_bundle
from mapping.clip.fitted.calibration import (
    LIST_OF_VIEWS,
    EncoderCalibration,
    ReliabilityBin,
    encoder_hash,
)
from mapping.clip.growing_rows import GrowingTable
from mapping.clip.mapped_frames import MappedFrame, MappedFrames
from mapping.clip.mapper import ClipMap, FrameElements
from mapping.clip.places.evidence import fitted_weights
from mapping.clip.places.place_rows import PlaceRows
from mapping.keyframes.anchors import Keyframes, KeyframeViews
from mapping.map_bundle import MapBundle, save
from tests.helpers.failing import raising
from vizbot.core.geometry import planar
from vizbot.core.types import Intrinsics, OccupancyGrid, PoseEstimate, Tracking
from vizbot.perception.run_record import RunRecord

GROUPS = ("keyframes", "views", "elements", "places", "frames", "cloud", "trajectory")


class Encoder:
    dimension = 4
    threshold = 0.3
    log_odds = None
    notice = None

    def __init__(self, model_id):
        self.model_id = model_id


class Snapshot:
    """Of a map that does not change."""

    def __init__(self, bundle):
        self._bundle = bundle
        self.keyframe_poses, self.features = bundle.keyframes.poses(), {}

    def __getattr__(self, name):
        return getattr(self._bundle, name)

    def bundle(self):
        return self._bundle


LOOKS_ALONG_X = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


def camera(x, y, yaw=0.0):
    """T_map_cam of a level camera."""
    return planar(x, y, yaw) @ LOOKS_ALONG_X


def random_pose(rng):
    T = np.eye(4)
    T[:3, :3] = Rotation.random(rng=rng).as_matrix()
    T[:3, 3] = rng.uniform(-5, 5, 3)
    return T


def bundle_of(seed=0, frames=6, model_id="embedded"):
    """A run whose every third frame is a keyframe, and whose graph moved after it."""
    rng = np.random.default_rng(seed)
    estimates, clip_map, record = [], ClipMap(4), RunRecord()
    mapped_frames = GrowingTable(MappedFrames.empty())
    for frame in range(frames):
        keyframe, is_keyframe = frame // 3 * 2, frame % 3 == 0
        T_keyframe_cam = np.eye(4) if is_keyframe else random_pose(rng)
        estimates.append(
            PoseEstimate(
                0.1 * frame,
                random_pose(rng),
                keyframe,
                T_keyframe_cam,
                is_keyframe,
                Tracking.TRACKING,
            )
        )
        count = int(rng.integers(0, 5))
        embeddings, corners = rng.normal(size=(count, 4)), rng.integers(0, 320, (count, 4))
        elements = FrameElements(
            rng.normal(size=(count, 3)),
            (embeddings / np.linalg.norm(embeddings, axis=1, keepdims=True)).astype(np.float32),
            (corners + np.array([0, 0, 320, 320])).astype(np.int32),
        )
        mapped = MappedFrame(frame, keyframe, T_keyframe_cam, 1.7e9 + frame)
        mapped_frames.add(mapped.row())
        clip_map.add(mapped, elements)
        if is_keyframe:
            points = rng.normal(size=(7, 3)).astype(np.float32)
            record.add_points(keyframe, np.eye(4), points, rng.integers(0, 256, (7, 3), np.uint8))
    for estimate in estimates:
        record.add(estimate)
    poses = {e.keyframe: random_pose(rng) for e in estimates}
    drawn = np.random.default_rng([seed, frames])
    count = len(clip_map)
    return MapBundle(
        model_id=model_id,
        intrinsics=Intrinsics(640, 480, 600.5, 601.25, 320.0, 239.5),
        T_base_cam=random_pose(rng),
        keyframes=Keyframes.with_poses(poses, record.keyframe_stamps),
        views=KeyframeViews(
            rng.uniform(0, 640, (2 * len(poses), 2)).astype(np.float32),
            rng.integers(0, 2**63, (2 * len(poses), 4)).astype(np.uint64),
            rng.normal(size=(2 * len(poses), 3)).astype(np.float32),
            np.repeat(sorted(poses), 2).astype(np.int32),
        ),
        elements=clip_map.elements,
        statistics=drawn.uniform(0.01, 0.5, (count, 2)).astype(np.float32),
        places=random_places(drawn, sorted(poses), count, frames),
        frames=mapped_frames.rows,
        grid=OccupancyGrid(
            rng.uniform(0, 1, (9, 13)).astype(np.float32).T, 0.05, np.array([-1.25, 0.3])
        ),
        cloud=record.cloud,
        trajectory=record.trajectory,
        pictures=unit_rows(drawn, 3),
        keep_out=tuple(rng.uniform(-9, 9, (k, 2)).astype(np.float32) for k in (3, 5)),
    )


def unit_rows(rng, count):
    """Embeddings as long as those of the elements."""
    drawn = rng.normal(size=(count, 4))
    return (drawn / np.linalg.norm(drawn, axis=1, keepdims=True)).astype(np.float32)


def random_places(rng, keyframes, elements, frames):
    """Two views of places of each element."""
    count = 2 * elements
    return PlaceRows(
        rng.normal(size=(count, 3)).astype(np.float32),
        rng.choice(keyframes, count).astype(np.int32) if count else np.zeros(0, np.int32),
        rng.integers(0, max(elements, 1), (count, 3)).astype(np.int32),
        rng.uniform(0, 6, count).astype(np.float32),
        rng.uniform(0, 1, count).astype(np.float32),
        rng.integers(0, 9, count).astype(np.int32),
        np.sort(rng.integers(0, max(frames, 1), count)).astype(np.int32),
    )


def assert_same(a, b):
    assert (a.model_id, a.intrinsics, a.created) == (b.model_id, b.intrinsics, b.created)
    assert a.notice == b.notice
    for zone, other in zip(a.keep_out, b.keep_out, strict=True):
        assert zone.dtype == other.dtype
        np.testing.assert_array_equal(zone, other)
    np.testing.assert_array_equal(a.T_base_cam, b.T_base_cam)
    np.testing.assert_array_equal(a.grid.occupancy, b.grid.occupancy)
    np.testing.assert_array_equal(a.grid.origin, b.grid.origin)
    assert a.grid.resolution == b.grid.resolution
    if b.statistics is None:
        assert a.statistics is None
    else:
        np.testing.assert_array_equal(a.statistics, b.statistics)
    np.testing.assert_array_equal(a.pictures, b.pictures)
    for group in GROUPS:
        for column in fields(getattr(a, group)):
            x = getattr(getattr(a, group), column.name)
            y = getattr(getattr(b, group), column.name)
            assert x.dtype == y.dtype
            np.testing.assert_array_equal(x, y)


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def make_file(path):
    path.write_text("a letter")


def make_folder_with_a_letter(path):
    path.mkdir()
    (path / "letter.txt").write_text("a letter")


def make_map_with_a_letter(path):
    save(bundle_of(), path)
    (path / "letter.txt").write_text("a letter")


def make_foreign_map(path):
    path.mkdir()
    (path / "map.json").write_text('{"tiles": []}')


def a_full_disk(monkeypatch):
    monkeypatch.setattr(map_bundle, "write_header", raising(OSError(28, os.strerror(28))))


def too_large_a_map(monkeypatch):
    monkeypatch.setattr(map_bundle, "MOST_BYTES", 1000)


def a_map_with_a_fault_of_ours(monkeypatch):
    monkeypatch.setattr(map_bundle, "_packed", raising(IndexError("index 7 is out of bounds")))


def too_little_memory(monkeypatch):
    monkeypatch.setattr(map_bundle, "_packed", raising(MemoryError()))


NO_MAP = {
    a_full_disk: "No space left on device; give another folder",
    too_large_a_map: "more than 1000: begin a new map",
    a_map_with_a_fault_of_ours: "index 7 is out of bounds",
    too_little_memory: "MemoryError",
}
"""What keeps a map from being saved: each cause as a patch, with words of what is said of it."""


def calibration_for(encoder, **changes):
    """One for an encoder, with the weights that come along but for the last of `join`."""
    weights = fitted_weights()
    content = {
        "model_id": encoder.model_id,
        "encoder_hash": encoder_hash(encoder),
        "views": LIST_OF_VIEWS,
        "homes": ("916", "Studio"),
        "phrasings": ("{}",),
        "scale": 50.0,
        "bias": -45.0,
        "threshold": 0.9,
        "near": tuple(weights.near.tolist()),
        "far": tuple(weights.far.tolist()),
        "join": (*weights.join[:-1].tolist(), -1.0),
        "reliability": (ReliabilityBin(believed=0.1, true=0.125, places=40),),
        "calibration_error": 0.025,
    }
    return EncoderCalibration.model_validate(content | changes)
