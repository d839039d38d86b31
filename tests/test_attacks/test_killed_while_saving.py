"""A program killed while it saves leaves the old or the new on the disk, whole, at any time."""

import itertools
import multiprocessing
import os
import random
import signal
import sys
import time
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache

import numpy as np
import pytest

from mapping import map_bundle
from mapping.map_saver import MapSaver
from tests.helpers.bundles import assert_same, bundle_of, names_in
from tests.test_maps.test_map_saver import GrowingMap
from vizbot.core.files import write_whole
from vizbot.core.types import OccupancyGrid

CELLS = 1000
"""Across the obstacle map: a map of 4 MB takes some 40 ms to be saved."""
KILLS, MANY_KILLS = 20, 300
TOUCHES_DISK = ("open", "os.", "shutil.")
CONTEXT = multiprocessing.get_context("forkserver")  # a fresh process takes a second, a fork none
CONTEXT.set_forkserver_preload([__name__])


def wide_map(seed):
    occupancy = np.full((CELLS, CELLS), 0.5, np.float32)
    occupancy[:seed] = 0.1
    grid = OccupancyGrid(occupancy, 0.05, np.array([-25.0, -25.0]))
    return replace(bundle_of(seed), grid=grid)


def write_map(seed, path):
    map_bundle.save(wide_map(seed), path)


def assert_map(path):
    found = map_bundle.load(path)
    seed = int((found.grid.occupancy[:, 0] < 0.5).sum())
    assert seed in (1, 2)
    assert_same(found, replace(wide_map(seed), created=found.created))


@cache
def growing_map():
    """A small map, and the same one when the robot has seen more."""
    grows, created = GrowingMap(), datetime(2026, 1, 1, tzinfo=UTC)
    taken = (grows.after(2), grows.after(3))
    times = (each.frames.numbers.astype(float) for each in taken)
    return tuple(
        replace(each, created=created, frames=replace(each.frames, times=of_frames))
        for each, of_frames in zip(taken, times, strict=True)
    )


def write_growing_map(seed, path):
    saver = MapSaver(path)
    for snapshot in growing_map()[:seed]:
        saver.save(snapshot)


def assert_growing_map(path):
    found = map_bundle.load(path)
    small, large = growing_map()
    known = {len(each.trajectory.stamps): each for each in (small, large)}
    assert_same(found, known[len(found.trajectory.stamps)].bundle())


def write_file(seed, path):
    write_whole(path, bytes([seed]) * 2**22)


def assert_file(path):
    assert path.read_bytes() in (bytes([1]) * 2**22, bytes([2]) * 2**22)


KINDS = {
    "map": (write_map, assert_map),
    "growing map": (write_growing_map, assert_growing_map),
    "file": (write_file, assert_file),
}


def write_in_turns(connection, write, path):
    """Replace one by the other until killed."""
    growing_map()  # which takes longer than to save it
    connection.send("begins")
    for seed in itertools.cycle((2, 1)):
        write(seed, path)


def write_up_to(step, write, path):
    """Replace the first by the second, but be killed where the disk is touched so often."""
    steps = itertools.count(1)

    def kill(event, _):
        if event.startswith(TOUCHES_DISK) and next(steps) == step:
            os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(kill)
    write(2, path)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("kills", [KILLS, pytest.param(MANY_KILLS, marks=pytest.mark.long)])
def test_what_is_saved_survives_kills_at_any_time(kind, kills, tmp_path):
    write, assert_whole = KINDS[kind]
    path = tmp_path / "kept"
    growing_map()
    began = time.monotonic()
    write(1, path)
    length = time.monotonic() - began
    delays, cut_off = random.Random(kills), False
    for _ in range(kills):
        ours, theirs = CONTEXT.Pipe()
        writer = CONTEXT.Process(target=write_in_turns, args=(theirs, write, path))
        writer.start()
        assert ours.recv() == "begins"
        writer.join(delays.uniform(0.0, 2.0 * length))
        writer.kill()
        writer.join()
        assert writer.exitcode == -signal.SIGKILL
        cut_off |= names_in(tmp_path) != ["kept"]
        assert_whole(path)
    assert cut_off  # or no kill came while it was saved


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_saved_survives_a_kill_between_any_two_steps(kind, tmp_path):
    write, assert_whole = KINDS[kind]
    path = tmp_path / "kept"
    for step in itertools.count(1):
        write(1, path)
        writer = CONTEXT.Process(target=write_up_to, args=(step, write, path))
        writer.start()
        writer.join()
        assert_whole(path)
        if writer.exitcode == 0:
            break
        assert writer.exitcode == -signal.SIGKILL
    assert step > 3
