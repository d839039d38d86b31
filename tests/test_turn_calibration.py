"""What a source of turns reads too much, from turns that are known better."""

import numpy as np
import pytest

from mapping.turn_calibration import TurnCalibration, TurnCalibrationConfig

NOISE = 0.005


def calibrated(errors: np.ndarray, seed: int, turns: int = 60) -> TurnCalibration:
    """After turns of up to 0.3 rad over 0.3 m that are read with `errors` per radian and metre."""
    rng = np.random.default_rng(seed)
    calibration = TurnCalibration(TurnCalibrationConfig(per_radian=0.02, per_metre=0.02))
    for _ in range(turns):
        truly, distance = rng.uniform(-0.3, 0.3), rng.uniform(-0.1, 0.3)
        read = truly * (1 + errors[0]) + distance * errors[1]
        seen = truly + rng.normal(0.0, NOISE)
        turn = calibration.corrected(read, distance)
        calibration.learn(turn, distance, turn - seen, NOISE**2)
    return calibration


@pytest.mark.parametrize(("turn", "distance"), [(6.0, 0.0), (0.0, 6.0), (3.0, -2.0)])
def test_what_is_left_is_as_large_as_it_says(turn: float, distance: float) -> None:
    normalised = []
    for seed in range(40):
        errors = np.random.default_rng(1000 + seed).normal(0.0, 0.02, 2)
        calibration = calibrated(errors, seed)
        read = turn * (1 + errors[0]) + distance * errors[1]
        off = calibration.corrected(read, distance) - turn
        assert abs(off) < 0.5 * calibrated(errors, seed, turns=0).sigma(turn, distance)
        normalised.append(off / calibration.sigma(turn, distance))
    # The sum of 40 squares: below the 99 % bound of chi-square, and not idly far.
    assert 10.0 < np.sum(np.square(normalised)) < 63.7


def test_who_knows_nothing_corrects_nothing() -> None:
    calibration = TurnCalibration(TurnCalibrationConfig(per_radian=0.05, per_metre=0.0))
    assert calibration.corrected(1.5, 2.0) == 1.5
    assert calibration.sigma(2.0, 100.0) == pytest.approx(0.1, abs=0.1)


def test_images_that_lie_teach_nothing() -> None:
    calibration = calibrated(np.zeros(2), seed=0)
    before = calibration.corrected(1.0, 1.0), calibration.sigma(1.0, 1.0)
    calibration.learn(0.3, 0.3, 0.3, NOISE**2)
    assert (calibration.corrected(1.0, 1.0), calibration.sigma(1.0, 1.0)) == before
