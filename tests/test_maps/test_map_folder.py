"""A saved map's folder is deleted and moved as a whole, and not while a robot is in it."""

import os
import shutil
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapping.map_bundle import load, load_grid, save
from mapping.map_folder import MapUse, delete, is_in_use, move
from tests.fuzz.spoilt_maps import replacing
from tests.helpers.bundles import (
    assert_same,
    bundle_of,
    make_file,
    make_folder_with_a_letter,
    make_map_with_a_letter,
    names_in,
)
from vizbot.core.errors import MapError


@pytest.fixture
def home(tmp_path):
    folder = tmp_path / "maps" / "home"
    save(bundle_of(1), folder)
    return folder


class PowerCut(BaseException):
    """Nothing handles it."""


def cut_power(monkeypatch, after):
    """Let so many changes of the disk happen, and end the program at the next one."""
    left = [after]

    def counted(change):
        def changing(*arguments, **options):
            if left[0] == 0:
                raise PowerCut
            left[0] -= 1
            return change(*arguments, **options)

        return changing

    monkeypatch.setattr(Path, "rename", counted(Path.rename))
    for name in ("unlink", "rmdir", "fsync"):
        monkeypatch.setattr(os, name, counted(getattr(os, name)))
    return left


def test_a_deletion_that_is_interrupted_leaves_the_map_whole_or_gone(tmp_path, monkeypatch):
    ends = []
    for after in range(12):
        home = tmp_path / str(after) / "home"
        for seed in (1, 2):
            save(bundle_of(seed), home)
        shutil.copytree(home, home.with_name(".home.previous"))
        before = load(home)
        with monkeypatch.context() as patch:
            left = cut_power(patch, after)
            with suppress(PowerCut):
                delete(home)
            unused = left[0]
        if home.exists():
            assert_same(load(home), before)
        else:
            with pytest.raises(MapError, match="no map at"):
                load(home)
        ends.append((home.exists(), unused > 0))
        save(bundle_of(3), home)
        delete(home)
        assert names_in(home.parent) == []
    assert ends[0] == (True, False) and ends[-1] == (False, True)
    assert (False, False) in ends


def test_a_map_that_a_robot_is_in_is_not_deleted(home):
    with MapUse(home), MapUse(home) as other:
        for _ in range(2):
            assert is_in_use(home)
            with pytest.raises(MapError, match="'home' is in use; change to another map first"):
                delete(home)
        other.close()
        other.close()
        assert is_in_use(home)
    assert not is_in_use(home)
    assert_same(load(home), replace(bundle_of(1), created=load(home).created))
    delete(home)
    assert names_in(home.parent) == []


def test_a_claim_goes_along_with_a_map_that_is_moved(home):
    office = home.with_name("office")
    before = load(home)
    with MapUse(home):
        move(home, office)
        assert is_in_use(office)
        with pytest.raises(MapError, match="in use"):
            delete(office)
    assert names_in(home.parent) == ["office"]
    assert_same(load(office), before)


def test_no_map_is_moved_over_another_one(home):
    save(bundle_of(2), home.with_name("office"))
    save(bundle_of(3), home.with_name("study"))
    home.with_name("study").rename(home.with_name(".study.previous"))
    (home.parent / "file").touch()
    (home.parent / "link").symlink_to("nowhere")
    for name in ("office", "study", "file", "link", "home"):
        with pytest.raises(MapError, match=f"there is a map '{name}' already"):
            move(home, home.with_name(name))
    assert_same(load(home), replace(bundle_of(1), created=load(home).created))


@pytest.mark.parametrize("make", [make_file, make_folder_with_a_letter, make_map_with_a_letter])
def test_what_is_more_or_something_else_than_a_map_is_left_alone(tmp_path, make):
    path = tmp_path / "precious"
    make(path)
    before = sorted(tmp_path.rglob("*"))
    for change in (delete, lambda path: move(path, tmp_path / "elsewhere")):
        with pytest.raises(MapError, match="precious") as refused:
            change(path)
        assert "\n" not in str(refused.value)
    assert sorted(tmp_path.rglob("*")) == before


def test_a_link_to_a_map_is_left_alone(home, tmp_path):
    link = tmp_path / "link"
    link.symlink_to(home)
    with pytest.raises(MapError, match="is a link and is left alone: remove it by hand"):
        delete(link)
    assert link.is_symlink() and load(home)


def test_a_damaged_map_can_be_deleted(home):
    (home / "map.json").write_text("{")
    delete(home)
    assert names_in(home.parent) == []


def test_the_obstacle_map_is_read_alone(home):
    whole, grid = load(home), load_grid(home)
    np.testing.assert_array_equal(grid.occupancy, whole.grid.occupancy)
    np.testing.assert_array_equal(grid.origin, whole.grid.origin)
    assert grid.resolution == whole.grid.resolution
    for zone, expected in zip(grid.zones, whole.keep_out, strict=True):
        np.testing.assert_array_equal(zone, expected)


def test_an_obstacle_map_that_is_none_is_refused_in_one_line(home):
    replacing("grid.occupancy", lambda occupancy: np.full_like(occupancy, 7.0))(home)
    with pytest.raises(MapError, match=r"grid\.occupancy is not within 0 to 1") as refused:
        load_grid(home)
    assert "\n" not in str(refused.value)
    with (home / "map.safetensors").open("r+b") as arrays:
        arrays.truncate(100)
    with pytest.raises(MapError, match="damaged"):
        load_grid(home)
