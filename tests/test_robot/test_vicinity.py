import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vizbot.perception.vicinity import around_any, is_within


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 3.0))
def test_a_point_is_within_a_radius_as_numpy_measures_it(seed, radius):
    rng = np.random.default_rng(seed)
    points, place = rng.normal(0, 2, (200, 3)), rng.normal(0, 2, 2)
    distances = np.linalg.norm(points[:, :2] - place, axis=1)
    np.testing.assert_array_equal(is_within(points, place, radius), distances <= radius)


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 3.0), st.integers(1, 20))
def test_all_points_around_places_are_found_and_none_far_away(seed, radius, count):
    rng = np.random.default_rng(seed)
    points, places = rng.normal(0, 4, (300, 3)), rng.normal(0, 3, (count, 2))
    nearest = np.linalg.norm(points[:, None, :2] - places, axis=2).min(axis=1)
    found = around_any(points, places, radius)
    assert set(np.flatnonzero(nearest <= radius)) <= set(found)
    assert (nearest[found] <= 3 * radius).all()
    assert (np.diff(found) > 0).all()


def test_nothing_is_around_no_place():
    assert len(around_any(np.zeros((3, 3)), np.zeros((0, 2)), 1.0)) == 0
