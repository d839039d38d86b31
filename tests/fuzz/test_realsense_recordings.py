"""Spoilt `.db3` and `.bag` recordings: frames or one line, whatever they do to the SDK."""

import pytest

from tests.fuzz.trial import count_harmless

pytestmark = pytest.mark.slow

TRIAL = "tests.fuzz.recording_trial"
KINDS = "db3", "bag"
SHORT, LONG, LONG_SEEDS = 8, 50, range(9)
"""Recordings of each kind that are tried, the latter with each of the seeds."""


def attack(folder, kind, seed, count):
    timeout = 60 + 10 * max(count, 10)
    return count_harmless(TRIAL, folder, kind, seed, count, timeout=timeout)


@pytest.mark.parametrize("kind", KINDS)
def test_a_spoilt_recording_of_a_camera_gives_frames_or_one_line(tmp_path, kind):
    assert attack(tmp_path, kind, seed=0, count=SHORT).total() == SHORT


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", LONG_SEEDS)
def test_many_more_spoilt_recordings_of_a_camera_likewise(tmp_path, kind, seed):
    assert attack(tmp_path, kind, seed, count=LONG).total() == LONG


@pytest.mark.long
def test_a_database_that_is_made_to_harm_likewise(tmp_path):
    attack(tmp_path, "harmful", seed=0, count=0)
