"""Metadata that the SDK's recorder leaves out of a recording of a software device.

A `.db3` is a rosbag2 database: a table of topics and one of messages, with times in nanoseconds.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from vizbot.core.errors import ConfigError
from vizbot.core.types import SE3

_STAMP = re.compile(rb"(?<=[;\0])timestamp=([-+.0-9]+)")


@contextmanager
def naming(recording: Path) -> Iterator[None]:
    """Turn errors of SQLite and the SDK into one that names the recording.

    Raises:
        ConfigError: the recording could not be written.
    """
    try:
        yield
    except (sqlite3.Error, RuntimeError) as error:
        raise ConfigError(
            f"cannot write {recording}: {error}; make room on its disk, or record to another"
        ) from error


def require_all(recording: Path, count: int) -> None:
    """Check the number of images and samples: the recorder drops those that find no room.

    Raises:
        sqlite3.Error: there are fewer.
    """
    with closing(sqlite3.connect(recording)) as database:
        (there,) = database.execute(
            "SELECT COUNT(*) FROM messages JOIN topics ON topics.id = topic_id"
            " WHERE name LIKE '%/image/data/%' OR name LIKE '%/imu/data'"
        ).fetchone()
    if there < count:
        raise sqlite3.OperationalError(f"{count - there} of {count} images and samples are lost")


def add_imu_extrinsics(recording: Path, T_imu_depth: SE3) -> None:
    """Write where the IMU is, as a recording of a real camera does; the SDK's recorder leaves it.

    The message is a `std_msgs/msg/String` in CDR (little endian, length with the closing zero).
    It maps from the reference, which is the depth camera, to the stream.
    """
    rotation = ",".join(f"{x:f}" for x in T_imu_depth[:3, :3].T.ravel())
    translation = ",".join(f"{x:f}" for x in T_imu_depth[:3, 3])
    text = f"rotation={rotation};translation={translation}".encode() + b"\0"
    message = b"\x00\x01\x00\x00" + len(text).to_bytes(4, "little") + text
    with closing(sqlite3.connect(recording)) as database, database:
        for stream in ("Gyro", "Accel"):
            topic = database.execute(
                "INSERT INTO topics (name, type, serialization_format, offered_qos_profiles)"
                " VALUES (?, 'std_msgs/msg/String', 'cdr', '')",
                (f"/device_0/sensor_2/{stream}_0/tf/ref_1",),
            ).lastrowid
            database.execute(
                "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, 0, ?)",
                (topic, message),
            )


def set_pace(recording: Path) -> None:
    """Give each message the time of its stamp, by which real-time playback goes.

    The recorder writes when it was pushed. The messages of one image or sample have one time, and
    one of them, the metadata, holds its stamp [ms].
    """
    with closing(sqlite3.connect(recording)) as database, database:
        rows = database.execute(
            "SELECT timestamp, data FROM messages JOIN topics ON topics.id = topic_id"
            " WHERE name LIKE '%/metadata' ORDER BY messages.id"
        ).fetchall()
        stamps = {
            pushed: float(found[1]) for pushed, text in rows if (found := _STAMP.search(text))
        }
        first = min(stamps.values(), default=0.0)
        for pushed, stamp in stamps.items():
            # What has no stamp, as the description of the device, is at 0 and comes first. Negative
            # times are those that are set already, since old and new ones may coincide.
            due = -round(1e6 * (stamp - first)) - 1
            database.execute("UPDATE messages SET timestamp = ? WHERE timestamp = ?", (due, pushed))
        database.execute("UPDATE messages SET timestamp = -timestamp WHERE timestamp < 0")
