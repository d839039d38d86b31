from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_stubs.homes.furniture.wavefront import Material, read_mtl, read_obj
from vizbot.core.errors import ConfigError

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def model(folder: Path, text: str) -> Path:
    (folder / "model.obj").write_text(text)
    return folder


def test_a_polygon_becomes_a_fan_of_triangles(tmp_path: Path) -> None:
    (surface,) = read_obj(model(tmp_path, SQUARE + "f 1 2 3 4\n"), "model.obj")
    assert surface.corners.tolist() == [
        [[0, 0, 0], [1, 0, 0], [1, 1, 0]],
        [[0, 0, 0], [1, 1, 0], [0, 1, 0]],
    ]
    assert not surface.texcoords.any()


def test_negative_indices_count_from_the_end(tmp_path: Path) -> None:
    (forwards,) = read_obj(model(tmp_path, SQUARE + "f 1 2 4\n"), "model.obj")
    (backwards,) = read_obj(model(tmp_path, SQUARE + "f -4 -3 -1\n"), "model.obj")
    np.testing.assert_array_equal(forwards.corners, backwards.corners)


def test_texture_coordinates_follow_their_corners(tmp_path: Path) -> None:
    text = SQUARE + "vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n"
    (surface,) = read_obj(model(tmp_path, text), "model.obj")
    np.testing.assert_array_equal(surface.texcoords[0], surface.corners[0, :, :2])


def test_a_face_wound_against_its_normals_is_turned_round(tmp_path: Path) -> None:
    text = SQUARE + "vn 0 0 -1\nf 1//1 2//1 3//1\n"
    (surface,) = read_obj(model(tmp_path, text), "model.obj")
    first, second, third = surface.corners[0]
    assert np.cross(second - first, third - first)[2] < 0


def test_triangles_are_kept_apart_by_material(tmp_path: Path) -> None:
    (tmp_path / "model.mtl").write_text(
        "newmtl red oak\nKd 1 0 0\nd 0.5\nnewmtl cloth\nKd 0 0 1\n"
        "map_Kd C:\\Users\\someone\\my textures\\cloth.png\n"
    )
    text = f"mtllib model.mtl\n{SQUARE}usemtl red oak\nf 1 2 3\nusemtl cloth\nf 1 3 4\n"
    oak, cloth = read_obj(model(tmp_path, text), "model.obj")
    assert oak.material == Material((1.0, 0.0, 0.0, 0.5), None)
    assert cloth.material == Material((0.0, 0.0, 1.0, 1.0), "cloth.png")


def test_without_a_material_file_everything_is_grey(tmp_path: Path) -> None:
    text = f"mtllib gone.mtl\n{SQUARE}usemtl red\nf 1 2 3\n"
    (surface,) = read_obj(model(tmp_path, text), "model.obj")
    assert surface.material == Material()
    assert read_mtl(tmp_path / "gone.mtl") == {}


@pytest.mark.parametrize("broken", ["", "f 1 2 3\n", "v 0 0\nf 1 1 1\n", SQUARE + "f 1 2 9\n"])
def test_a_model_that_cannot_be_read_is_named(tmp_path: Path, broken: str) -> None:
    with pytest.raises(ConfigError, match=r"model\.obj"):
        read_obj(model(tmp_path, broken), "model.obj")


@given(st.text(alphabet="vfnt /-0123456789.\n", max_size=80))
def test_garbage_is_an_error_or_triangles(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    folder = model(tmp_path_factory.mktemp("garbage"), SQUARE + text)
    try:
        surfaces = read_obj(folder, "model.obj")
    except ConfigError:
        return
    assert all(np.shape(surface.corners)[1:] == (3, 3) for surface in surfaces)
