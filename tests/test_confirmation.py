import numpy as np
import pytest

from vizbot.config import AgreementConfig, ConfirmationConfig
from vizbot.confirmation import Confirmation
from vizbot.sightings import Sightings

FLOOR = 0.8
PLACE = np.array([2.0, 0.0])
HERE, ELSEWHERE = [2.1, 0.1, 0.5], [4.0, 0.0, 0.5]
NEAR_BY, NEARER, FAR_OFF = [1.2, 0.0], [1.6, 0.0], [-3.0, 0.0]
CONFIG = ConfirmationConfig(agreement=AgreementConfig(views=2, falloff=0.0))


def sightings(*elements):
    """Of elements (point, similarity, frame, seen from), each of a keyframe of its own."""
    points, similarities, frames, seen_from = zip(*elements, strict=True)
    return Sightings(
        np.array(points),
        np.array(similarities, np.float32),
        np.arange(len(elements), dtype=np.int32),
        np.array(frames, np.int32),
        np.array(seen_from),
    )


@pytest.fixture
def looking():
    confirmation = Confirmation(CONFIG)
    confirmation.begin(next_frame=10, threshold=0.3, place_xy=PLACE)
    return confirmation


def test_no_verdict_before_a_frame_from_here_is_embedded(looking):
    seen = sightings((HERE, 0.5, 9, NEARER), (HERE, 0.5, 8, NEAR_BY))
    assert looking.verdict(seen, 11, FLOOR) is None
    assert looking.looking


def test_a_view_that_is_never_embedded_does_not_hold_the_robot_up(looking):
    seen = sightings((HERE, 0.5, 8, NEAR_BY), (HERE, 0.5, 9, NEARER))
    assert looking.verdict(seen, 10 + CONFIG.patience, FLOOR) is True


def test_views_from_near_by_that_agree_confirm(looking):
    seen = sightings(
        (HERE, 0.31, 8, NEAR_BY), (HERE, 0.4, 9, NEARER), (ELSEWHERE, 0.6, 10, NEAR_BY)
    )
    assert looking.verdict(seen, 11, FLOOR) is True
    np.testing.assert_array_equal(looking.believable(seen), seen.similarities)


def test_what_was_similar_from_afar_alone_is_refuted(looking):
    seen = sightings((HERE, 0.5, 1, FAR_OFF), (HERE, 0.5, 2, FAR_OFF), (HERE, 0.1, 10, NEAR_BY))
    assert looking.verdict(seen, 11, FLOOR) is False
    assert not looking.looking
    np.testing.assert_allclose(looking.believable(seen), -1.0)


def test_views_of_a_turn_on_the_spot_count_once(looking):
    seen = sightings((HERE, 0.32, 8, NEAR_BY), (HERE, 0.32, 10, NEAR_BY))
    assert looking.verdict(seen, 11, FLOOR) is False


def test_a_single_view_from_near_by_is_not_enough(looking):
    seen = sightings((HERE, 0.29, 10, NEAR_BY), (HERE, 0.5, 2, FAR_OFF))
    assert looking.verdict(seen, 11, FLOOR) is False


def test_what_is_seen_of_a_refuted_place_later_counts_less(looking):
    looking.verdict(sightings((HERE, 0.1, 10, NEAR_BY)), 11, FLOOR)
    seen = sightings(
        (HERE, 0.5, 11, NEAR_BY), (HERE, 0.5, 12, NEAR_BY), (ELSEWHERE, 0.5, 3, NEAR_BY)
    )
    np.testing.assert_allclose(looking.believable(seen), [-1.0, 0.5 - CONFIG.doubt, 0.5])
    looking.begin(next_frame=20, threshold=0.3, place_xy=PLACE)
    looking.verdict(sightings((HERE, 0.1, 20, NEAR_BY)), 21, FLOOR)
    again = sightings((HERE, 0.5, 22, NEAR_BY))
    np.testing.assert_allclose(looking.believable(again), [0.5 - 2 * CONFIG.doubt])


def test_a_lowered_threshold_still_asks_for_more_than_nothing(looking):
    looking.begin(next_frame=10, threshold=0.24, place_xy=PLACE)
    assert looking.verdict(sightings((HERE, 0.1, 10, NEAR_BY)), 11, FLOOR) is False
