"""`vizbot map export`: other programs read what it writes."""

import sys
from dataclasses import replace

import cv2
import numpy as np
import pytest
import yaml

from mapping import map_bundle
from tests.helpers.bundles import bundle_of
from vizbot.commands.map_export import MapExport, export
from vizbot.core.errors import ConfigError, MapError
from vizbot.core.geometry import invert
from vizbot.core.types import OccupancyGrid


@pytest.fixture
def home(tmp_path):
    """A saved map of a known plan: 3 x 4 cells, the south-western one free, a wall in the north."""
    occupancy = np.full((3, 4), 0.5, np.float32)
    occupancy[0, 0], occupancy[2] = 0.1, 0.9
    grid = OccupancyGrid(occupancy, 0.05, np.array([-1.0, 2.0]))
    zone = np.array([[-0.9, 2.0], [-0.8, 2.0], [-0.8, 2.1], [-0.9, 2.1]], np.float32)
    bundle = replace(bundle_of(), grid=grid, keep_out=(zone,))
    map_bundle.save(bundle, tmp_path / "home")
    return bundle


def write(tmp_path, form, name="out", **options):
    export(MapExport(tmp_path / "home", form, tmp_path / name, **options))
    return tmp_path / name


def test_a_cloud_is_read_by_plyfile(home, tmp_path):
    from plyfile import PlyData

    vertices = PlyData.read(write(tmp_path, "ply"))["vertex"].data
    points = np.column_stack([vertices[axis] for axis in "xyz"])
    np.testing.assert_allclose(points, home.cloud_points(), atol=1e-5)
    colours = np.column_stack([vertices[name] for name in ("red", "green", "blue")])
    np.testing.assert_array_equal(colours, home.cloud.rgb)


def test_the_points_of_a_cloud_have_the_probability_of_their_place(
    home, tmp_path, monkeypatch, mean_colours
):
    from plyfile import PlyData

    from vizbot.operator.session.saved_map import SavedMap

    monkeypatch.setattr("vizbot.rig.require_encoder", lambda *_: None)
    monkeypatch.setattr("vizbot.rig.open_encoder", lambda *_: mean_colours)
    map_bundle.save(replace(home, model_id=mean_colours.model_id), tmp_path / "home")
    vertices = PlyData.read(write(tmp_path, "ply", query="red"))["vertex"].data
    belief = SavedMap(tmp_path / "home").belief("red")
    places = {
        tuple(place): probability
        for place, probability in zip(
            (np.argwhere(belief.seen)[:, ::-1] + belief.low).tolist(),
            belief.probabilities[belief.seen].tolist(),
            strict=True,
        )
    }
    for vertex in vertices:
        place = int(np.floor(vertex["x"] / 0.25)), int(np.floor(vertex["y"] / 0.25))
        assert vertex["score"] == pytest.approx(places.get(place, 0.0), abs=1e-6)


def test_elements_are_read_by_numpy_and_rank_as_the_paper_does(home, tmp_path):
    with np.load(write(tmp_path, "npz", "home.npz")) as read:
        assert str(read["model_id"]) == "embedded"
        np.testing.assert_array_equal(read["embeddings"], home.elements.embeddings)
        np.testing.assert_allclose(read["points"], home.element_points())
        cameras = home.frames.Ts_map_cam(home.keyframes.poses())[:, :3, 3]
        np.testing.assert_allclose(read["cameras"], cameras[home.elements.frames])
        assert (read["patch_sizes"] == home.elements.boxes[:, 2] - home.elements.boxes[:, 0]).all()


def test_a_plan_is_read_as_nav2_reads_it(home, tmp_path):
    folder = write(tmp_path, "nav2", "nav2")
    settings = yaml.safe_load((folder / "map.yaml").read_text())
    assert settings["mode"] == "trinary" and settings["negate"] == 0
    assert settings["resolution"] == 0.05 and settings["origin"] == [-1.0, 2.0, 0.0]
    image = cv2.imread(str(folder / settings["image"]), cv2.IMREAD_UNCHANGED)
    occupied = (255 - image.astype(float)) / 255
    assert (occupied[0] > settings["occupied_thresh"]).all(), "the north is the first row"
    assert occupied[2, 0] < settings["free_thresh"]
    unknown = occupied[1:].ravel()[[0, 1, 2, 3, 5, 6, 7]]
    assert ((unknown >= settings["free_thresh"]) & (unknown <= settings["occupied_thresh"])).all()
    mask = yaml.safe_load((folder / "keepout_mask.yaml").read_text())
    kept_out = cv2.imread(str(folder / mask["image"]), cv2.IMREAD_UNCHANGED) == 0
    assert kept_out[2, 2] and not kept_out[:, 0].any()
    assert sorted(path.name for path in folder.iterdir()) == [
        "keepout_mask.pgm", "keepout_mask.yaml", "map.pgm", "map.yaml",
    ]  # fmt: skip


@pytest.mark.parametrize("frame", ["camera", "base"])
def test_a_trajectory_is_read_by_evo(home, tmp_path, frame):
    from evo.tools.file_interface import read_tum_trajectory_file

    path = write(tmp_path, "tum", frame=frame)
    assert path.read_text().startswith(f"# of the {frame} in map: timestamp tx")
    read = read_tum_trajectory_file(str(path))
    poses = home.final_poses()
    if frame == "base":
        poses = poses @ invert(home.T_base_cam)
    np.testing.assert_allclose(read.timestamps, home.trajectory.stamps, atol=1e-6)
    np.testing.assert_allclose(read.poses_se3, poses, atol=1e-5)


def test_a_recording_is_read_by_rerun(home, tmp_path):
    from tests.helpers.rrd import entities

    found = entities(write(tmp_path, "rrd", "home.rrd"))
    assert {"map/cloud", "map/elements", "map/camera", "map/keep_out/0"} <= {
        each.strip("/") for each in found
    }


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"form": "obj"}, "unknown format 'obj'; use ply, npz, rrd, nav2, tum"),
        ({"form": "tum", "query": "sofa"}, "--query is for --format ply, not tum"),
        ({"form": "ply", "frame": "base"}, "--frame is for --format tum, not ply"),
        ({"form": "tum", "frame": "wheel"}, "unknown --frame 'wheel'; use camera or base"),
    ],
)
def test_what_does_not_fit_together_is_refused_before_the_map_is_read(tmp_path, options, told):
    with pytest.raises(ConfigError, match=told):
        export(MapExport(folder=tmp_path / "nowhere", out=tmp_path / "out", **options))
    assert not list(tmp_path.iterdir())


def test_a_folder_that_holds_something_is_left_alone(home, tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "letter").write_text("dear")
    with pytest.raises(ConfigError, match="full is not a new or empty folder"):
        write(tmp_path, "nav2", "full")
    assert [path.name for path in (tmp_path / "full").iterdir()] == ["letter"]


def test_a_damaged_map_leaves_no_file(home, tmp_path):
    (tmp_path / "home" / "map.safetensors").write_bytes(b"torn")
    for form in ("ply", "npz", "rrd", "nav2", "tum"):
        with pytest.raises(MapError, match="damaged"):
            write(tmp_path, form)
    assert [path.name for path in tmp_path.iterdir()] == ["home"]


def test_rerun_that_is_not_installed_is_named(home, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "vizbot.operator.viewer.map_recording", None)
    with pytest.raises(ConfigError, match="--format rrd needs rerun: pip install rerun-sdk"):
        write(tmp_path, "rrd")
