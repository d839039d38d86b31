"""Spoilt `.db3` and `.bag` recordings: frames or one line, whatever they do to the SDK."""

import pytest

from tests.fuzz.trial import count_harmless

pytestmark = pytest.mark.slow

TRIAL = "tests.fuzz.recording_trial"
KINDS = "db3", "bag"
SHORT, LONG, LONG_SEEDS = 8, 50, range(9)
"""Recordings of each kind that are tried, the latter with each of the seeds."""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("count", "seed"),
    [(SHORT, 0), *(pytest.param(LONG, seed, marks=pytest.mark.long) for seed in LONG_SEEDS)],
)
def test_a_spoilt_recording_of_a_camera_gives_frames_or_one_line(tmp_path, kind, seed, count):
    timeout = 60 + 10 * max(count, 10)
    assert count_harmless(TRIAL, tmp_path, kind, seed, count, timeout=timeout).total() == count


@pytest.mark.long
def test_a_database_that_is_made_to_harm_likewise(tmp_path):
    count_harmless(TRIAL, tmp_path, "harmful", 0, 0, timeout=160)
