"""The rate of steps, for console, report and viewer alike."""

import pytest

from vizbot.operator.figures.steps import StepRate


def rate_of(stamps, now=None):
    rate = StepRate()
    for stamp in stamps:
        rate.add(stamp)
    return rate.rate(stamps[-1] if now is None else now)


def test_the_rate_is_the_mean_of_the_last_five_seconds():
    assert rate_of([0.1 * n for n in range(100)]) == pytest.approx(10.0)
    assert rate_of([*range(10), *(9.0 + 0.1 * n for n in range(1, 101))]) == pytest.approx(10.0)


def test_a_slow_robot_has_a_rate_and_one_that_takes_no_more_steps_an_ever_lower_one():
    assert rate_of([0.0, 20.0, 40.0]) == pytest.approx(0.05)
    assert rate_of([0.0, 0.5, 1.0], now=20.0) == pytest.approx(0.1)


def test_one_step_has_no_rate():
    assert rate_of([3.0]) is None
    assert rate_of([3.0], now=4.0) is None
