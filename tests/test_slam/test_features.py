import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from mapping.odometry.config import FeatureConfig
from mapping.odometry.features import (
    NO_FEATURES,
    Features,
    depth_at,
    detect,
    strongest_corners,
)
from mapping.odometry.rgbd_odometry import match
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

CAMERA = Intrinsics(320, 240, 300.0, 310.0, 159.5, 119.5)
CONFIG = FeatureConfig()


def texture(seed: int = 0) -> NDArray[np.uint8]:
    """Grey rectangles (300, 400) on noise."""
    rng = np.random.default_rng(seed)
    image = rng.normal(128, 8, (300, 400))
    for _ in range(150):
        (u, v), (w, h) = rng.integers(0, 390, 2), rng.integers(6, 40, 2)
        image[v : v + h, u : u + w] = rng.uniform(30, 230)
    return cv2.GaussianBlur(np.clip(image, 0, 255), (0, 0), 1.0).astype(np.uint8)


def frame(grey: NDArray[np.uint8], depth: float = 2.0) -> RGBDFrame:
    """A picture of a wall straight ahead."""
    return RGBDFrame(
        0.0,
        np.repeat(grey[..., None], 3, axis=2),
        np.full(grey.shape, depth, np.float32),
        CAMERA,
        ImuSamples.none(),
    )


def random_features(count: int, seed: int) -> Features:
    rng = np.random.default_rng(seed)
    return Features(
        rng.uniform((0, 0), (319, 239), (count, 2)),
        rng.integers(0, 2**63, (count, 4), dtype=np.uint64),
        np.ones((count, 3)),
    )


def brute_force(
    features: Features, predicted: NDArray[np.float64], others: Features, radius: float
) -> set[tuple[int, int]]:
    """The same matches by comparing everything with everything."""
    words = features.descriptors[:, None] ^ others.descriptors[None]
    hamming = np.bitwise_count(words).sum(axis=-1).astype(float)
    away = np.linalg.norm(predicted[:, None] - others.pixels[None], axis=-1)
    hamming[~(away <= radius)] = 257
    claims: dict[int, tuple[float, int]] = {}
    for i, row in enumerate(hamming):
        order = np.argsort(row, kind="stable")
        best, second = row[order[0]], row[order[1]]
        if best > CONFIG.max_hamming or best > CONFIG.ratio * second:
            continue
        j = int(order[0])
        if j not in claims or best < claims[j][0]:
            claims[j] = (best, i)
    return {(i, j) for j, (_, i) in claims.items()}


def test_points_lie_where_pixels_and_depth_say() -> None:
    features = detect(frame(texture()[:240, :320], depth=2.5), CONFIG)
    assert len(features) > 100
    assert np.allclose(features.points[:, 2], 2.5)
    u = CAMERA.fx * features.points[:, 0] / 2.5 + CAMERA.cx
    v = CAMERA.fy * features.points[:, 1] / 2.5 + CAMERA.cy
    assert np.allclose(np.column_stack((u, v)), features.pixels, atol=1e-6)


def test_corners_keep_their_distance_and_number() -> None:
    features = detect(frame(texture()[:240, :320]), FeatureConfig(count=80))
    apart = np.linalg.norm(features.pixels[:, None] - features.pixels[None], axis=-1)
    assert len(features) <= 80
    # Refinement moves each corner by a few pixels at most.
    assert np.partition(apart, 1, axis=1)[:, 1].mean() > CONFIG.spacing


@given(seed=st.integers(0, 10_000), spacing=st.floats(0, 20), levels=st.integers(1, 256))
def test_the_strongest_corners_are_those_of_opencv(seed: int, spacing: float, levels: int) -> None:
    # A few levels give many corners of equal strength.
    noise = np.random.default_rng(seed).integers(0, levels, (60, 90)).astype(np.uint8)
    config = FeatureConfig(count=100, spacing=spacing)
    expected = cv2.goodFeaturesToTrack(noise, 100, config.quality, spacing)
    expected = np.zeros((0, 2), np.float32) if expected is None else expected[:, 0]
    np.testing.assert_array_equal(strongest_corners(noise, config), expected)


def test_darkness_and_white_walls_have_no_corners() -> None:
    noise = np.random.default_rng(0).normal(0, 2.5, (240, 320))
    for level in (5, 250):
        grey = np.clip(level + noise, 0, 255).astype(np.uint8)
        assert len(detect(frame(grey), CONFIG)) < 10
    assert len(detect(frame(np.zeros((240, 320), np.uint8)), CONFIG)) == 0


def test_a_corner_on_the_edge_of_an_object_has_no_depth() -> None:
    depth = np.full((40, 40), 3.0, np.float32)
    depth[:, :20] = 1.0
    pixels = np.array([[10.0, 10.0], [19.6, 10.0], [30.0, 10.0]])
    assert depth_at(depth, pixels, 0.05, 8.0).tolist() == [1.0, 0.0, 3.0]


def test_depth_needs_most_of_its_surroundings_and_has_a_limit() -> None:
    depth = np.full((20, 40), 2.0, np.float32)
    depth[9, 9:12] = 0.0
    depth[9:11, 19:22] = 0.0
    depth[:, 28:] = 9.0
    pixels = np.array([[10.0, 10.0], [20.0, 10.0], [34.0, 10.0], [0.0, 19.0]])
    assert depth_at(depth, pixels, 0.05, 8.0).tolist() == [2.0, 0.0, 0.0, 2.0]


def test_the_corners_of_a_shifted_picture_are_found_again_to_a_fraction_of_a_pixel() -> None:
    wall = texture()
    shift = np.array([7.4, -3.6])
    moved = cv2.warpAffine(wall, np.float64([[1, 0, shift[0]], [0, 1, shift[1]]]), (400, 300))
    first, second = (detect(frame(image[30:270, 40:360]), CONFIG) for image in (wall, moved))
    pairs = match(first, first.pixels, second, 20.0, CONFIG)
    off = second.pixels[pairs[:, 1]] - first.pixels[pairs[:, 0]] - shift
    assert len(pairs) > 0.4 * len(first)
    assert np.median(np.linalg.norm(off, axis=1)) < 0.3


@given(seed=st.integers(0, 10_000), radius=st.floats(3, 400))
def test_guided_matching_finds_what_comparing_everything_finds(seed: int, radius: float) -> None:
    rng = np.random.default_rng(seed)
    features = random_features(60, seed)
    flips = rng.integers(0, 2**63, (60, 4), dtype=np.uint64)
    for _ in range(3):
        flips &= rng.integers(0, 2**63, (60, 4), dtype=np.uint64)
    others = Features(
        np.clip(features.pixels + rng.normal(0, 5, (60, 2)), 0, 319),
        features.descriptors ^ flips,
        features.points,
    )
    predicted = features.pixels.copy()
    predicted[::7] = np.nan
    found = {(int(i), int(j)) for i, j in match(features, predicted, others, radius, CONFIG)}
    assert found == brute_force(features, predicted, others, radius)


def test_images_without_corners_do_not_match() -> None:
    features = random_features(5, 0)
    assert match(features, features.pixels, NO_FEATURES, 50.0, CONFIG).shape == (0, 2)
    assert match(NO_FEATURES, NO_FEATURES.pixels, features, 50.0, CONFIG).shape == (0, 2)
