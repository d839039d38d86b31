"""Retrieval: the elements of a CLIP map that match a query (paper, section III-B)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def similarities(
    embeddings: NDArray[np.float32], query: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Cosine similarity (N,) of every element to a query, -1 to 1 (paper, equation 7).

    Args:
        embeddings: (N, D) float32, unit rows: only the query needs to be normalised.
        query: (D,) float32, of any length but zero.
    """
    return np.asarray(embeddings @ (query / np.linalg.norm(query)), np.float32)


def find(similarities: NDArray[np.float32], threshold: float) -> NDArray[np.int64]:
    """Indices of the elements above the threshold (paper, equation 8), in the map's order."""
    return np.flatnonzero(similarities > threshold)


def best(
    similarities: NDArray[np.float32], points: NDArray[np.float64], k: int, spacing: float
) -> NDArray[np.int64]:
    """The most similar elements at distinct places, whatever the threshold.

    Args:
        similarities: (N,) float32.
        points: (N, 3) [m].
        k: How many at most.
        spacing: Least distance between any two of them [m].

    Returns:
        (0 to k,) indices, the most similar first.
    """
    left = np.array(similarities, np.float32)
    chosen: list[int] = []
    while len(chosen) < min(k, len(left)):
        index = int(np.argmax(left))
        if left[index] == -np.inf:
            break
        chosen.append(index)
        offsets = points - points[index]
        left[np.einsum("nd,nd->n", offsets, offsets) < spacing**2] = -np.inf
        left[index] = -np.inf
    return np.array(chosen, np.int64)
