import itertools
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np

from benchmarks import console_load
from benchmarks.console_load import ConsoleLoad, LoopedCamera, measure_watchers
from tests.helpers.failing import raising
from tests.helpers.scripted_robot import CAMERA
from vizbot.core.clock import WallClock
from vizbot.core.types import ImuSamples, RGBDFrame


def frames(count):
    rgb = np.random.default_rng(0).integers(0, 255, (240, 320, 3)).astype(np.uint8)
    depth = np.full((240, 320), 1.5, np.float32)
    return [
        RGBDFrame(0.1 * n, np.roll(rgb, n, axis=1), depth, CAMERA, ImuSamples.none())
        for n in range(count)
    ]


def test_a_recorded_folder_is_played_where_one_is_named(tmp_path, monkeypatch):
    shown = frames(3)
    monkeypatch.setattr(console_load, "open_world", raising(AssertionError("a home is opened")))
    monkeypatch.setattr(
        console_load,
        "RecordedSequence",
        lambda folder: nullcontext(SimpleNamespace(read=iter([*shown, *[None] * 99]).__next__)),
    )
    assert console_load.frames_to_play(tmp_path) == shown


def test_the_looped_camera_keeps_to_its_time_and_goes_to_and_fro():
    camera = LoopedCamera(shown := frames(3), WallClock())
    read = [camera.read() for _ in range(6)]
    stamps = [frame.stamp for frame in read]
    assert all(later > sooner for sooner, later in itertools.pairwise(stamps))
    order = [next(n for n, one in enumerate(shown) if one.rgb is frame.rgb) for frame in read]
    assert all(abs(a - b) <= 2 for a, b in itertools.pairwise(order))
    assert set(order) <= {0, 1, 2}


def test_watchers_are_sent_pictures_while_the_loop_is_timed():
    cost = measure_watchers(frames(4), stretch=1.0, pairs=1)
    assert cost.alone[0] > 0.0 and cost.watched[0] > 0.0
    assert cost.pictures > 1.0


def test_the_loss_is_told_as_the_median_of_the_pairs():
    cost = ConsoleLoad((10.0, 10.0, 10.0), (9.0, 9.8, 10.1), 31.0)
    assert "2.0 % of its rate (median of 3, from -1.0 to 10.0)" in cost.summary()
    figures = cost.figures()
    told = [round(figures[key], 6) for key in ("lost", "least", "most", "pictures", "pairs")]
    assert told == [2.0, -1.0, 10.0, 31.0, 3]
