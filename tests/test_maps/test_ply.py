import numpy as np
import pytest

from mapping.ply import write_ply
from vizbot.core.errors import ConfigError


def test_a_ply_holds_the_points_and_colours_it_was_given(tmp_path):
    rng = np.random.default_rng(0)
    points = rng.uniform(-5, 5, (100, 3))
    rgb = rng.integers(0, 256, (100, 3), np.uint8)
    write_ply(tmp_path / "cloud.ply", points, rgb)
    header, body = (tmp_path / "cloud.ply").read_bytes().split(b"end_header\n", 1)
    lines = header.decode("ascii").splitlines()
    assert lines[:3] == ["ply", "format binary_little_endian 1.0", "element vertex 100"]
    assert [line.split()[1:] for line in lines[3:]] == [
        ["float", "x"],
        ["float", "y"],
        ["float", "z"],
        ["uchar", "red"],
        ["uchar", "green"],
        ["uchar", "blue"],
    ]
    assert len(body) == 100 * 15
    for row, (point, colour) in enumerate(zip(points, rgb, strict=True)):
        vertex = body[15 * row : 15 * row + 15]
        np.testing.assert_array_equal(np.frombuffer(vertex[:12], "<f4"), point.astype(np.float32))
        assert list(vertex[12:]) == colour.tolist()


def test_an_empty_cloud_is_a_whole_file(tmp_path):
    write_ply(tmp_path / "cloud.ply", np.zeros((0, 3)), np.zeros((0, 3), np.uint8))
    assert b"element vertex 0\n" in (tmp_path / "cloud.ply").read_bytes()


def test_an_older_file_is_replaced_and_nothing_is_left_beside_it(tmp_path):
    path = tmp_path / "cloud.ply"
    path.write_text("older")
    write_ply(path, np.zeros((1, 3)), np.zeros((1, 3), np.uint8))
    assert path.read_bytes().startswith(b"ply\n")
    assert list(tmp_path.iterdir()) == [path]


def test_a_place_that_cannot_be_written_is_named_in_one_line(tmp_path):
    with pytest.raises(ConfigError, match="missing") as error:
        write_ply(tmp_path / "missing" / "cloud.ply", np.zeros((0, 3)), np.zeros((0, 3), np.uint8))
    assert "\n" not in str(error.value)
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(ConfigError, match=r"folder\.ply"):
        write_ply(tmp_path / "folder.ply", np.zeros((0, 3)), np.zeros((0, 3), np.uint8))
    assert [path.name for path in tmp_path.iterdir()] == ["folder.ply"]
