import zipfile
from itertools import product
from pathlib import Path

import cv2
import numpy as np
import pytest

from sim_stubs.homes.furniture.catalogue import (
    CATALOGUE,
    CLASSES,
    Entry,
    instances,
    load_model,
    read_catalogue,
)
from sim_stubs.homes.furniture.paint import painted_in_shades
from vizbot.core.errors import ConfigError

REAL = read_catalogue()
needs_package = pytest.mark.skipif(
    not REAL, reason=f"Debian's sweethome3d-furniture is not installed ({CATALOGUE})"
)

PROPERTIES = """\
# A library
id=Test
license=Public domain  for   all
id#1=Test#box
name#1=Chair
category#1=Living room
model#1=/test/box/box.obj
width#1=40
depth#1=80
height#1=160
creator#1=Nobody
id#2=Test#turned
name#2=Caf\\u00e9 table
category#2=Living room
model#2=/test/box/box.obj
modelRotation#2=0 0 1 0 1 0 -1 0 0
width#2=40
depth#2=80
height#2=160
elevation#2=90
id#3=Test#garden
name#3=Chair
category#3=Exterior
model#3=/test/box/box.obj
width#3=40
depth#3=80
height#3=90
"""
MATERIALS = "newmtl picture\nKd 1 1 1\nmap_Kd front.png\nnewmtl wood\nKd 0.4 0.2 0.1\n"
# A box from (0, 0, 0) to (1, 2, 3): y up, the picture on its front, which faces +z.
BOX = """\
mtllib box.mtl
v 0 0 0
v 1 0 0
v 1 2 0
v 0 2 0
v 0 0 3
v 1 0 3
v 1 2 3
v 0 2 3
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl picture
f 5/1 6/2 7/3 8/4
usemtl wood
f 1 4 3 2
f 1 2 6 5
f 4 8 7 3
f 1 5 8 4
f 2 3 7 6
"""


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def entries(tmp_path: Path, cache: Path) -> dict[str, Entry]:
    picture = np.zeros((64, 32, 3), np.uint8)
    picture[:32] = (0, 0, 255)  # upper half red in OpenCV's order
    with zipfile.ZipFile(tmp_path / "test.sh3f", "w") as archive:
        archive.writestr("PluginFurnitureCatalog.properties", PROPERTIES.encode("latin-1"))
        archive.writestr("test/box/box.obj", BOX)
        archive.writestr("test/box/box.mtl", MATERIALS)
        archive.writestr("test/box/front.png", cv2.imencode(".png", picture)[1].tobytes())
    return {entry.id: entry for entry in read_catalogue(tmp_path)}


def test_without_the_package_the_catalogue_is_empty(tmp_path: Path) -> None:
    assert read_catalogue(tmp_path / "nowhere") == ()


def test_a_library_that_is_no_zip_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "torn.sh3f").write_bytes(b"PK torn")
    with pytest.raises(ConfigError, match=r"torn\.sh3f"):
        read_catalogue(tmp_path)


def test_the_catalogue_lists_models_in_metres(entries: dict[str, Entry]) -> None:
    assert list(entries) == ["Test#box", "Test#garden", "Test#turned"]
    assert entries["Test#box"].size == (0.4, 0.8, 1.6)
    assert entries["Test#turned"].name == "Café table"
    assert entries["Test#turned"].elevation == 0.9
    assert entries["Test#box"].licence == "Public domain for all"


def test_a_piece_stands_on_the_floor_around_its_origin(entries: dict[str, Entry]) -> None:
    piece = load_model(entries["Test#box"], "chair")
    vertices = np.concatenate([part.vertices for part in piece.parts])
    np.testing.assert_allclose(vertices.min(axis=0), [-0.2, -0.4, 0.0], atol=1e-5)
    np.testing.assert_allclose(vertices.max(axis=0), [0.2, 0.4, 1.6], atol=1e-5)
    assert piece.label == "chair"
    assert "Nobody" in piece.attribution and "Public domain" in piece.attribution


def test_the_front_faces_minus_y_with_its_picture_upright(entries: dict[str, Entry]) -> None:
    piece = load_model(entries["Test#box"], "chair", max_texture=16)
    (front,) = [part for part in piece.parts if part.texture is not None]
    first, second, third = front.vertices[front.faces[0]]
    assert np.cross(second - first, third - first)[1] < 0
    np.testing.assert_allclose(front.vertices[:, 1], -0.4, atol=1e-6)
    image = cv2.imread(str(front.texture))
    assert image.shape == (16, 8, 3)
    top = front.texcoords[front.vertices[:, 2] > 1.5]
    np.testing.assert_allclose(top[:, 1], 0.0, atol=1e-6)
    assert image[0, 0].tolist() == [0, 0, 255]
    left_from_the_front = front.texcoords[front.vertices[:, 0] < 0]
    np.testing.assert_allclose(left_from_the_front[:, 0], 0.0, atol=1e-6)


def test_the_catalogues_rotation_turns_the_model(entries: dict[str, Entry]) -> None:
    piece = load_model(entries["Test#turned"], "table")
    (front,) = [part for part in piece.parts if part.texture is not None]
    assert np.ptp(front.vertices[:, 0]) < 1e-6
    np.testing.assert_allclose(front.vertices[:, 0], 0.2, atol=1e-6)


def test_a_second_load_is_the_same_piece(entries: dict[str, Entry]) -> None:
    first, second = (load_model(entries["Test#box"], "chair") for _ in range(2))
    for one, other in zip(first.parts, second.parts, strict=True):
        np.testing.assert_array_equal(one.vertices, other.vertices)
        np.testing.assert_array_equal(one.faces, other.faces)
        assert one.texture == other.texture


def test_torn_cache_files_are_made_anew(entries: dict[str, Entry], cache: Path) -> None:
    whole = load_model(entries["Test#box"], "chair")
    files = [path for path in cache.rglob("*") if path.is_file()]
    assert {path.suffix for path in files} == {".npz", ".png"}
    for file, keep in product(files, (0, 10, 50)):
        content = file.read_bytes()
        file.write_bytes(content[:keep])
        again = load_model(entries["Test#box"], "chair")
        assert file.read_bytes() == content
        np.testing.assert_array_equal(whole.parts[0].vertices, again.parts[0].vertices)


def test_a_cache_that_cannot_be_written_is_named(
    entries: dict[str, Entry], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with pytest.raises(ConfigError, match="XDG_CACHE_HOME"):
        load_model(entries["Test#box"], "chair")


def test_a_recoloured_piece_keeps_its_shape_and_its_shades(entries: dict[str, Entry]) -> None:
    piece = load_model(entries["Test#box"], "chair")
    yellow = painted_in_shades(piece, (1.0, 0.8, 0.0, 1.0))
    assert all(part.texture is None for part in yellow.parts)
    assert len({tuple(part.rgba) for part in yellow.parts}) == 2
    for part, before in zip(yellow.parts, piece.parts, strict=True):
        np.testing.assert_allclose(part.rgba[1] / part.rgba[0], 0.8, rtol=1e-5)
        np.testing.assert_array_equal(part.vertices, before.vertices)


def test_instances_of_a_class_stay_indoors(entries: dict[str, Entry]) -> None:
    catalogue = tuple(entries.values())
    assert instances("chair", catalogue) == (entries["Test#box"],)
    assert instances("piano", catalogue) == ()
    with pytest.raises(ConfigError, match="spaceship"):
        instances("spaceship", catalogue)


@needs_package
def test_every_class_has_a_model_in_the_package() -> None:
    assert [label for label in CLASSES if not instances(label, REAL)] == []


@needs_package
def test_names_that_mislead_are_no_instances() -> None:
    def names(label: str) -> set[str]:
        return {entry.name.lower() for entry in instances(label, REAL)}

    assert not any("fan" in name or "tennis" in name for name in names("table"))
    assert names("refrigerator") == {"fridge", "large fridge", "refrigerator"}
    assert not any("stool" in name or "wheel" in name for name in names("chair"))


@pytest.mark.slow
@needs_package
@pytest.mark.parametrize("label", ["bed", "carpet", "refrigerator", "toilet", "tv"])
def test_real_models_are_light_and_of_the_catalogues_size(label: str, cache: Path) -> None:
    for entry in instances(label, REAL)[:2]:
        piece = load_model(entry, label)
        vertices = np.concatenate([part.vertices for part in piece.parts])
        np.testing.assert_allclose(np.ptp(vertices, axis=0), entry.size, atol=0.03)
        assert abs(vertices[:, 2].min()) < 0.01
        assert sum(len(part.faces) for part in piece.parts) <= 6000
        for part in piece.parts:
            np.testing.assert_allclose(np.linalg.norm(part.normals, axis=1), 1.0, atol=1e-3)
            assert part.faces.max() < len(part.vertices) == len(part.texcoords)
