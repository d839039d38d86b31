"""Maps of the former schema are read like those of today."""

import json

import numpy as np
import pytest
from safetensors.numpy import load_file

from mapping.map_bundle import load, load_grid, save
from mapping.map_header import MapHeader
from mapping.map_upgrade import ADDED
from mapping.tensor_file import size_of, write_through
from tests.helpers.bundles import bundle_of
from vizbot.core.errors import MapError


def save_as_before(bundle, folder, spoil=lambda arrays: None):
    """Save a map as schema 5 had it: elements name their frame by its row in the trajectory."""
    save(bundle, folder)
    arrays = load_file(folder / "map.safetensors")
    assert (arrays["frames.numbers"] == np.arange(len(bundle.trajectory.stamps))).all()
    arrays = {name: each for name, each in arrays.items() if name not in (*ADDED, "places.frames")}
    seen_in = arrays["places.elements"]  # rows were taken frame by frame
    in_order = np.argsort(arrays["elements.frames"][seen_in[:, 0]], kind="stable")
    arrays["places.elements"] = seen_in[in_order]
    spoil(arrays)
    header = MapHeader.model_validate(json.loads((folder / "map.json").read_text()))
    counts = {name: count for name, count in header.counts.items() if name != "frames"}
    changed = {
        "schema_version": 5,
        "counts": counts,
        "tensors_size": size_of(arrays),
        "tensors_sha256": write_through(folder / "map.safetensors", arrays),
    }
    (folder / "map.json").write_bytes(header.model_copy(update=changed).content())


def test_a_map_of_the_former_schema_is_read_and_saved_as_one_of_today(tmp_path):
    bundle = bundle_of()
    save_as_before(bundle, tmp_path / "home")
    read = load(tmp_path / "home")
    used = np.unique(bundle.elements.frames)
    assert read.frames.numbers.tolist() == used.tolist()
    np.testing.assert_array_equal(read.frames.keyframes, bundle.frames.keyframes[used])
    np.testing.assert_array_equal(read.frames.Ts_keyframe_cam, bundle.frames.Ts_keyframe_cam[used])
    last = bundle.created.timestamp() - (bundle.trajectory.stamps[-1] - bundle.trajectory.stamps)
    np.testing.assert_allclose(read.frames.times, last[used])
    shown_by = bundle.elements.frames[bundle.places.elements[:, 0]]
    np.testing.assert_array_equal(np.sort(read.places.frames), np.sort(shown_by))
    np.testing.assert_array_equal(load_grid(tmp_path / "home").occupancy, bundle.grid.occupancy)
    save(read, tmp_path / "anew")
    assert json.loads((tmp_path / "anew" / "map.json").read_text())["schema_version"] == 6


@pytest.mark.parametrize("name", ["elements.frames", "places.elements"])
def test_a_map_of_the_former_schema_that_refers_to_nothing_is_damaged(tmp_path, name):
    def spoil(arrays):
        arrays[name][-1] = 10_000

    save_as_before(bundle_of(), tmp_path / "home", spoil)
    with pytest.raises(MapError, match=f"damaged .*{name} refers to"):
        load(tmp_path / "home")
