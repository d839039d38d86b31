import json
import os
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mapping import map_bundle
from mapping.anchors import Cloud, Keyframes, Trajectory, Views
from mapping.clip_mapper import ClipMap, FrameElements
from mapping.map_bundle import MapBundle, load, require_encoder, require_writable, save
from vizbot.commands.maps import describe
from vizbot.core.errors import MapError
from vizbot.core.geometry import transform
from vizbot.core.types import Intrinsics, OccupancyGrid, PoseEstimate, Tracking

GROUPS = ("keyframes", "views", "elements", "cloud", "trajectory")


class Encoder:
    dimension = 4
    threshold = 0.3
    notice = None

    def __init__(self, model_id):
        self.model_id = model_id


def random_pose(rng):
    T = np.eye(4)
    T[:3, :3] = Rotation.random(rng=rng).as_matrix()
    T[:3, 3] = rng.uniform(-5, 5, 3)
    return T


def bundle_of(seed=0, frames=6, model_id="embedded"):
    """A run whose every third frame is a keyframe, and whose graph moved after it."""
    rng = np.random.default_rng(seed)
    estimates, clip_map, cloud = [], ClipMap(4), []
    for frame in range(frames):
        keyframe, is_keyframe = frame // 3 * 2, frame % 3 == 0
        T_keyframe_cam = np.eye(4) if is_keyframe else random_pose(rng)
        estimates.append(
            PoseEstimate(
                0.1 * frame,
                random_pose(rng),
                keyframe,
                T_keyframe_cam,
                is_keyframe,
                Tracking.TRACKING,
            )
        )
        count = int(rng.integers(0, 5))
        elements = FrameElements(
            rng.normal(size=(count, 3)),
            rng.normal(size=(count, 4)).astype(np.float32),
            rng.integers(0, 640, (count, 4), np.int32),
        )
        clip_map.add(keyframe, T_keyframe_cam, elements, frame)
        if is_keyframe:
            points = rng.normal(size=(7, 3)).astype(np.float32)
            cloud.append((keyframe, points, rng.integers(0, 256, (7, 3), np.uint8)))
    poses = {e.keyframe: random_pose(rng) for e in estimates}
    return MapBundle(
        model_id=model_id,
        intrinsics=Intrinsics(640, 480, 600.5, 601.25, 320.0, 239.5),
        T_base_cam=random_pose(rng),
        keyframes=Keyframes.of(poses, estimates),
        views=Views(
            rng.uniform(0, 640, (2 * len(poses), 2)).astype(np.float32),
            rng.integers(0, 2**63, (2 * len(poses), 4)).astype(np.uint64),
            rng.normal(size=(2 * len(poses), 3)).astype(np.float32),
            np.repeat(sorted(poses), 2).astype(np.int32),
        ),
        elements=clip_map.elements,
        grid=OccupancyGrid(
            rng.uniform(0, 1, (9, 13)).astype(np.float32).T, 0.05, np.array([-1.25, 0.3])
        ),
        cloud=Cloud.of(cloud),
        trajectory=Trajectory.of(estimates),
    )


def assert_same(a, b):
    assert (a.model_id, a.intrinsics, a.created) == (b.model_id, b.intrinsics, b.created)
    assert a.notice == b.notice
    np.testing.assert_array_equal(a.T_base_cam, b.T_base_cam)
    np.testing.assert_array_equal(a.grid.occupancy, b.grid.occupancy)
    np.testing.assert_array_equal(a.grid.origin, b.grid.origin)
    assert a.grid.resolution == b.grid.resolution
    for group in GROUPS:
        for column in fields(getattr(a, group)):
            x = getattr(getattr(a, group), column.name)
            y = getattr(getattr(b, group), column.name)
            assert x.dtype == y.dtype
            np.testing.assert_array_equal(x, y)


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


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
    assert header["schema_version"] == 2
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


def test_a_map_of_before_that_says_nothing_still_loads(tmp_path):
    save(bundle_of(), tmp_path / "home")
    header = json.loads((tmp_path / "home" / "map.json").read_text())
    del header["notice"]
    (tmp_path / "home" / "map.json").write_text(json.dumps(header))
    assert load(tmp_path / "home").notice is None


def test_a_map_replaces_an_older_one_and_fills_new_and_empty_folders(tmp_path):
    (tmp_path / "empty").mkdir()
    for folder in (tmp_path / "new" / "home", tmp_path / "empty"):
        save(bundle_of(1), folder)
        save(bundle_of(2), folder)
        assert_same(load(folder), replace(bundle_of(2), created=load(folder).created))
        assert names_in(folder) == ["map.json", "map.safetensors"]
    assert names_in(tmp_path) == ["empty", "new"]
    assert names_in(tmp_path / "new") == ["home"]


def make_file(path):
    path.write_text("a letter")


def make_folder_with_a_letter(path):
    path.mkdir()
    (path / "letter.txt").write_text("a letter")


def make_map_with_a_letter(path):
    save(bundle_of(), path)
    (path / "letter.txt").write_text("a letter")


def make_foreign_map(path):
    path.mkdir()
    (path / "map.json").write_text('{"tiles": []}')


@pytest.mark.parametrize(
    "make", [make_file, make_folder_with_a_letter, make_map_with_a_letter, make_foreign_map]
)
def test_what_is_not_a_map_is_never_overwritten(tmp_path, make):
    path = tmp_path / "precious"
    make(path)
    before = {p.name: p.read_bytes() for p in ([path] if path.is_file() else path.iterdir())}
    for refuse in (require_writable, lambda folder: save(bundle_of(), folder)):
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


def test_a_map_whose_replacement_was_cut_off_says_where_it_stands(tmp_path):
    save(bundle_of(1), tmp_path / "home")
    (tmp_path / "home").rename(tmp_path / ".home.previous")
    with pytest.raises(MapError, match=r"\.home\.previous"):
        load(tmp_path / "home")
    save(bundle_of(2), tmp_path / "home")
    assert names_in(tmp_path) == ["home"]


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


def test_a_single_wrong_byte_in_the_arrays_is_noticed(tmp_path):
    save(bundle_of(), tmp_path / "home")
    file = tmp_path / "home" / "map.safetensors"
    content = bytearray(file.read_bytes())
    content[-3] ^= 1
    file.write_bytes(content)
    with pytest.raises(MapError, match="damaged"):
        load(tmp_path / "home")


def test_a_map_without_its_arrays_is_damaged(tmp_path):
    save(bundle_of(), tmp_path / "home")
    (tmp_path / "home" / "map.safetensors").unlink()
    with pytest.raises(MapError, match="damaged"):
        load(tmp_path / "home")


def test_a_map_of_another_schema_is_refused_and_may_be_replaced(tmp_path):
    save(bundle_of(), tmp_path / "home")
    file = tmp_path / "home" / "map.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"schema_version": 99}))
    with pytest.raises(MapError, match="schema 99"):
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


def test_a_map_answers_only_to_the_encoder_that_made_it():
    bundle = bundle_of(model_id="openai/clip-vit-large-patch14")
    require_encoder(bundle, Encoder("openai/clip-vit-large-patch14"))
    with pytest.raises(MapError, match="openai/clip-vit-large-patch14") as error:
        require_encoder(bundle, Encoder("embedded"))
    assert "'embedded'" in str(error.value)


def test_the_module_is_light_enough_for_reading_maps_without_torch():
    assert "torch" not in vars(map_bundle)
