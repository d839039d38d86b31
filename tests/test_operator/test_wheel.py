"""Driving by hand over a link that lags, reorders, repeats and breaks."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vizbot.core.types import STOP, Twist
from vizbot.operator.session.drive_lease import OLDEST, DriveLease

AHEAD = Twist(0.2, 0.0)


class Hand:
    """A clock that is set by hand."""

    def __init__(self):
        self.time = 100.0

    def now(self):
        return self.time


@pytest.fixture
def hand():
    return Hand()


@pytest.fixture
def wheel(hand):
    return DriveLease(hand.now)


def test_nobody_drives_before_somebody_takes_the_wheel(wheel):
    assert wheel.twist() is None
    assert not wheel.tell(0, 0, 100.0, AHEAD)
    link = wheel.take("ann")
    assert wheel.holder == "ann"
    assert wheel.twist() == STOP
    assert wheel.tell(link, 0, 100.0, AHEAD)
    assert wheel.twist() == AHEAD
    wheel.release(link)
    assert wheel.twist() is None


def test_a_command_that_is_too_old_has_no_effect_and_one_that_gets_too_old_ends(wheel, hand):
    link = wheel.take("ann")
    assert not wheel.tell(link, 1, hand.time - OLDEST - 0.01, AHEAD)
    assert wheel.twist() == STOP
    assert wheel.tell(link, 2, hand.time - 0.1, AHEAD)
    hand.time += 0.19
    assert wheel.twist() == AHEAD
    hand.time += 0.02  # 0.31 s after the person's end had heard of us
    assert wheel.twist() == STOP


def test_a_command_from_the_future_has_no_effect(wheel, hand):
    link = wheel.take("ann")
    assert not wheel.tell(link, 1, hand.time + 0.1, AHEAD)


@given(st.lists(st.integers(0, 8), max_size=30))
def test_of_commands_that_are_reordered_and_repeated_only_later_ones_count(numbers):
    hand = Hand()
    wheel = DriveLease(hand.now)
    link = wheel.take("ann")
    newest = -1
    for number in numbers:
        counts = wheel.tell(link, number, hand.time, Twist(number / 10, 0.0))
        assert counts == (number > newest)
        newest = max(newest, number)
        assert wheel.twist() == Twist(newest / 10, 0.0)


def test_one_person_drives_at_a_time_and_hands_over(wheel, hand):
    first = wheel.take("ann")
    assert wheel.take("bob") is None
    assert wheel.holder == "ann"
    wheel.tell(first, 1, hand.time, AHEAD)
    second = wheel.take("bob", over=True)
    assert wheel.holder == "bob"
    assert wheel.twist() == STOP
    assert not wheel.tell(first, 2, hand.time, AHEAD)
    wheel.release(first)
    assert wheel.holds(second) and not wheel.holds(first)


@pytest.mark.parametrize("speed", [float("nan"), float("inf")])
def test_what_is_no_motion_has_no_effect(wheel, hand, speed):
    link = wheel.take("ann")
    assert not wheel.tell(link, 1, hand.time, Twist(speed, 0.0))
    assert wheel.twist() == STOP
