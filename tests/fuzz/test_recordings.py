"""Spoilt recordings in TUM layout: frames or one line, never a crash, a hang or gigabytes."""

import subprocess
import sys

import cv2
import numpy as np
import pytest

from drivers.tum_sequence import MAX_BYTES, RecordedSequence, image_size
from mapping.tum import read_trajectory
from tests.fuzz.spoilt_recordings import black_png
from tests.fuzz.spoilt_sequences import spoil, write_sequence
from tests.fuzz.trial import count_harmless, outcomes_in_turn
from tests.helpers.checkout import ROOT
from tests.helpers.memory import peak_kib
from vizbot.core.errors import ConfigError, VizbotError

pytestmark = pytest.mark.slow

SHORT, LONG = 400, 5000
"""Recordings that are spoilt and read."""
BUILT_SHORT, BUILT_LONG = 12, 600
"""Recordings that are spoilt and made to maps."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recording")
    write_sequence(folder)
    return folder


def outcome(folder):
    """Frames that were read, or the line that refuses it."""
    try:
        read_trajectory(folder / "groundtruth.txt")
        with RecordedSequence(folder) as sequence:
            return sum(1 for _ in iter(sequence.read, None))
    except VizbotError as error:
        return str(error)


@pytest.mark.parametrize("count", [SHORT, pytest.param(LONG, marks=pytest.mark.long)])
def test_a_spoilt_recording_gives_frames_or_one_line(recording, tmp_path, count):
    rngs = (np.random.default_rng((1, number)) for number in range(count))
    outcomes_in_turn(recording, tmp_path, spoil, outcome, rngs)


@pytest.mark.parametrize("count", [BUILT_SHORT, pytest.param(BUILT_LONG, marks=pytest.mark.long)])
def test_a_spoilt_recording_gives_a_map_that_loads_or_one_line(tmp_path, count):
    trial, timeout = "tests.fuzz.sequence_trial", 60 + 10 * count
    assert count_harmless(trial, tmp_path, 0, count, timeout=timeout).total() == count


def test_an_image_that_would_fill_the_memory_is_refused_before_it_is_decoded(tmp_path):
    write_sequence(tmp_path)
    (tmp_path / "1.png").write_bytes(black_png(20_000, 20_000, 8, 3, 1))
    program = (
        "import sys; from pathlib import Path\n"
        "from tests.fuzz.test_recordings import outcome\n"
        "from tests.helpers.memory import peak_kib\n"
        "print(outcome(Path(sys.argv[1])))\n"
        "print(peak_kib())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)], cwd=ROOT, capture_output=True, text=True,
        timeout=60, check=True,
    )  # fmt: skip
    said, memory = done.stdout.splitlines()
    assert "20000x20000 pixels are more than any camera's" in said
    assert int(memory) < 700_000  # kB


def test_a_list_that_is_too_large_is_refused_before_it_is_read(tmp_path):
    write_sequence(tmp_path)
    with (tmp_path / "associations.txt").open("wb") as file:
        file.truncate(40 * 10**9)
    before = peak_kib()
    with pytest.raises(ConfigError, match=r"list .*associations\.txt: 40000 MB are too many"):
        RecordedSequence(tmp_path)
    assert peak_kib() - before < MAX_BYTES / 1000


def test_the_size_of_an_image_is_read_from_its_header():
    picture = np.zeros((30, 70, 3), np.uint8)
    for ending in (".png", ".jpg"):
        encoded = cv2.imencode(ending, picture)[1].tobytes()
        assert image_size(encoded) == (70, 30)
        assert all(image_size(encoded[:cut]) in (None, (70, 30)) for cut in range(len(encoded)))
    assert image_size(b"") is None and image_size(b"GIF89a") is None
