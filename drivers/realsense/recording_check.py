"""Checks that a RealSense recording is whole, before the SDK opens it.

The SDK does not check recordings: an incomplete one gives an obscure message at best, and some end
the process. This check uses the first bytes and the table of topics. `.db3` is a
rosbag2 database (SQLite file format, section 1.3), `.bag` a rosbag (ROS bag format 2.0).
"""

from __future__ import annotations

import sqlite3
import struct
from contextlib import closing
from pathlib import Path

from drivers.ros_bags import not_read
from vizbot.core.errors import ConfigError

_SQLITE_MAGIC = b"SQLite format 3\0"
_BAG_MAGIC = b"#ROSBAG V2.0\n"
_BAG_INDEX_FIELD = b"index_pos="
_REMEDY = "copy it again, or record with colour and depth and stop the recorder before copying"


def check_header(path: Path) -> None:
    """Check by its first bytes that `path` is a `.db3` or `.bag` that is not cut short.

    Raises:
        ConfigError: the file is missing, of another kind, or cut short.
    """
    checks = {".db3": _fault_of_db3, ".bag": _fault_of_bag}
    check = checks.get(path.suffix.lower())
    if check is None:
        raise ConfigError(f"recording {path}: not a .db3 or .bag file; give one of these")
    try:
        if path.exists() and not path.is_file():  # to open a pipe would wait for its other end
            raise ConfigError(f"recording {path}: not a file; give a recording")
        fault = check(path)
    except OSError as error:
        reason = error.strerror or error
        raise ConfigError(f"recording {path}: {reason}; check the path and its rights") from error
    if fault is not None:
        raise ConfigError(f"recording {path}: {fault}; {_REMEDY}")


def check_topics(path: Path) -> None:
    """Check that a `.db3` has colour and depth; a database made to harm may take for ever.

    Raises:
        ConfigError: it is no rosbag2 database or one of other programs, or has no colour or no
            depth.
    """
    fault = _fault_of_topics(path) if path.suffix.lower() == ".db3" else None
    if fault is not None:
        raise ConfigError(f"recording {path}: {fault}; {_REMEDY}")


def _fault_of_db3(path: Path) -> str | None:
    with path.open("rb") as file:
        header = file.read(100)
    if len(header) < 100 or not header.startswith(_SQLITE_MAGIC):
        return "not a rosbag2 database"
    # SQLite writes a page size of 65536, which does not fit the field, as 1.
    page_size = struct.unpack_from(">H", header, 16)[0]
    pages = struct.unpack_from(">I", header, 28)[0]
    whole = pages * (65536 if page_size == 1 else page_size)
    if path.stat().st_size < whole:
        return f"cut short at {path.stat().st_size} of {whole} bytes"
    return None


def _fault_of_topics(path: Path) -> str | None:
    try:
        # An absolute URI: a `?` or `%` in the name must not be read as part of the query.
        uri = f"{path.resolve().as_uri()}?mode=ro"
        with closing(sqlite3.connect(uri, uri=True)) as database:
            rows = database.execute(
                "SELECT name FROM topics WHERE id IN (SELECT DISTINCT topic_id FROM messages)"
            )
            topics = [str(name) for (name,) in rows]
    except (sqlite3.Error, UnicodeError) as error:  # the latter where a name is no text
        return f"not a readable rosbag2 database ({' '.join(str(error).split())[:200]})"
    if topics and not any(topic.startswith("/device_0/") for topic in topics):
        raise not_read(path)
    for stream in ("Depth", "Color"):
        if not any(f"/{stream}_0/image/data" in topic for topic in topics):
            return f"no {stream.lower()} images in it"
    for topic in ("/file_version", "/device_0/info"):
        if topic not in topics:
            return f"topic {topic} is missing"
    return None


def _fault_of_bag(path: Path) -> str | None:
    with path.open("rb") as file:
        header = file.read(4096)
    if not header.startswith(_BAG_MAGIC):
        return "not a rosbag of version 2.0"
    start = header.find(_BAG_INDEX_FIELD) + len(_BAG_INDEX_FIELD)
    if start < len(_BAG_INDEX_FIELD) or len(header) < start + 8:
        return "cut short in its header"
    # The recorder writes the place of the index when it stops; until then it is zero.
    index = struct.unpack_from("<Q", header, start)[0]
    if index == 0:
        return "its recorder was not stopped properly, the index is missing"
    if index >= path.stat().st_size:
        return f"cut short at {path.stat().st_size} bytes, before its index"
    return None
