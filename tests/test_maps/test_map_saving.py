"""Where maps are saved, and what becomes of those that are there."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapping import map_bundle
from mapping.map_bundle import (
    load,
    require_growable,
    require_map_folder,
    require_savable,
    save,
)
from mapping.map_header import TENSORS
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


def test_a_map_is_replaced_by_the_work_to_come_only_where_that_is_wanted(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "link").symlink_to("home")
    save(bundle_of(), tmp_path / "home")
    save(bundle_of(), tmp_path / ".interrupted.previous")
    make_folder_with_a_letter(tmp_path / "letters")
    for name in ("new", "empty"):
        require_savable(tmp_path / name, replace=False)
    for name in ("home", "link", "interrupted"):
        with pytest.raises(MapError, match=f"{name} is a map already: .* --force"):
            require_savable(tmp_path / name, replace=False)
        require_savable(tmp_path / name, replace=True)
    for replace_it in (False, True):
        with pytest.raises(MapError, match="letters is not a map and is left alone"):
            require_savable(tmp_path / "letters", replace=replace_it)


def at(array, value):
    """The array with this value in its first place."""
    changed = array.copy()
    changed.flat[0] = value
    return changed


def spoilt(bundle, part, name, value):
    """The map with another value in a part, or in the first place of its array."""
    whole = getattr(bundle, part)
    before = getattr(whole, name)
    after = at(before, value) if isinstance(before, np.ndarray) else value
    return replace(bundle, **{part: replace(whole, **{name: after})})


@pytest.mark.parametrize(
    ("part", "name", "value"),
    [
        ("intrinsics", "fx", 1e7),
        ("intrinsics", "fy", np.nan),
        ("intrinsics", "cx", 1e30),
        ("views", "points", np.inf),
        ("views", "keyframes", 1),
        ("elements", "points_keyframe", 1e9),
        ("elements", "embeddings", 3.0),
        ("elements", "frames", 99),
        ("cloud", "points_keyframe", np.nan),
        ("keyframes", "stamps", -1e308),
        ("keyframes", "Ts_map_cam", 2.0),
        ("trajectory", "stamps", 1e308),
        ("grid", "occupancy", np.nan),
        ("grid", "origin", 9e3),
        ("grid", "resolution", 0.0),
    ],
)
def test_a_map_that_could_not_be_loaded_is_not_saved_and_the_older_one_stays(
    tmp_path, part, name, value
):
    older = bundle_of(1)
    save(older, tmp_path / "home")
    for folder in (tmp_path / "home", tmp_path / "new"):
        with pytest.raises(MapError, match=f"{folder.name} is not saved") as error:
            save(spoilt(bundle_of(2), part, name, value), folder)
        assert "\n" not in str(error.value) and "Value error" not in str(error.value)
    assert_same(load(tmp_path / "home"), older)
    assert names_in(tmp_path) == ["home"]


def too_large(monkeypatch):
    monkeypatch.setattr(map_bundle, "MOST_BYTES", 1000)


def full_disk(failing):
    def patch(monkeypatch):
        calls, fsync = [], os.fsync

        def fail(descriptor):
            calls.append(descriptor)
            if len(calls) == failing:
                raise OSError(28, "No space left on device")
            fsync(descriptor)

        monkeypatch.setattr(os, "fsync", fail)

    return patch


def no_way_in(monkeypatch):
    rename = Path.rename

    def refuse_partial(path, target):
        if path.name == ".home.partial":
            raise PermissionError(13, "Permission denied")
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", refuse_partial)


@pytest.mark.parametrize(
    ("patch", "said"),
    [
        (too_large, "more than 1000"),
        *((full_disk(failing), "No space left") for failing in range(1, 4)),
        (no_way_in, "Permission denied"),
    ],
)
def test_where_saving_fails_the_older_map_stays_whole(tmp_path, monkeypatch, patch, said):
    older = bundle_of(1)
    save(older, tmp_path / "home")
    patch(monkeypatch)
    with pytest.raises(MapError, match=said) as error:
        save(bundle_of(2), tmp_path / "home")
    assert "\n" not in str(error.value)
    monkeypatch.undo()
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


def test_a_robot_goes_on_in_a_map_only_if_it_may_grow_by_100_megabytes(tmp_path, monkeypatch):
    save(bundle_of(), tmp_path / "home")
    size = (tmp_path / "home" / TENSORS).stat().st_size
    monkeypatch.setattr(map_bundle, "MOST_BYTES", size + 100_000_000)
    require_growable(tmp_path / "home")
    monkeypatch.setattr(map_bundle, "MOST_BYTES", size + 99_999_999)
    with pytest.raises(MapError, match="could not be saved: begin a new one") as error:
        require_growable(tmp_path / "home")
    assert "\n" not in str(error.value)
