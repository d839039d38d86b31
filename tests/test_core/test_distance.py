"""Distances on a grid."""

import cv2
import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from vizbot.core.distance import distance_to_zero


@pytest.fixture
def one_thread():
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    yield
    cv2.setNumThreads(threads)


def at_offset(image, offset):
    """A copy of an image that begins `offset` bytes after an aligned address."""
    buffer = np.empty(image.size + 128, np.uint8)
    start = -buffer.ctypes.data % 64 + offset
    copy = buffer[start : start + image.size].reshape(image.shape)
    copy[:] = image
    return copy


@pytest.mark.parametrize("shape", [(97, 255), (300, 401), (64, 64)])
def test_distances_are_exact_wherever_the_image_lies_in_memory(one_thread, shape):
    image = (np.random.default_rng(0).random(shape) > 0.01).astype(np.uint8)
    exact = distance_transform_edt(image).astype(np.float32)
    for offset in range(64):
        np.testing.assert_array_equal(distance_to_zero(at_offset(image, offset)), exact)


def test_the_callers_setting_of_ipp_stays():
    before = cv2.ipp.useIPP()
    distance_to_zero(np.eye(5, dtype=bool))
    assert cv2.ipp.useIPP() == before
