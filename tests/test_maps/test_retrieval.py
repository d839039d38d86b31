import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapping.clip.retrieval import best, find, similarities


def unit_rows(count, dimension, seed=0):
    rows = np.random.default_rng(seed).normal(size=(count, dimension)).astype(np.float32)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


@given(count=st.integers(0, 40), seed=st.integers(0, 99), length=st.floats(0.1, 50.0))
def test_similarity_is_the_cosine_whatever_the_length_of_the_query(count, seed, length):
    embeddings = unit_rows(count, 16, seed)
    query = unit_rows(1, 16, seed + 1)[0]
    scores = similarities(embeddings, np.float32(length) * query)
    assert scores.dtype == np.float32
    np.testing.assert_allclose(scores, [row @ query for row in embeddings], atol=1e-5)


def test_an_element_is_most_similar_to_its_own_embedding():
    embeddings = unit_rows(50, 32)
    scores = similarities(embeddings, embeddings[17])
    assert scores.argmax() == 17
    assert scores[17] == pytest.approx(1.0, abs=1e-5)


def test_only_elements_above_the_threshold_are_found_best_first():
    scores = np.array([0.2, 0.5, 0.3, 0.9, 0.31], np.float32)
    assert find(scores, float(scores[2])).tolist() == [1, 3, 4]
    assert find(scores, 0.95).tolist() == []
    assert find(np.zeros(0, np.float32), 0.1).tolist() == []


@given(
    count=st.integers(0, 60),
    k=st.integers(0, 8),
    spacing=st.floats(0.0, 3.0),
    seed=st.integers(0, 99),
)
def test_the_best_lie_apart_and_nothing_better_was_left_out(count, k, spacing, seed):
    rng = np.random.default_rng(seed)
    scores = rng.uniform(-1, 1, count).astype(np.float32)
    points = rng.uniform(-3, 3, (count, 3))
    chosen = best(scores, points, k, spacing)
    assert len(chosen) <= k
    assert (np.diff(scores[chosen]) <= 0).all()
    for i, index in enumerate(chosen):
        assert (np.linalg.norm(points[chosen[:i]] - points[index], axis=1) >= spacing).all()
    worst = scores[chosen].min() if len(chosen) == k and k > 0 else -np.inf
    for index in set(range(count)) - set(chosen.tolist()):
        near = np.linalg.norm(points[chosen] - points[index], axis=1) < spacing
        beaten = near & (scores[chosen] >= scores[index])
        assert k == 0 or scores[index] <= worst or beaten.any()


def test_elements_at_one_place_count_once():
    scores = np.array([0.9, 0.8, 0.7], np.float32)
    points = np.array([[0.0, 0, 0], [0.1, 0, 0], [2.0, 0, 0]])
    assert best(scores, points, 3, 0.5).tolist() == [0, 2]
