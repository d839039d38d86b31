"""Distances on a grid, the same on every run."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def distance_to_zero(image: NDArray[np.uint8] | NDArray[np.bool_]) -> NDArray[np.float32]:
    """Exact Euclidean distance from each pixel to the nearest zero pixel (rows, cols) [pixels].

    In a process with one thread OpenCV takes Intel's IPP for it, whose last bits depend on where
    the image lies in memory. One bit decides between two paths of the same cost, so a run would
    not repeat. Without IPP the distances are exact, and as fast.
    """
    ipp = cv2.ipp.useIPP()
    cv2.ipp.setUseIPP(False)
    try:
        distance = cv2.distanceTransform(image.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    finally:
        cv2.ipp.setUseIPP(ipp)
    return np.asarray(distance, np.float32)
