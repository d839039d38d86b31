import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapping.clip.growing_rows import GrowingTable
from mapping.clip.mapped_frames import MappedFrame, MappedFrames
from mapping.clip.mapper import ClipMap, FrameElements
from mapping.clip.placement import Placement
from mapping.keyframes.anchors import points_in_map, poses_in_map
from vizbot.core.geometry import planar
from vizbot.core.types import PoseEstimate, Tracking


def frame_elements(rng, count, width=112):
    box = np.array([0, 0, width, width], np.int32)
    return FrameElements(
        rng.normal(size=(count, 3)),
        np.eye(count, 4, dtype=np.float32),
        box + np.zeros((count, 1), np.int32),
    )


def estimate(rng, keyframe):
    T = planar(*rng.normal(size=3))
    return PoseEstimate(0.0, T, keyframe, T, False, Tracking.TRACKING)


def frames_of(estimates):
    """All of them as the frames of a map."""
    table = GrowingTable(MappedFrames.empty())
    for number, each in enumerate(estimates):
        table.add(MappedFrame(number, each.keyframe, each.T_keyframe_cam, 0.0).row())
    return table.rows


def expected(elements, estimates, poses):
    """Everything computed at once, as in the map of one call."""
    frames, frame_of = np.unique(elements.frames, return_inverse=True)
    cameras = poses_in_map(
        np.array([estimates[frame].T_keyframe_cam for frame in frames]).reshape(-1, 4, 4),
        np.array([estimates[frame].keyframe for frame in frames], np.int32),
        poses,
    )
    return (
        points_in_map(elements.points_keyframe, elements.keyframes, poses),
        cameras[frame_of, :2, 3],
    )


@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.sampled_from(["frame", "move one", "move all"]), max_size=30),
)
def test_elements_are_where_a_whole_computation_puts_them(seed, events):
    rng = np.random.default_rng(seed)
    clip_map, placement, estimates = ClipMap(4), Placement(), []
    poses = {keyframe: planar(*rng.normal(size=3)) for keyframe in range(4)}
    for event in events:
        if event == "frame":
            keyframe, count = int(rng.integers(4)), int(rng.integers(0, 5))
            estimates.append(estimate(rng, keyframe))
            elements = frame_elements(rng, count, int(rng.choice([56, 112, 224])))
            clip_map.add(
                MappedFrame(len(estimates) - 1, keyframe, estimates[-1].T_keyframe_cam, 0.0),
                elements,
            )
        else:
            moving = range(4) if event == "move all" else [int(rng.integers(4))]
            poses = poses | {keyframe: planar(*rng.normal(size=3)) for keyframe in moving}
        placed = placement.place(clip_map.elements, frames_of(estimates), poses)
        for now, whole in zip(
            (placed.points, placed.seen_from),
            expected(clip_map.elements, estimates, poses),
            strict=True,
        ):
            np.testing.assert_array_equal(now, whole)


def test_arrays_that_were_given_out_do_not_change():
    rng = np.random.default_rng(0)
    clip_map, placement, estimates = ClipMap(4), Placement(), [estimate(rng, 0), estimate(rng, 1)]
    clip_map.add(MappedFrame(0, 0, estimates[0].T_keyframe_cam, 0.0), frame_elements(rng, 3))
    poses = {0: np.eye(4), 1: np.eye(4)}
    early = placement.place(clip_map.elements, frames_of(estimates), poses)
    kept = early.points.copy(), early.seen_from.copy()
    clip_map.add(MappedFrame(1, 1, estimates[1].T_keyframe_cam, 0.0), frame_elements(rng, 4, 224))
    placement.place(clip_map.elements, frames_of(estimates), poses | {0: planar(1.0, 2.0, 0.5)})
    for now, before in zip((early.points, early.seen_from), kept, strict=True):
        np.testing.assert_array_equal(now, before)


def test_only_what_is_new_or_moved_is_computed(monkeypatch):
    rng = np.random.default_rng(0)
    clip_map, placement, estimates = ClipMap(4), Placement(), []
    for frame in range(20):
        estimates.append(estimate(rng, frame // 5))
        clip_map.add(
            MappedFrame(frame, frame // 5, estimates[-1].T_keyframe_cam, 0.0),
            frame_elements(rng, 10),
        )
    poses = {keyframe: np.eye(4) for keyframe in range(4)}
    computed = []

    def counting(points, *others):
        computed.append(len(points))
        return points_in_map(points, *others)

    monkeypatch.setattr("mapping.clip.placement.points_in_map", counting)
    for now in (poses, {k: T.copy() for k, T in poses.items()}, poses | {2: planar(1.0, 0.0, 0.0)}):
        placement.place(clip_map.elements, frames_of(estimates), now)
    estimates.append(estimate(rng, 3))
    clip_map.add(MappedFrame(20, 3, estimates[-1].T_keyframe_cam, 0.0), frame_elements(rng, 7))
    placement.place(clip_map.elements, frames_of(estimates), now)
    assert computed == [200, 50, 7]


def test_an_element_whose_keyframe_has_no_pose_is_an_error():
    rng = np.random.default_rng(0)
    clip_map, estimates = ClipMap(4), [estimate(rng, 5)]
    clip_map.add(MappedFrame(0, 5, estimates[0].T_keyframe_cam, 0.0), frame_elements(rng, 2))
    with pytest.raises(KeyError):
        Placement().place(clip_map.elements, frames_of(estimates), {4: np.eye(4)})
