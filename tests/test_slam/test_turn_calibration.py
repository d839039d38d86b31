"""What a source of turns reads too much, from turns that are known better."""

import numpy as np
import pytest

from mapping.odometry.config import TurnCalibrationConfig
from mapping.odometry.dead_reckoning import TurnCalibration

NOISE = 0.005


SIGMAS = np.array([0.02, 0.02, 0.002])
"""Of the errors per radian, metre and second."""


def calibrated(errors: np.ndarray, seed: int, turns: int = 200) -> TurnCalibration:
    """After turns of up to 0.3 rad over 0.3 m in about a second that are read with `errors`."""
    rng = np.random.default_rng(seed)
    calibration = TurnCalibration(TurnCalibrationConfig(per_radian=0.02, per_metre=0.02))
    calibration.reset_rate(0.002)
    for _ in range(turns):
        truly, distance, period = rng.uniform((-0.3, -0.1, 0.5), (0.3, 0.3, 1.5))
        read = truly + errors @ (truly, distance, period)
        seen = truly + rng.normal(0.0, NOISE)
        turn = calibration.corrected(read, distance, period)
        calibration.learn(turn, distance, period, turn - seen, NOISE**2)
    return calibration


@pytest.mark.parametrize(
    "motion", [(6.0, 0.0, 0.0), (0.0, 6.0, 0.0), (0.0, 0.0, 60.0), (3.0, -2.0, 20.0)]
)
def test_what_is_left_is_as_large_as_it_says(motion: tuple[float, float, float]) -> None:
    normalised, turn = [], motion[0]
    for seed in range(40):
        errors = np.random.default_rng(1000 + seed).normal(0.0, SIGMAS)
        calibration = calibrated(errors, seed)
        off = calibration.corrected(turn + float(errors @ motion), *motion[1:]) - turn
        assert abs(off) < 0.7 * calibrated(errors, seed, turns=0).sigma(*motion)
        normalised.append(off / calibration.sigma(*motion))
    # The sum of 40 squares: below the 99 % bound of chi-square, and not idly far.
    assert 10.0 < np.sum(np.square(normalised)) < 63.7


def test_a_rate_that_wanders_is_followed() -> None:
    config = TurnCalibrationConfig(per_radian=0.0, per_metre=0.0, wander=1e-4)
    calibration, rng, rate = TurnCalibration(config), np.random.default_rng(3), 0.0
    calibration.reset_rate(1e-4)
    off, believed = [], 0
    for _ in range(600):
        rate += rng.normal(0.0, config.wander)
        calibration.predict(1.0)
        turn = calibration.corrected(rate, 0.0, 1.0)
        off.append(turn / calibration.sigma(0.0, 0.0, 1.0))
        believed += calibration.learn(turn, 0.0, 1.0, turn + rng.normal(0.0, 0.001), 0.001**2)
    assert believed > 580
    assert abs(rate) > 1e-3, "it hardly wandered"
    assert 0.5 < np.mean(np.square(off)) < 1.6


def test_who_knows_nothing_corrects_nothing() -> None:
    calibration = TurnCalibration(TurnCalibrationConfig(per_radian=0.05, per_metre=0.0))
    assert calibration.corrected(1.5, 2.0, 3.0) == 1.5
    assert calibration.sigma(2.0, 100.0, 5.0) == pytest.approx(0.1, abs=0.1)


def test_images_that_lie_teach_nothing() -> None:
    calibration = calibrated(np.zeros(3), seed=0)
    before = calibration.corrected(1.0, 1.0, 1.0), calibration.sigma(1.0, 1.0, 1.0)
    calibration.learn(0.3, 0.3, 1.0, 0.3, NOISE**2)
    assert (calibration.corrected(1.0, 1.0, 1.0), calibration.sigma(1.0, 1.0, 1.0)) == before
