"""A growing map is saved whole at first, and then what is new."""

from dataclasses import replace

import numpy as np
import pytest

from mapping import map_saver
from mapping.map_bundle import load, load_grid, require_growable
from mapping.map_header import read_header
from mapping.map_saver import MapSaver
from mapping.map_segments import MOST_SEGMENTS
from tests.conftest import MeanColours
from tests.helpers.box_room import T_BASE_CAM
from tests.helpers.bundles import assert_same, names_in
from tests.test_maps.test_map_snapshot import FRAME, ScriptedSlam
from vizbot.config import PerceptionConfig
from vizbot.core.errors import MapError
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.perception.interfaces import PerceptionParts
from vizbot.perception.perception import Perception


class GrowingMap:
    """A map of a robot that sees the same room from ever other places."""

    def __init__(self, seed=0):
        self._slam, self._stamp = ScriptedSlam(np.random.default_rng(seed)), 0.0
        self._perception = Perception(
            FRAME,
            T_BASE_CAM,
            MeanColours(),
            SimulatedClock(),
            PerceptionConfig(embedding_latency=0.0),
            PerceptionParts(slam=self._slam, every_picture=True),
        )

    def after(self, frames):
        """A snapshot after some more frames, and after all keyframes have moved."""
        for _ in range(frames):
            self._stamp += 0.2
            frame = replace(FRAME, stamp=self._stamp)
            self._perception.embed(frame, self._perception.update(frame, None))
        self._slam.move()
        return self._perception.snapshot()


@pytest.fixture
def home(tmp_path):
    return tmp_path / "home"


def test_whatever_was_added_is_loaded_again(home):
    grows, saver = GrowingMap(), MapSaver(home)
    for number, frames in enumerate((4, 3, 1, 0, 5)):
        snapshot = grows.after(frames)
        saver.save(snapshot)
        assert_same(load(home), snapshot.bundle())
        np.testing.assert_array_equal(load_grid(home).occupancy, snapshot.grid.occupancy)
        assert len(read_header(home).segments) == number
    names = [f"map-{number}.safetensors" for number in (1, 2, 3, 4)]
    assert names_in(home) == sorted([*names, "map.json", "map.safetensors"])
    require_growable(home)


def test_what_is_added_takes_what_is_new(home):
    grows, saver = GrowingMap(), MapSaver(home)
    saver.save(grows.after(40))
    saver.save(grows.after(1))
    whole, segment = ((home / f"map{n}.safetensors").stat().st_size for n in ("", "-1"))
    grid = load_grid(home).occupancy.nbytes
    assert segment - grid < (whole - grid) / 5


def test_another_map_is_saved_whole_and_so_is_one_of_many_segments(home):
    grows, saver = GrowingMap(), MapSaver(home)
    for number in range(MOST_SEGMENTS + 3):
        saver.save(grows.after(1))
        assert len(read_header(home).segments) == number % (MOST_SEGMENTS + 1)
    another = GrowingMap(1).after(60)
    saver.save(another)
    assert_same(load(home), another.bundle())
    assert names_in(home) == ["map.json", "map.safetensors"]


def test_after_an_error_nothing_is_lost_and_all_is_saved_next_time(home, monkeypatch):
    grows, saver = GrowingMap(), MapSaver(home)
    first = grows.after(3)
    saver.save(first)

    def full(path, arrays):
        path.write_bytes(b"a part")
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(map_saver, "write_through", full)
        with pytest.raises(MapError, match=r"cannot save the map .*: No space left on device"):
            saver.save(grows.after(2))
    assert_same(load(home), first.bundle())
    last = grows.after(1)
    saver.save(last)
    assert_same(load(home), last.bundle())
    assert names_in(home) == ["map.json", "map.safetensors"]


def test_a_map_that_has_become_too_large_stays_as_it_was(home, monkeypatch):
    grows, saver = GrowingMap(), MapSaver(home)
    first = grows.after(3)
    saver.save(first)
    monkeypatch.setattr(map_saver, "MOST_BYTES", 1000)
    with pytest.raises(MapError, match="more than 1000 bytes: begin a new map"):
        saver.save(grows.after(2))
    assert_same(load(home), first.bundle())


@pytest.mark.parametrize("spoil", ["cut", "changed", "missing"])
def test_a_damaged_segment_is_refused_in_one_line(home, spoil):
    grows, saver = GrowingMap(), MapSaver(home)
    for frames in (3, 2):
        saver.save(grows.after(frames))
    segment = home / "map-1.safetensors"
    content = bytearray(segment.read_bytes())
    segment.unlink()
    if spoil != "missing":
        content[-9] ^= 1
        segment.write_bytes(content[: -9 if spoil == "cut" else None])
    with pytest.raises(MapError, match=r"damaged .*: build it again") as error:
        load(home)
    assert "\n" not in str(error.value)
