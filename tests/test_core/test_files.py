import os
import pwd
from codecs import BOM_UTF8
from pathlib import Path

import pytest

from mapping.tum import read_trajectory
from sim_stubs.faults.faulty_program import full_disk
from sim_stubs.homes.textures.canvas import texture_folder
from sim_stubs.world.mjcf_things import read_labels
from tests.helpers.failing import raising
from vizbot.config import load_config
from vizbot.core.errors import ConfigError
from vizbot.core.files import (
    GrowingFile,
    parse_json,
    read_regular,
    require_new,
    require_writable,
    user_folder,
    write_whole,
)
from vizbot.operator.api.auth import token_path
from vizbot.operator.session.saved_maps import maps_folder


def test_a_file_is_replaced_and_nothing_else_is_left(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_bytes(b"old")
    write_whole(path, b"new")
    assert path.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "real").write_bytes(b"old")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    write_whole(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_bytes() == b"new"


def test_pipes_and_folders_are_left_alone(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path):
        with pytest.raises(ConfigError, match="not a file"):
            write_whole(path, b"new")
    assert (tmp_path / "pipe").is_fifo()


def test_a_disk_that_refuses_is_one_line_and_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "notes.txt"
    path.write_bytes(b"old")
    monkeypatch.setattr(os, "fsync", raising(OSError(28, "No space left on device")))
    with pytest.raises(ConfigError, match="No space left"):
        write_whole(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_keeps_its_rights(tmp_path):
    path = tmp_path / "secret.toml"
    path.write_bytes(b"old")
    path.chmod(0o600)
    write_whole(path, b"new")
    assert path.stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("write", [require_writable, lambda path: write_whole(path, b"new")])
def test_a_file_that_is_write_protected_is_left_alone(tmp_path, monkeypatch, write):
    path = tmp_path / "notes.txt"
    path.write_bytes(b"old")
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)  # as to anyone but root
    with pytest.raises(ConfigError, match="may not be written; chmod"):
        write(path)
    assert path.read_bytes() == b"old"


def test_whether_a_file_can_be_written_is_known_beforehand(tmp_path):
    (tmp_path / "notes.txt").write_bytes(b"old")
    for path in (tmp_path / "notes.txt", tmp_path / "new.txt"):
        require_writable(path)
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"old"]
    for path in (tmp_path, tmp_path / "nowhere" / "notes.txt", Path("/proc/notes.txt")):
        with pytest.raises(ConfigError, match="give another file"):
            require_writable(path)


def test_only_regular_files_of_a_bounded_size_are_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "device").symlink_to("/dev/zero")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "notes").write_bytes(b"12345")
    (tmp_path / "link").symlink_to(tmp_path / "notes")
    assert read_regular(tmp_path / "link", 5) == b"12345"
    for name in ("pipe", "device", "loop", "missing", ""):
        with pytest.raises(OSError):
            read_regular(tmp_path / name, 5)
    with pytest.raises(OSError, match="5 bytes, more than 4"):
        read_regular(tmp_path / "notes", 4)


def test_json_that_is_nested_too_deep_is_no_json():
    assert parse_json(b'[{"a": [1.5, "]]"]}]') == [{"a": [1.5, "]]"]}]
    assert parse_json(b"[" * 16 + b"]" * 16)
    for depth in (17, 500, 1_000_000):
        with pytest.raises(ValueError, match="nested too deep"):
            parse_json(b"[" * depth + b"]" * depth)
    for wrong in (b"", b"\xff", b"{", "{}".encode("utf-16")):
        with pytest.raises(ValueError):
            parse_json(wrong)


@pytest.mark.parametrize(
    ("read", "content"),
    [
        (load_config, b"[mount]\nheight = 0.5\n"),
        (read_labels, b'kettle = "yellow kettle"\n'),
        (read_trajectory, b"# stamp x y z qx qy qz qw\n1.5 0 0 0 0 0 0 1\n"),
        (lambda path: parse_json(path.read_bytes()), b'{"model_id": "embedded"}'),
    ],
)
def test_a_byte_order_mark_is_no_part_of_a_text(tmp_path, read, content):
    plain, marked = tmp_path / "plain", tmp_path / "marked"
    plain.write_bytes(content)
    marked.write_bytes(BOM_UTF8 + content)
    assert str(read(marked)) == str(read(plain))


def test_a_file_that_is_there_is_written_only_where_it_is_to_be_replaced(tmp_path):
    path, dangling = tmp_path / "there", tmp_path / "dangling"
    path.write_bytes(b"old")
    dangling.symlink_to(tmp_path / "nowhere")
    for each in (path, dangling):
        with pytest.raises(ConfigError, match=f"{each} is there already; .* add --force"):
            require_new(each, replace=False)
        require_new(each, replace=True)
    require_new(tmp_path / "new", replace=False)
    assert path.read_bytes() == b"old" and not (tmp_path / "new").exists()


def test_lines_that_no_disk_takes_wait_until_it_does(tmp_path, caplog):
    path = tmp_path / "lines"
    growing = GrowingFile(path, "a\n")
    growing.add("bb\n")
    assert path.read_text() == "a\nbb\n"  # at once: a killed program loses none
    with full_disk(7):
        for line in ("ccc\n", "dddd\n", "eeeee\n"):
            growing.add(line)
    assert path.read_text().startswith("a\nbb\n") and len(path.read_text()) <= 7
    assert caplog.text.count("lacks lines: File too large; the run goes on") == 1
    growing.add("f\n")
    assert path.read_text() == "a\nbb\nccc\ndddd\neeeee\nf\n"
    growing.close()
    growing.close()


def test_the_folders_of_a_user_are_where_the_system_has_them(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert user_folder("XDG_CACHE_HOME", ".cache") == tmp_path / ".cache" / "vizbot"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "other"))
    assert user_folder("XDG_CACHE_HOME", ".cache") == tmp_path / "other" / "vizbot"
    monkeypatch.setenv("XDG_CACHE_HOME", "~/relative")
    assert user_folder("XDG_CACHE_HOME", ".cache") == tmp_path / ".cache" / "vizbot"


def test_a_user_without_a_home_has_folders_that_are_not_there(monkeypatch):
    monkeypatch.delenv("HOME", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(pwd, "getpwuid", lambda _: {}[0])
    folder = user_folder("XDG_CACHE_HOME", ".cache")
    assert folder.is_absolute() and not folder.parents[1].exists()
    assert [each.exists() for each in (maps_folder(), token_path(), texture_folder())] == [
        False
    ] * 3
