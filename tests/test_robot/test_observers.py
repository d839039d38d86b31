"""A full disk costs the video, not the search."""

import errno
import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.helpers.failing import raising
from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.observer import Effort, GoalReport, Observers, Outcome
from vizbot.operator.report.video import Video


class Writer:
    """Fails as a full disk does from the second step on."""

    def __init__(self):
        self.told = []

    def on_step(self, step):
        self.told.append(step)
        if len(self.told) > 1:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def on_goal(self, report):
        self.told.append(report)


def test_one_that_cannot_write_is_told_no_more_and_the_others_are(caplog):
    writer, told = Writer(), []
    observers = Observers([writer, SimpleNamespace(on_step=told.append, on_goal=told.append)])
    for step in range(4):
        observers.on_step(step)
    observers.on_goal("report")
    assert writer.told == [0, 1]
    assert told == [0, 1, 2, 3, "report"]
    assert caplog.text.count("Writer ends here: No space left on device; free some space") == 1


def test_a_device_that_is_silent_is_no_full_disk():
    silent = SimpleNamespace(on_step=raising(DeviceTimeoutError("the base is silent")))
    with pytest.raises(DeviceTimeoutError):
        Observers([silent]).on_step(None)


def test_other_errors_are_not_hidden():
    broken = SimpleNamespace(on_step=lambda step: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        Observers([broken]).on_step(None)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_video_on_a_full_disk_fails_as_an_observer_may(tmp_path):
    path = tmp_path / "run.webm"
    path.symlink_to("/dev/full")
    rng = np.random.default_rng(0)
    with pytest.raises(OSError, match="space"):
        video = Video(path, 320, 240, 10)
        for _ in range(200):
            video.add(rng.integers(0, 255, (240, 320, 3), np.uint8))
        video.close()


@pytest.mark.parametrize(
    ("goal", "outcome", "effort", "words"),
    [("sofa", Outcome.ARRIVED, Effort(49.8, 12.3), "Found the sofa after 50 s, 12 m"),
     ("my desk", Outcome.NOT_FOUND, Effort(7.0, 0.42), "Did not find my desk after 7 s, 0.4 m"),
     ("sofa", Outcome.GAVE_UP, Effort(0.2, 0.0), "Gave up on the sofa after 0 s, 0.0 m"),
     ("The sofa", Outcome.LOCATED, None, "Found The sofa on the map")],
)  # fmt: skip
def test_an_outcome_is_told_in_words_first(goal, outcome, effort, words):
    assert GoalReport(goal, outcome, "so it is", (), effort=effort).headline == words
