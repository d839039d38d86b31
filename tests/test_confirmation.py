import numpy as np
import pytest

from mapping.clip_mapper import ClipElements
from vizbot.confirmation import Confirmation

ROBOT = np.array([1.2, 0.0])
PLACE = np.array([2.0, 0.0])
IN_THE_DOORWAY, BESIDE_IT, THROUGH_THE_DOOR = [2.1, 0.0, 0.5], [2.3, 0.2, 0.9], [4.0, 0.0, 0.5]


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
    confirmation = Confirmation(near=1.5, radius=0.6)
    confirmation.begin(next_frame=10, threshold=0.3, place_xy=PLACE)
    return confirmation


def test_no_verdict_before_a_frame_from_here_is_embedded(looking):
    points = np.array([IN_THE_DOORWAY])
    assert looking.verdict(elements(9), scores(0.5), points, ROBOT) is None
    assert looking.looking


def test_a_frame_from_here_whose_best_is_near_confirms(looking):
    points = np.array([THROUGH_THE_DOOR, BESIDE_IT])
    assert looking.verdict(elements(9, 10), scores(0.4, 0.31), points, ROBOT) is True
    assert looking.confirmed == 1
    np.testing.assert_array_equal(looking.believable(scores(0.4, 0.31), points), scores(0.4, 0.31))


def test_a_frame_from_here_without_the_goal_refutes_the_place(looking):
    points = np.array([IN_THE_DOORWAY, BESIDE_IT, THROUGH_THE_DOOR])
    seen = scores(0.5, 0.1, 0.4)
    assert looking.verdict(elements(9, 10, 9), seen, points, ROBOT) is False
    np.testing.assert_allclose(looking.believable(seen, points), [-1.0, -1.0, 0.4])
    assert not looking.looking


def test_a_mixed_patch_near_by_does_not_confirm_what_is_better_far_off(looking):
    points = np.array([IN_THE_DOORWAY, THROUGH_THE_DOOR])
    assert looking.verdict(elements(10, 10), scores(0.5, 0.8), points, ROBOT) is False


def test_a_look_that_falls_far_short_of_what_was_seen_from_afar_does_not_confirm(looking):
    points = np.array([THROUGH_THE_DOOR, BESIDE_IT])
    assert looking.verdict(elements(9, 10), scores(0.9, 0.5), points, ROBOT) is False


def test_a_refuted_place_stays_refuted_however_often_it_is_seen(looking):
    points = np.array([IN_THE_DOORWAY, THROUGH_THE_DOOR])
    looking.verdict(elements(10, 10), scores(0.5, 0.8), points, ROBOT)
    later = np.array([IN_THE_DOORWAY, THROUGH_THE_DOOR, IN_THE_DOORWAY])
    np.testing.assert_allclose(looking.believable(scores(0.5, 0.8, 0.7), later), [-1.0, 0.8, -1.0])
