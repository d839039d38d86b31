"""Spoilt maps are refused in one line or are valid maps; none ends or stops the program."""

import pytest

from tests.fuzz.trial import count_harmless

pytestmark = pytest.mark.slow

TRIAL = "tests.fuzz.map_trial"
FLIPS, LONG_FLIPS, LONG_SEEDS = 20, 1000, range(1, 5)
"""Maps with a few wrong bits among those that are tried, the latter with each of the seeds."""


def test_spoilt_maps_are_refused_in_one_line_or_are_valid(tmp_path):
    became = count_harmless(TRIAL, tmp_path, 0, FLIPS, timeout=200)
    assert became["refused"] > 450 and became["loaded"] > 10


@pytest.mark.long
@pytest.mark.parametrize("seed", LONG_SEEDS)
def test_many_more_spoilt_maps_likewise(tmp_path, seed):
    count_harmless(TRIAL, tmp_path, seed, LONG_FLIPS, timeout=1800)
