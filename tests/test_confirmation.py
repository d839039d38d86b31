import numpy as np
import pytest

from mapping.clip_mapper import ClipElements
from vizbot.confirmation import Confirmation

PLACE = np.array([2.0, 0.0])
POINTS = np.array([[2.1, 0.0, 0.5], [2.3, 0.2, 0.9], [4.0, 0.0, 0.5], [2.0, 0.1, 0.5]])
FAR_VIEWS = [0.5, 0.4, 0.6]


def elements(*frames):
    n = len(frames)
    return ClipElements(
        np.zeros((n, 1), np.float32),
        np.zeros((n, 3)),
        np.zeros(n, np.int32),
        np.array(frames, np.int32),
        np.zeros((n, 4), np.int32),
    )


def scores(*values):
    return np.array(values, np.float32)


@pytest.fixture
def looking():
    confirmation = Confirmation(radius=0.6)
    confirmation.begin(next_frame=10, threshold=0.3, place_xy=PLACE)
    return confirmation


def test_no_verdict_before_a_frame_from_here_is_embedded(looking):
    assert looking.verdict(elements(1, 2, 9), scores(*FAR_VIEWS), POINTS[:3]) is None
    assert looking.looking


def test_a_frame_from_here_that_holds_the_goal_confirms_it(looking):
    far_and_near = scores(*FAR_VIEWS, 0.31)
    assert looking.verdict(elements(1, 2, 3, 10), far_and_near, POINTS) is True
    np.testing.assert_array_equal(looking.believable(far_and_near), far_and_near)


def test_a_frame_from_here_without_the_goal_refutes_what_was_seen_here_from_afar(looking):
    far_and_near = scores(*FAR_VIEWS, 0.1)
    assert looking.verdict(elements(1, 2, 3, 10), far_and_near, POINTS) is False
    np.testing.assert_allclose(looking.believable(far_and_near), [-1.0, -1.0, 0.6, 0.1])
    assert not looking.looking


def test_what_is_seen_here_later_counts_again(looking):
    looking.verdict(elements(1, 2, 3, 10), scores(*FAR_VIEWS, 0.1), POINTS)
    later = scores(*FAR_VIEWS, 0.1, 0.7)
    assert looking.believable(later)[4] == pytest.approx(0.7)
