"""Spoilt `.db3` and `.bag` recordings: frames or one line, whatever they do to the SDK."""

from collections import Counter

import pytest

from tests.fuzz.trial import require_harmless, tried

TRIAL = "tests.fuzz.recording_trial"


def attack(folder, kind, seed, count):
    rows = tried(TRIAL, folder, kind, seed, count, timeout=60 + 10 * max(count, 10))
    require_harmless(rows)
    became = Counter(row["became"].split(":")[0] for row in rows)
    assert became["refused"] and became["loaded"]  # both happen, so both are tried
    return became


@pytest.mark.parametrize("kind", ["db3", "bag"])
def test_a_spoilt_recording_of_a_camera_gives_frames_or_one_line(tmp_path, kind):
    assert attack(tmp_path, kind, seed=0, count=16).total() == 16


@pytest.mark.long
@pytest.mark.parametrize("kind", ["db3", "bag"])
@pytest.mark.parametrize("seed", range(1, 9))
def test_many_more_spoilt_recordings_of_a_camera_likewise(tmp_path, kind, seed):
    assert attack(tmp_path, kind, seed, count=50).total() == 50


@pytest.mark.long
def test_a_database_that_is_made_to_harm_likewise(tmp_path):
    attack(tmp_path, "harmful", seed=0, count=0)
