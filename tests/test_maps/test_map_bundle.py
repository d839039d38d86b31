import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mapping import map_bundle
from mapping.map_bundle import load, require_encoder, save
from tests.helpers.bundles import (
    Encoder,
    assert_same,
    bundle_of,
    make_folder_with_a_letter,
    make_foreign_map,
    names_in,
    random_pose,
)
from vizbot.commands.map import describe
from vizbot.commands.map_export import MapExport, export
from vizbot.core.errors import ConfigError, MapError
from vizbot.core.geometry import transform


@settings(max_examples=15)
@given(seed=st.integers(0, 10_000), frames=st.integers(0, 9))
def test_a_map_comes_back_bit_for_bit(tmp_path_factory, seed, frames):
    folder = tmp_path_factory.mktemp("maps") / "home"
    bundle = bundle_of(seed, frames)
    save(bundle, folder)
    assert_same(load(folder), bundle)
    assert names_in(folder.parent) == ["home"]


def test_points_and_frames_follow_the_keyframes_of_the_saved_map(tmp_path):
    save(bundle_of(), tmp_path / "home")
    bundle = load(tmp_path / "home")
    poses = bundle.keyframes.poses()
    assert list(poses) == [0, 2]
    moved = {i: random_pose(np.random.default_rng(i + 50)) for i in poses}
    keyframes = replace(bundle.keyframes, Ts_map_cam=np.array([moved[0], moved[2]]))
    for now, T in ((bundle, poses), (replace(bundle, keyframes=keyframes), moved)):
        for points, part in (
            (now.cloud_points(), bundle.cloud),
            (now.element_points(), bundle.elements),
        ):
            rows = zip(part.keyframes.tolist(), part.points_keyframe, strict=True)
            expected = [transform(T[i], point.astype(np.float64)) for i, point in rows]
            np.testing.assert_allclose(points, expected, atol=1e-9)
        trajectory = bundle.trajectory
        frames = zip(trajectory.keyframes.tolist(), trajectory.Ts_keyframe_cam, strict=True)
        np.testing.assert_allclose(now.final_poses(), [T[i] @ relative for i, relative in frames])
    assert bundle.keyframes.stamps.tolist() == pytest.approx([0.0, 0.3])


def test_the_header_can_be_read_by_people_and_other_programs(tmp_path):
    bundle = bundle_of()
    save(bundle, tmp_path / "home")
    header = json.loads((tmp_path / "home" / "map.json").read_text())
    assert header["schema_version"] == 6
    assert header["model_id"] == "embedded"
    assert header["counts"]["elements"] == len(bundle.elements.keyframes)
    assert header["intrinsics"]["fy"] == 601.25


def test_a_map_says_in_words_what_made_it(tmp_path, capsys):
    notice = "rehearsal model, trained on simulated homes"
    save(replace(bundle_of(), notice=notice), tmp_path / "home")
    assert notice in (tmp_path / "home" / "map.json").read_text()
    describe(tmp_path / "home", as_json=True)
    assert json.loads(capsys.readouterr().out)["notice"] == notice
    describe(tmp_path / "home", as_json=False)
    assert notice in capsys.readouterr().err


def test_a_notice_with_several_lines_is_read_as_one(tmp_path):
    save(
        replace(bundle_of(), notice="vizbot: all is well\n\tthe map was checked"), tmp_path / "home"
    )
    assert load(tmp_path / "home").notice == "vizbot: all is well the map was checked"


def test_another_bank_of_pictures_is_not_used(tmp_path, monkeypatch):
    bundle = bundle_of()
    monkeypatch.setattr("mapping.map_bundle.PICTURES_ID", "another bank")
    save(bundle, tmp_path / "home")
    assert_same(load(tmp_path / "home"), bundle)
    monkeypatch.undo()
    loaded = load(tmp_path / "home")
    assert len(loaded.pictures) == 0 and loaded.statistics is not None


def test_statistics_over_another_list_of_phrases_are_not_used(tmp_path, monkeypatch):
    bundle = bundle_of()
    monkeypatch.setattr("mapping.map_bundle.PHRASES_ID", "another list")
    save(bundle, tmp_path / "home")
    assert load(tmp_path / "home").statistics is not None
    monkeypatch.undo()
    loaded = load(tmp_path / "home")
    assert loaded.statistics is None
    np.testing.assert_array_equal(loaded.places.elements, bundle.places.elements)


def test_places_that_lie_too_far_apart_for_a_belief_are_not_saved(tmp_path):
    bundle = bundle_of()
    points = bundle.places.points_keyframe.copy()
    points[0] = 300.0
    far = replace(bundle, places=replace(bundle.places, points_keyframe=points))
    with pytest.raises(MapError, match="places lie more than 1024"):
        save(far, tmp_path / "home")


def change_header(folder, change):
    file = folder / "map.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | change))


@pytest.mark.parametrize(
    "change",
    [
        {"keep_out": []},
        {"T_base_cam": np.eye(4).tolist()},
        {"notice": "another"},
    ],
)
def test_a_change_in_the_header_is_noticed(tmp_path, change):
    save(bundle_of(), tmp_path / "home")
    change_header(tmp_path / "home", change)
    with pytest.raises(MapError, match=r"damaged \(map\.json: .*checksum"):
        load(tmp_path / "home")


def test_an_encoder_whose_embeddings_have_another_length_is_refused():
    longer = Encoder("embedded")
    longer.dimension = 512
    with pytest.raises(MapError, match="have 4 numbers, those of 'embedded' 512"):
        require_encoder(bundle_of(), longer)


@settings(max_examples=40)
@given(part=st.floats(0.0, 0.999), header=st.booleans())
def test_a_torn_map_is_refused_in_one_line(tmp_path_factory, part, header):
    folder = tmp_path_factory.mktemp("maps") / "home"
    save(bundle_of(), folder)
    file = folder / ("map.json" if header else "map.safetensors")
    content = file.read_bytes()
    file.write_bytes(content[: int(part * len(content))])
    with pytest.raises(MapError, match="damaged") as error:
        load(folder)
    assert "\n" not in str(error.value)
    assert str(folder) in str(error.value)


@pytest.mark.parametrize("missing", [True, False])
def test_a_single_wrong_byte_in_the_arrays_is_noticed_and_so_is_their_loss(tmp_path, missing):
    save(bundle_of(), tmp_path / "home")
    file = tmp_path / "home" / "map.safetensors"
    content = bytearray(file.read_bytes())
    content[-3] ^= 1
    file.unlink()
    if not missing:
        file.write_bytes(content)
    with pytest.raises(MapError, match="damaged"):
        load(tmp_path / "home")


@pytest.mark.parametrize("schema", [2, 4, 99])
def test_a_map_of_another_schema_is_refused_and_may_be_replaced(tmp_path, schema):
    save(bundle_of(), tmp_path / "home")
    change_header(tmp_path / "home", {"schema_version": schema})
    with pytest.raises(MapError, match=f"schema {schema}, not 6 or 5"):
        load(tmp_path / "home")
    save(bundle_of(), tmp_path / "home")
    load(tmp_path / "home")


def test_what_is_not_a_map_is_not_loaded(tmp_path):
    with pytest.raises(MapError, match="no map at"):
        load(tmp_path / "missing")
    make_folder_with_a_letter(tmp_path / "letters")
    make_foreign_map(tmp_path / "foreign")
    for name in ("letters", "foreign"):
        with pytest.raises(MapError, match=f"{name} is not a map"):
            load(tmp_path / name)


@pytest.mark.parametrize("name", ["map.json", "map.safetensors", "cloud.ply", "link"])
def test_nothing_is_exported_into_a_map(tmp_path, name):
    save(bundle_of(), tmp_path / "home")
    (tmp_path / "link").symlink_to(tmp_path / "home" / "map.json")
    out = tmp_path / name if name == "link" else tmp_path / "home" / name
    for form in ("ply", "tum"):
        with pytest.raises(MapError, match="give a file outside of it"):
            export(MapExport(tmp_path / "home", form, out))
    assert_same(
        load(tmp_path / "home"), replace(bundle_of(), created=load(tmp_path / "home").created)
    )
    assert names_in(tmp_path / "home") == ["map.json", "map.safetensors"]


def test_a_file_that_cannot_be_written_is_refused_before_the_map_is_read(tmp_path):
    with pytest.raises(ConfigError, match="nowhere"):
        export(MapExport(tmp_path / "missing", "ply", tmp_path / "nowhere" / "cloud.ply"))


def test_a_map_answers_only_to_the_encoder_that_made_it():
    bundle = bundle_of(model_id="openai/clip-vit-large-patch14")
    require_encoder(bundle, Encoder("openai/clip-vit-large-patch14"))
    with pytest.raises(MapError, match="openai/clip-vit-large-patch14") as error:
        require_encoder(bundle, Encoder("embedded"))
    assert "'embedded'" in str(error.value)


def test_the_module_is_light_enough_for_reading_maps_without_torch():
    assert "torch" not in vars(map_bundle)
