import numpy as np
import pytest

from vizbot.config import AgreementConfig, ConfirmationConfig
from vizbot.core.geometry import planar
from vizbot.core.types import STOP
from vizbot.objectnav.confirmation import Confirmation
from vizbot.perception.sightings import Sightings

FLOOR = 0.8
PLACE = np.array([2.0, 0.0])
HERE, ELSEWHERE = [2.1, 0.1, 0.5], [4.0, 0.0, 0.5]
NEAR_BY, NEARER, FAR_OFF = [1.2, 0.0], [1.6, 0.0], [-3.0, 0.0]
CONFIG = ConfirmationConfig(agreement=AgreementConfig(views=2, falloff=0.0))
RATE = 1.3
STANDING = planar(1.2, 0.0, 0.0)
SINCE, THRESHOLD = 10, 0.3


def sightings(*elements):
    """Of elements (point, similarity, frame, seen from), each of a keyframe of its own."""
    points, similarities, frames, seen_from = zip(*elements, strict=True)
    return Sightings(
        np.array(points),
        np.array(similarities, np.float32),
        np.arange(len(elements), dtype=np.int32),
        np.array(frames, np.int32),
        np.array(seen_from),
        np.zeros(len(elements), np.float32),
    )


def begun(threshold=THRESHOLD):
    confirmation = Confirmation(CONFIG, RATE)
    confirmation.begin(SINCE, threshold, PLACE, CONFIG.in_sight, STANDING)
    return confirmation


@pytest.fixture
def looking():
    return begun()


def look_around(looking, *seen, since=SINCE):
    """Steps that a look takes which shows `seen`, and (HERE, 0.1) in every frame."""
    elements = list(seen)
    for i in range(40):
        frame, yaw = since + 1 + i, 0.4 * max(i - 1, 0)
        elements.append((HERE, 0.1, frame - 1, NEAR_BY))
        if looking.step(sightings(*elements), frame, FLOOR, planar(1.2, 0.0, yaw)) is None:
            return i
    raise AssertionError("the look does not end")


def test_the_robot_stands_until_a_frame_from_here_is_embedded_and_then_turns(looking):
    seen = [(HERE, 0.5, 9, NEARER), (HERE, 0.5, 8, NEAR_BY)]
    assert looking.step(sightings(*seen), 11, FLOOR, STANDING) == STOP
    seen.append((HERE, 0.1, 10, NEAR_BY))
    twist = looking.step(sightings(*seen), 12, FLOOR, STANDING)
    assert twist.linear == 0.0 and twist.angular == RATE
    assert looking.looking


def test_views_from_near_by_that_agree_confirm_what_is_in_sight(looking):
    seen = sightings(
        (HERE, 0.4, 8, NEARER), (HERE, 0.31, 10, NEAR_BY), (ELSEWHERE, 0.6, 10, NEAR_BY)
    )
    assert looking.step(seen, 11, FLOOR, STANDING) is None
    assert not looking.looking
    np.testing.assert_array_equal(looking.found, [1])
    np.testing.assert_array_equal(looking.believable(seen), seen.similarities)


def test_what_is_farther_from_the_place_than_asked_for_is_something_else():
    beside = [2.6, 0.1, 0.5]
    seen = sightings(*((beside, 0.4, frame, at) for frame, at in ((8, NEARER), (10, NEAR_BY))))
    for within, found in ((CONFIG.in_sight, [1]), (0.5, [])):
        confirmation = Confirmation(CONFIG, RATE)
        confirmation.begin(SINCE, THRESHOLD, PLACE, within, STANDING)
        confirmation.step(seen, SINCE + 1, FLOOR, STANDING)
        assert confirmation.found.tolist() == found
        assert confirmation.looking == (not found)


def test_what_is_found_lies_together(looking):
    seen = sightings(
        (HERE, 0.4, 8, NEARER), (HERE, 0.40, 10, NEAR_BY), ([2.3, 0.1, 0.5], 0.39, 10, NEAR_BY),
        ([3.2, 0.1, 0.5], 0.395, 10, NEAR_BY), (HERE, 0.35, 10, NEAR_BY),
    )  # fmt: skip
    assert looking.step(seen, 11, FLOOR, STANDING) is None
    np.testing.assert_array_equal(looking.found, [1, 2])


def test_a_turn_ends_when_the_goal_comes_into_sight_or_has_shown_something_almost_as_good():
    before = (HERE, 0.4, 8, NEARER), (HERE, 0.4, 9, NEAR_BY)
    sure, fair, poor = (begun() for _ in range(3))
    assert look_around(sure, *before, (HERE, 0.31, 10, NEAR_BY)) == 0
    fair_steps = look_around(fair, *before, (HERE, 0.29, 10, NEAR_BY))
    assert fair_steps >= 2 * np.pi / 0.4
    assert fair.found.tolist() == [2]
    assert look_around(poor, *before, (HERE, 0.2, 10, NEAR_BY)) == fair_steps
    assert len(poor.found) == 0


def test_what_is_in_sight_elsewhere_does_not_confirm(looking):
    look_around(
        looking, (HERE, 0.4, 8, NEARER), (HERE, 0.4, 9, NEAR_BY), (ELSEWHERE, 0.6, 10, NEAR_BY)
    )
    assert len(looking.found) == 0


def test_views_must_agree_on_what_is_in_sight_and_not_on_what_stands_beside_it(looking):
    beside = [3.2, 0.1, 0.5]
    before = (HERE, 0.4, 8, NEARER), (HERE, 0.4, 9, NEAR_BY)
    look_around(looking, *before, (beside, 0.31, 10, NEAR_BY))
    assert len(looking.found) == 0


def test_views_that_are_never_embedded_do_not_hold_the_robot_up(looking):
    seen = sightings((HERE, 0.5, 8, NEAR_BY), (HERE, 0.5, 9, NEARER))
    for i in range(100):
        yaw = 0.4 * max(i - CONFIG.patience, 0)
        if looking.step(seen, SINCE + i, FLOOR, planar(1.2, 0.0, yaw)) is None:
            break
    assert CONFIG.patience + 2 * np.pi / 0.4 < i < 99
    assert len(looking.found) == 0


def test_a_robot_that_is_held_does_not_turn_for_ever(looking):
    seen = sightings((HERE, 0.1, SINCE, NEAR_BY), (HERE, 0.1, 500, NEAR_BY))
    end = SINCE + CONFIG.turn_patience
    assert looking.step(seen, end - 1, FLOOR, STANDING).angular == RATE
    assert looking.step(seen, end, FLOOR, STANDING) is None


def test_what_was_similar_from_afar_alone_is_refuted(looking):
    seen = (HERE, 0.5, 1, FAR_OFF), (HERE, 0.5, 2, FAR_OFF), (HERE, 0.29, 10, NEAR_BY)
    look_around(looking, *seen)
    assert len(looking.found) == 0
    np.testing.assert_allclose(looking.believable(sightings(*seen)), -1.0)


def test_views_of_a_turn_on_the_spot_count_once(looking):
    look_around(looking, (HERE, 0.32, 10, NEAR_BY), (HERE, 0.32, 12, NEAR_BY))
    assert len(looking.found) == 0


def test_what_is_seen_of_a_refuted_place_later_counts_less(looking):
    look_around(looking)
    seen = sightings(
        (HERE, 0.5, 91, NEAR_BY), (HERE, 0.5, 92, NEAR_BY), (ELSEWHERE, 0.5, 3, NEAR_BY),
        (HERE, 0.5, 11, NEAR_BY),
    )  # fmt: skip
    less = 0.5 - CONFIG.doubt
    np.testing.assert_allclose(looking.believable(seen), [less, less, 0.5, -1.0])
    looking.begin(100, THRESHOLD, PLACE, CONFIG.in_sight, planar(3.0, 0.0, 0.0))
    look_around(looking, since=100)
    again = sightings((HERE, 0.5, 192, NEAR_BY))
    np.testing.assert_allclose(looking.believable(again), [0.5 - 2 * CONFIG.doubt])


def test_the_robot_does_not_turn_twice_on_one_spot(looking):
    look_around(looking)
    aside_xy = PLACE + np.array([0.0, 1.0])
    looking.begin(60, THRESHOLD, aside_xy, CONFIG.in_sight, STANDING)
    assert look_around(looking, since=60) == 0
    looking.begin(90, THRESHOLD, aside_xy, CONFIG.in_sight, planar(2.0, 0.0, 0.0))
    assert look_around(looking, since=90) > 2 * np.pi / 0.4


def test_a_robot_that_comes_back_counts_what_it_sees_from_there_alone(looking):
    look_around(looking, (HERE, 0.1, 10, NEAR_BY))
    aside = [2.0, 1.2]
    seen = [(HERE, 0.1, SINCE, NEAR_BY), (HERE, 0.4, 60, NEARER), (HERE, 0.4, 70, aside)]
    looking.begin(80, THRESHOLD, PLACE, CONFIG.in_sight, STANDING)
    assert looking.step(sightings(*seen, (HERE, 0.1, 80, NEAR_BY)), 81, FLOOR, STANDING) is None
    assert len(looking.found) == 0
    looking.begin(90, THRESHOLD, PLACE, CONFIG.in_sight, STANDING)
    doubted = THRESHOLD + 3 * CONFIG.doubt
    seen = [(HERE, doubted, 91, NEAR_BY), (HERE, doubted, 92, NEARER)]
    assert looking.step(sightings(*seen), 93, FLOOR, STANDING) is None
    assert looking.found.tolist() == [0]


def test_a_look_that_is_interrupted_refutes_nothing(looking):
    seen = sightings((HERE, 0.4, 8, NEAR_BY))
    looking.interrupt()
    assert not looking.looking
    np.testing.assert_allclose(looking.believable(seen), [0.4])


def test_a_lowered_threshold_still_asks_for_more_than_nothing():
    looking = begun(threshold=0.24)
    look_around(looking, (HERE, 0.1, 10, NEAR_BY))
    assert len(looking.found) == 0
