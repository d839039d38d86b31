"""Driving by hand over a link that lags, reorders, repeats and breaks."""

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vizbot.core.types import STOP, Twist
from vizbot.operator.session.drive_lease import OLDEST, DriveLease

AHEAD = Twist(0.2, 0.0)


@pytest.fixture
def hand():
    """A clock that is set by hand."""
    return SimpleNamespace(time=100.0)


@pytest.fixture
def lease(hand):
    return DriveLease(lambda: hand.time)


def test_nobody_drives_before_somebody_takes_the_wheel(lease):
    assert lease.twist() is None
    assert not lease.accept(0, 0, 100.0, AHEAD)
    link = lease.take("ann")
    assert lease.holder == "ann"
    assert lease.twist() == STOP
    assert lease.accept(link, 0, 100.0, AHEAD)
    assert lease.twist() == AHEAD
    lease.release(link)
    assert lease.twist() is None


def test_a_command_that_is_too_old_has_no_effect_and_one_that_gets_too_old_ends(lease, hand):
    link = lease.take("ann")
    assert not lease.accept(link, 1, hand.time - OLDEST - 0.01, AHEAD)
    assert lease.twist() == STOP
    assert lease.accept(link, 2, hand.time - 0.1, AHEAD)
    hand.time += 0.19
    assert lease.twist() == AHEAD
    hand.time += 0.02  # 0.31 s after the person's end had heard of us
    assert lease.twist() == STOP


@pytest.mark.parametrize(("later", "speed"), [(0.1, 0.2), (0.0, float("nan")), (0.0, float("inf"))])
def test_a_command_from_the_future_or_of_no_motion_has_no_effect(lease, hand, later, speed):
    link = lease.take("ann")
    assert not lease.accept(link, 1, hand.time + later, Twist(speed, 0.0))
    assert lease.twist() == STOP


@given(st.lists(st.integers(0, 8), max_size=30))
def test_of_commands_that_are_reordered_and_repeated_only_later_ones_count(numbers):
    now = 100.0
    lease = DriveLease(lambda: now)
    link = lease.take("ann")
    newest = -1
    for number in numbers:
        counts = lease.accept(link, number, now, Twist(number / 10, 0.0))
        assert counts == (number > newest)
        newest = max(newest, number)
        assert lease.twist() == Twist(newest / 10, 0.0)


def test_one_person_drives_at_a_time_and_hands_over(lease, hand):
    first = lease.take("ann")
    assert lease.take("bob") is None
    assert lease.holder == "ann"
    lease.accept(first, 1, hand.time, AHEAD)
    second = lease.take("bob", over=True)
    assert lease.holder == "bob"
    assert lease.twist() == STOP
    assert not lease.accept(first, 2, hand.time, AHEAD)
    lease.release(first)
    assert lease.holds(second) and not lease.holds(first)
