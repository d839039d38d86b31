import logging

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from mapping.clip.config import ClipMapperConfig
from mapping.clip.mapped_frames import MappedFrame
from mapping.clip.mapper import ClipMap, FrameElements
from mapping.clip.patches import ALL_PIXELS, embed_frame, patch_boxes, patch_points
from tests.helpers.bundles import random_pose
from vizbot.core.geometry import back_project, transform
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame


class MeanColour:
    """Embeds an image as its mean colour, and counts how often it is asked."""

    model_id = "mean colour"
    dimension = 3
    threshold = 0.9
    notice = None

    def __init__(self):
        self.batches = []

    def embed_images(self, images):
        self.batches.append([image.shape[0] for image in images])
        means = [image.reshape(-1, 3).mean(axis=0) for image in images]
        means = np.array(means, np.float32).reshape(-1, 3)
        return means / np.linalg.norm(means, axis=1, keepdims=True)

    def embed_texts(self, texts):
        raise NotImplementedError


def intrinsics_of(width, height):
    return Intrinsics(width, height, 500.0, 510.0, width / 2 - 3.5, height / 2 + 2.0)


def frame_of(depth, rgb=None):
    height, width = depth.shape
    if rgb is None:
        rgb = np.random.default_rng(0).integers(1, 255, (height, width, 3), np.uint8)
    return RGBDFrame(0.0, rgb, depth, intrinsics_of(width, height), ImuSamples.none())


def random_elements(count, dimension=4, seed=0):
    rng = np.random.default_rng(seed)
    embeddings = rng.normal(size=(count, dimension)).astype(np.float32)
    boxes = rng.integers(0, 99, (count, 4), np.int32)
    return FrameElements(rng.uniform(-3, 3, (count, 3)), embeddings, boxes)


def test_a_vga_frame_has_the_papers_twenty_five_patches():
    boxes = patch_boxes(640, 480, ClipMapperConfig())
    sizes = boxes[:, 2] - boxes[:, 0]
    assert [(sizes == size).sum() for size in (448, 224, 112)] == [1, 4, 20]
    assert boxes[0].tolist() == [96, 16, 544, 464]
    assert boxes[5].tolist() == [40, 16, 152, 128]


def test_a_frame_too_small_for_a_scale_has_none_there_which_is_said_once(caplog):
    config = ClipMapperConfig(min_depth_share=0.123)  # a configuration no other test has used
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            boxes = patch_boxes(540, 360, config)
    sizes = boxes[:, 2] - boxes[:, 0]
    assert [(sizes == size).sum() for size in (448, 224, 112)] == [0, 2, 12]
    assert len(caplog.records) == 1
    assert "448" in caplog.text


@given(
    width=st.integers(1, 700),
    height=st.integers(1, 700),
    size=st.sampled_from([32, 64, 224]),
    scale=st.integers(-2, 2),
)
def test_the_patches_of_a_scale_tile_a_centred_crop(width, height, size, scale):
    boxes = patch_boxes(width, height, ClipMapperConfig(patch_size=size, scales=(scale,)))
    s = int(size * 2.0**scale)
    assert len(boxes) == (width // s) * (height // s)
    covered = np.zeros((height, width), np.int64)
    for u0, v0, u1, v1 in boxes:
        assert 0 <= u0 < u1 <= width
        assert 0 <= v0 < v1 <= height
        covered[v0:v1, u0:u1] += 1
    assert covered.sum() == len(boxes) * s * s
    assert covered.max(initial=0) <= 1
    if len(boxes):
        left, top = boxes[:, :2].min(axis=0)
        right, bottom = (width, height) - boxes[:, 2:].max(axis=0)
        assert 0 <= right - left <= 1
        assert 0 <= bottom - top <= 1
        assert right + left < s
        assert bottom + top < s


def test_a_scale_that_is_not_whole_pixels_is_refused():
    with pytest.raises(ValidationError, match="whole pixels"):
        ClipMapperConfig(patch_size=225)


@pytest.mark.slow
@given(seed=st.integers(0, 1000), holes=st.floats(0.0, 1.0))
def test_the_papers_element_lies_at_the_mean_of_its_patchs_valid_points(seed, holes):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.3, 8.0, (70, 95)).astype(np.float32)
    depth[rng.random(depth.shape) < holes] = 0.0
    intrinsics = intrinsics_of(95, 70)
    boxes = patch_boxes(95, 70, ClipMapperConfig(patch_size=16))
    depth[rng.random(depth.shape) < 0.01] = 30.0
    points, parts = patch_points(depth, intrinsics, boxes, ALL_PIXELS)
    cloud = back_project(depth, intrinsics).astype(np.float64)
    for (u0, v0, u1, v1), point, part in zip(boxes, points, parts, strict=True):
        valid = (depth[v0:v1, u0:u1] > 0) & (depth[v0:v1, u0:u1] < 30)
        assert part == pytest.approx(valid.mean())
        if valid.any():
            np.testing.assert_allclose(point, cloud[v0:v1, u0:u1][valid].mean(axis=0), atol=1e-5)


@given(
    seed=st.integers(0, 1000),
    false=st.floats(0.0, 0.2),
    lie=st.floats(0.1, 65.5),
    slope=st.floats(-0.4, 0.4),
)
def test_false_depth_of_some_pixels_moves_no_element_off_its_surface(seed, false, lie, slope):
    rng = np.random.default_rng(seed)
    surface = 2.5 + slope * np.linspace(-1, 1, 96, dtype=np.float32) + np.zeros((72, 1), np.float32)
    depth = np.where(rng.random(surface.shape) < false, np.float32(lie), surface)
    intrinsics = intrinsics_of(96, 72)
    boxes = patch_boxes(96, 72, ClipMapperConfig(patch_size=24))
    true, _ = patch_points(surface, intrinsics, boxes)
    found, _ = patch_points(depth, intrinsics, boxes)
    assert np.linalg.norm(found - true, axis=1).max() < 0.15


def test_an_element_of_a_thing_before_a_wall_lies_on_the_thing_that_fills_its_patch():
    depth = np.full((32, 32), 4.0, np.float32)
    depth[:, :20] = 1.5
    points, _ = patch_points(depth, intrinsics_of(32, 32), np.array([[0, 0, 32, 32]], np.int32))
    assert points[0, 2] == pytest.approx(1.5)


def test_a_patch_with_too_little_depth_is_dropped_and_the_rest_is_one_batch():
    depth = np.full((480, 640), 2.0, np.float32)
    depth[:, 264:] = 0.0  # leaves the left two columns of small patches, and parts of others
    frame, encoder = frame_of(depth), MeanColour()
    elements = embed_frame(frame, encoder, ClipMapperConfig(min_depth_share=0.3))
    boxes = elements.boxes
    valid = np.array([(depth[v0:v1, u0:u1] > 0).mean() for u0, v0, u1, v1 in boxes])
    assert (valid >= 0.3).all()
    assert encoder.batches == [[448] + [224] * 2 + [112] * 8]
    np.testing.assert_allclose(elements.points_cam[:, 2], 2.0)
    u0, v0, u1, v1 = boxes[-1]
    mean = frame.rgb[v0:v1, u0:u1].reshape(-1, 3).mean(axis=0)
    np.testing.assert_allclose(elements.embeddings[-1], mean / np.linalg.norm(mean), atol=1e-5)


def test_a_frame_without_depth_adds_nothing():
    elements = embed_frame(
        frame_of(np.zeros((480, 640), np.float32)), MeanColour(), ClipMapperConfig()
    )
    clip_map = ClipMap(3)
    clip_map.add(MappedFrame(0, 0, np.eye(4), 0.0), elements)
    assert len(clip_map) == 0
    assert clip_map.points_map({}).shape == (0, 3)


@given(seed=st.integers(0, 1000), counts=st.lists(st.integers(0, 30), min_size=1, max_size=6))
def test_elements_follow_their_keyframes_when_the_graph_moves(seed, counts):
    clip_map = ClipMap(4)
    added = []
    for frame, count in enumerate(counts):
        keyframe, T_keyframe_cam = frame // 2 * 7, random_pose(np.random.default_rng(seed + frame))
        elements = random_elements(count, seed=seed + frame)
        clip_map.add(MappedFrame(frame, keyframe, T_keyframe_cam, 0.0), elements)
        added.append((keyframe, T_keyframe_cam, elements.points_cam))
    for moved in (1000, 2000):
        drawn = [np.random.default_rng(seed + moved + keyframe) for keyframe in (0, 7, 14)]
        poses = dict(zip((0, 7, 14), map(random_pose, drawn), strict=True))
        expected = [transform(poses[i] @ T, points) for i, T, points in added]
        np.testing.assert_allclose(clip_map.points_map(poses), np.concatenate(expected), atol=1e-9)


def test_the_map_keeps_every_row_as_it_grows_and_its_views_do_not_change():
    clip_map, frames = ClipMap(4), [random_elements(25, seed=i) for i in range(40)]
    clip_map.add(MappedFrame(0, 3, np.eye(4), 0.0), frames[0])
    early, before = clip_map.elements, frames[0].embeddings.copy()
    for index, elements in enumerate(frames[1:], start=1):
        clip_map.add(MappedFrame(index, 3 + index // 10, np.eye(4), 0.0), elements)
    assert len(clip_map) == 1000
    np.testing.assert_array_equal(early.embeddings, before)
    np.testing.assert_array_equal(
        clip_map.embeddings, np.concatenate([f.embeddings for f in frames])
    )
    np.testing.assert_array_equal(
        clip_map.elements.boxes, np.concatenate([f.boxes for f in frames])
    )
    np.testing.assert_array_equal(clip_map.elements.frames, np.repeat(np.arange(40), 25))
    assert clip_map.keyframes.tolist()[::250] == [3, 4, 5, 6]
    assert clip_map.keyframes.dtype == np.int32


def test_an_element_whose_keyframe_has_no_pose_is_an_error():
    clip_map = ClipMap(4)
    clip_map.add(MappedFrame(0, 5, np.eye(4), 0.0), random_elements(2))
    with pytest.raises(KeyError):
        clip_map.points_map({4: np.eye(4)})
