"""Spoilt maps are refused in one line or are valid maps; none ends or stops the program."""

import pytest

from tests.fuzz.trial import count_harmless

pytestmark = pytest.mark.slow

FLIPS, LONG_FLIPS, LONG_SEEDS = 20, 1000, range(1, 5)
"""Maps with a few wrong bits among those that are tried, the latter with each of the seeds."""


@pytest.mark.parametrize(
    ("seed", "flips", "timeout"),
    [
        (0, FLIPS, 200),
        *(pytest.param(seed, LONG_FLIPS, 1800, marks=pytest.mark.long) for seed in LONG_SEEDS),
    ],
)
def test_spoilt_maps_are_refused_in_one_line_or_are_valid(tmp_path, seed, flips, timeout):
    became = count_harmless("tests.fuzz.map_trial", tmp_path, seed, flips, timeout=timeout)
    assert became["refused"] > 450 and became["loaded"] > 10
