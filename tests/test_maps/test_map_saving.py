"""Where maps are saved, and what becomes of those that are there."""

import os
from dataclasses import replace
from pathlib import Path

import pytest

from mapping.map_bundle import load, require_map_folder, save
from tests.helpers.bundles import (
    assert_same,
    bundle_of,
    make_file,
    make_folder_with_a_letter,
    make_foreign_map,
    make_map_with_a_letter,
    names_in,
)
from vizbot.core.errors import MapError


def test_a_map_replaces_an_older_one_and_fills_new_and_empty_folders(tmp_path):
    (tmp_path / "empty").mkdir()
    for folder in (tmp_path / "new" / "home", tmp_path / "empty"):
        save(bundle_of(1), folder)
        save(bundle_of(2), folder)
        assert_same(load(folder), replace(bundle_of(2), created=load(folder).created))
        assert names_in(folder) == ["map.json", "map.safetensors"]
    assert names_in(tmp_path) == ["empty", "new"]
    assert names_in(tmp_path / "new") == ["home"]


@pytest.mark.parametrize(
    "make", [make_file, make_folder_with_a_letter, make_map_with_a_letter, make_foreign_map]
)
def test_what_is_not_a_map_is_never_overwritten(tmp_path, make):
    path = tmp_path / "precious"
    make(path)
    before = {p.name: p.read_bytes() for p in ([path] if path.is_file() else path.iterdir())}
    for refuse in (require_map_folder, lambda folder: save(bundle_of(), folder)):
        with pytest.raises(MapError, match="precious") as error:
            refuse(path)
        assert "\n" not in str(error.value)
    assert before == {
        p.name: p.read_bytes() for p in ([path] if path.is_file() else path.iterdir())
    }
    assert names_in(tmp_path) == ["precious"]


@pytest.mark.parametrize("failing", range(1, 4))
def test_a_disk_that_fails_while_saving_leaves_the_older_map_whole(tmp_path, monkeypatch, failing):
    older = bundle_of(1)
    save(older, tmp_path / "home")
    calls, fsync = [], os.fsync

    def full_disk(descriptor):
        calls.append(descriptor)
        if len(calls) == failing:
            raise OSError(28, "No space left on device")
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(MapError, match="No space left") as error:
        save(bundle_of(2), tmp_path / "home")
    assert "\n" not in str(error.value)
    assert_same(load(tmp_path / "home"), older)
    assert names_in(tmp_path) == ["home"]


def test_an_older_map_moves_back_when_the_new_one_cannot_move_in(tmp_path, monkeypatch):
    older, rename = bundle_of(1), Path.rename
    save(older, tmp_path / "home")

    def refuse_partial(path, target):
        if path.name == ".home.partial":
            raise PermissionError(13, "Permission denied")
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", refuse_partial)
    with pytest.raises(MapError, match="Permission denied"):
        save(bundle_of(2), tmp_path / "home")
    assert_same(load(tmp_path / "home"), older)
    assert names_in(tmp_path) == ["home"]


def test_of_a_map_whose_replacement_was_cut_off_the_one_before_loads(tmp_path, caplog):
    older = bundle_of(1)
    save(older, tmp_path / "home")
    (tmp_path / "home").rename(tmp_path / ".home.previous")
    assert_same(load(tmp_path / "home"), older)
    assert "the map before is read" in caplog.text
    save(bundle_of(2), tmp_path / "home")
    assert names_in(tmp_path) == ["home"]
