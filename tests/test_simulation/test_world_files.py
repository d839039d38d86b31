"""World files that are damaged, or made to take all time and memory: one line each."""

import os
import struct
import zipfile
import zlib

import pytest

from sim_stubs.world import world_file
from sim_stubs.world.world_file import read_world
from vizbot.core.errors import ConfigError

pytestmark = pytest.mark.slow

ROOM = """<mujoco><compiler meshdir="."/><asset>{asset}</asset><worldbody>
<geom type="plane" size="3 3 0.1"/><site name="start" pos="0 0 0"/>{body}
</worldbody></mujoco>"""


def zipped(path, content=b"<home/>"):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("Home.xml", content)
    return bytearray(path.read_bytes())


def headers_of(archive):
    """Where the local header and the entry of the directory begin."""
    return archive.index(b"PK\x03\x04"), archive.index(b"PK\x01\x02")


def encrypted(path):
    archive = zipped(path)
    local, entry = headers_of(archive)
    archive[local + 6] |= 1
    archive[entry + 8] |= 1
    path.write_bytes(archive)


def of_another_method(path):
    archive = zipped(path)
    local, entry = headers_of(archive)
    archive[local + 8] = archive[entry + 10] = 97
    path.write_bytes(archive)


def of_damaged_deflate(path):
    archive = zipped(path, os.urandom(3000) + b"<home/>" * 500)
    archive[60:1000] = bytes(940)
    path.write_bytes(archive)


def of_a_vast_texture(path):
    def chunk(kind, content):
        checksum = zlib.crc32(kind + content)
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", checksum)

    header = struct.pack(">IIBBBBB", 30000, 30000, 8, 2, 0, 0, 0)
    rows = zlib.compress(bytes(30000 * 90001), 1)
    png = chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")
    path.with_name("vast.png").write_bytes(b"\x89PNG\r\n\x1a\n" + png)
    texture = '<texture name="t" type="2d" file="vast.png"/><material name="m" texture="t"/>'
    path.write_text(ROOM.format(asset=texture, body='<geom size="1" material="m"/>'))


def of_many_copies(path):
    many = '<replicate count="3000" offset="0.01 0 0"><replicate count="300" offset="0 0.01 0">'
    many += '<geom size="0.1"/></replicate></replicate>'
    path.write_text(ROOM.format(asset="", body=many))


def of_a_pipe(path):
    os.mkfifo(path.with_name("pipe.obj"))
    mesh = '<mesh name="pipe" file="pipe.obj"/>'
    path.write_text(ROOM.format(asset=mesh, body='<geom type="mesh" mesh="pipe"/>'))


@pytest.mark.parametrize(
    ("name", "write", "words"),
    [
        ("home.sh3d", encrypted, "encrypted"),
        ("home.sh3d", of_another_method, "compression"),
        ("home.sh3d", of_damaged_deflate, "cannot be read"),
        ("world.xml", of_a_vast_texture, "memory"),
        ("world.xml", of_many_copies, "takes more than"),
        ("world.xml", of_a_pipe, "may be no file"),
    ],
)
def test_a_world_that_cannot_be_read_is_one_line(tmp_path, monkeypatch, name, write, words):
    monkeypatch.setattr(world_file, "_PROCESSOR", 8)
    if write is of_a_pipe:
        monkeypatch.setattr(world_file, "_WAITING", 5.0)
    path = tmp_path / name
    write(path)
    with pytest.raises(ConfigError) as refusal:
        read_world(path)
    said = str(refusal.value)
    assert "\n" not in said and str(path) in said and words in said
