import pytest

from tests.test_benchmarks.episodes.one_room import kitchen_with_sofa


@pytest.fixture
def kitchen():
    """A house of one room, a kitchen with a sofa."""
    return kitchen_with_sofa(4, 3, 2.9, (0.9, 1.5, 0.0))
