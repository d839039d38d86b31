"""Ways to spoil a recording of a RealSense, drawn from a seed."""

import random
import re
import sqlite3
import struct
import zlib
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from operator import methodcaller
from pathlib import Path

from tests.fuzz.trial import Allowed, Spoilt

_LENGTHS = (b"\xff" * 4, bytes(4), b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\1\0\0\0", b"\0\0\1\0")
_NUMBERS = (b"nan", b"inf", b"-1", b"0", b"1e999", b"9" * 400, b"", b"%n%s", b"1e-300", b"-1e30")
_TIMES = (-1, 0, 1, 2**62, -(2**63), 2**63 - 1)
_WORDS = ("_0", "sensor", "image", "data", "1", "Depth", "Color", "Gyro", "/", "device", "info")
_OTHERS = ("", "_9999999999", "x", "%n%s", "-1", "Confidence", "_1", "/", "é", "\x1b[2J")
_REPLACE = "UPDATE messages SET data = ? WHERE id = ?"
_TYPES = ("x", "", "std_msgs/msg/UInt32", "sensor_msgs/msg/Image", "std_msgs/msg/String")


def spoilt_bytes(ending: str, seed: int, count: int) -> Iterator[Spoilt]:
    """Bytes of the file that are wrong, missing or too many."""
    for number in range(count):
        rng = random.Random(f"{ending} {seed} {number}")
        kind = rng.choice(list(_BYTES))
        name = f"{ending} {seed} {number}: {kind}"
        yield Spoilt(name, Allowed.ANY, partial(_rewrite, spoil=partial(_BYTES[kind], rng)))


def spoilt_messages(seed: int, count: int) -> Iterator[Spoilt]:
    """Messages and topics of a whole `.db3` that are wrong."""
    for number in range(count):
        rng = random.Random(f"messages {seed} {number}")
        kind = rng.choice(list(_MESSAGES))
        name = f"messages {seed} {number}: {kind}"
        yield Spoilt(name, Allowed.ANY, partial(_change, change=partial(_MESSAGES[kind], rng)))


def harmful_databases() -> Iterator[Spoilt]:
    """Databases that are made to harm, not damaged."""
    endless = (
        "ALTER TABLE {0} RENAME TO old; CREATE VIEW {0} AS WITH RECURSIVE endless({1}) AS"
        " (SELECT * FROM old UNION ALL SELECT * FROM endless) SELECT * FROM endless"
    )
    scripts = {
        "topics without end": endless.format(
            "topics", "id, name, type, serialization_format, offered_qos_profiles"
        ),
        "messages without end": endless.format("messages", "id, topic_id, timestamp, data"),
        "topics of long names": "UPDATE topics SET name = name || hex(zeroblob(200000))",
        "messages without data": "UPDATE messages SET data = x''",
        "messages of text": "UPDATE messages SET data = 'text', timestamp = 'now'",
        "topics that are no text": "UPDATE topics SET name = x'ff00fe'",
        "no order of time": "UPDATE messages SET timestamp = random()",
        "all at one time": "UPDATE messages SET timestamp = 5",
        "one topic for all": "UPDATE messages SET topic_id = 28",
    }
    for name, script in scripts.items():
        change = methodcaller("executescript", script)
        yield Spoilt(name, Allowed.ANY, partial(_change, change=change))
    yield Spoilt(
        "an image of 30000 x 30000",
        Allowed.ANY,
        lambda path: _change(path, _bomb(black_png(30_000, 30_000, 16, 1, 9))),
    )


def _rewrite(path: Path, spoil: Callable[[bytearray], bytes]) -> None:
    path.write_bytes(spoil(bytearray(path.read_bytes())))


def _flip(rng: random.Random, content: bytearray) -> bytes:
    for _ in range(rng.randint(1, 20)):
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    return content


def _cut(rng: random.Random, content: bytearray) -> bytes:
    return content[: rng.randrange(len(content))]


def _insert(rng: random.Random, content: bytearray) -> bytes:
    place = rng.randrange(len(content))
    content[place:place] = rng.randbytes(rng.randint(1, 500))
    return content


def _overwrite(rng: random.Random, content: bytearray) -> bytes:
    """A stretch of noise, and the length of the file kept."""
    place, length = rng.randrange(len(content)), rng.randint(1, 3000)
    length = min(length, len(content) - place)
    content[place : place + length] = rng.randbytes(length)
    return content


def _relength(rng: random.Random, content: bytearray) -> bytes:
    """A number of four bytes that is far too large or small."""
    for _ in range(rng.randint(1, 4)):
        place = rng.randrange(len(content) - 4)
        content[place : place + 4] = rng.choice(_LENGTHS)
    return content


def _renumber(rng: random.Random, content: bytearray) -> bytes:
    """Digits of a number in text, and the length of the file kept."""
    found = list(re.finditer(rb"(?<==)-?[0-9.]+", content))
    for match in rng.sample(found, min(3, len(found))):
        length = match.end() - match.start()
        content[match.start() : match.end()] = rng.choice(_NUMBERS)[:length].ljust(length, b"0")
    return content


def _retext(rng: random.Random, content: bytearray) -> bytes:
    """Letters of a name."""
    found = list(re.finditer(rb"[A-Za-z_/]{4,}", content))
    for match in rng.sample(found, min(3, len(found))):
        content[rng.randrange(match.start(), match.end())] = rng.randrange(256)
    return content


_BYTES = {
    "bits": _flip, "cut": _cut, "inserted": _insert, "overwritten": _overwrite,
    "lengths": _relength, "numbers": _renumber, "names": _retext,
}  # fmt: skip


def _change(path: Path, change: Callable[[sqlite3.Connection], object]) -> None:
    with closing(sqlite3.connect(path)) as database, database:
        change(database)


def _spoil_data(rng: random.Random, database: sqlite3.Connection, kind: str) -> None:
    rows = database.execute("SELECT id, data FROM messages").fetchall()
    for identity, data in rng.sample(rows, rng.choice((1, 1, 3, 10))):
        spoilt = _BYTES[kind](rng, bytearray(data)) if len(data) > 4 else b""
        database.execute(_REPLACE, (bytes(spoilt), identity))


def _text_numbers(rng: random.Random, database: sqlite3.Connection) -> None:
    """A number in a description or in metadata, of any length."""
    rows = database.execute("SELECT id, data FROM messages WHERE instr(data, x'3d')").fetchall()
    identity, data = rng.choice([row for row in rows if len(row[1]) < 500])
    fields = data[8:].rstrip(b"\0").split(b";")
    place = rng.randrange(len(fields))
    fields[place] = fields[place].partition(b"=")[0] + b"=" + rng.choice(_NUMBERS)
    text = b";".join(fields) + b"\0"
    database.execute(_REPLACE, (data[:4] + struct.pack("<I", len(text)) + text, identity))


def _move(rng: random.Random, database: sqlite3.Connection) -> None:
    """Messages of another topic or time."""
    (count,) = database.execute("SELECT MAX(id) FROM messages").fetchone()
    for _ in range(rng.randint(1, 3)):
        row = rng.randrange(1, 40), rng.choice(_TIMES), rng.randint(1, count)
        database.execute("UPDATE messages SET topic_id = ?, timestamp = ? WHERE id = ?", row)


def _rename(rng: random.Random, database: sqlite3.Connection) -> None:
    row = rng.choice(_WORDS), rng.choice(_OTHERS), rng.randrange(1, 39)
    database.execute("UPDATE topics SET name = replace(name, ?, ?) WHERE id = ?", row)


def _drop(rng: random.Random, database: sqlite3.Connection) -> None:
    database.execute("DELETE FROM messages WHERE topic_id = ?", (rng.randrange(1, 39),))


def _retype(rng: random.Random, database: sqlite3.Connection) -> None:
    row = rng.choice(_TYPES), rng.randrange(1, 39)
    database.execute("UPDATE topics SET type = ? WHERE id = ?", row)


_MESSAGES: dict[str, Callable] = {
    **{f"data, {kind}": partial(_spoil_data, kind=kind) for kind in _BYTES if kind != "numbers"},
    "numbers": _text_numbers, "moved": _move, "renamed": _rename, "dropped": _drop,
    "of another type": _retype,
}  # fmt: skip


def black_png(width: int, height: int, bits: int, channels: int, level: int) -> bytes:
    """A black image, grey or of three channels, whose pixels take far more room than the file."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        checksum = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + checksum

    packed, row = zlib.compressobj(level), bytes(1 + channels * bits // 8 * width)
    pixels = b"".join(packed.compress(row) for _ in range(height)) + packed.flush()
    header = struct.pack(">IIBBBBB", width, height, bits, channels - 1, 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


def _bomb(image: bytes) -> Callable[[sqlite3.Connection], None]:
    """Puts an image in the place of every depth image."""

    def change(database: sqlite3.Connection) -> None:
        rows = database.execute(
            "SELECT id, data FROM messages WHERE topic_id IN"
            " (SELECT id FROM topics WHERE name LIKE '%compressedDepth')"
        ).fetchall()
        for identity, data in rows:
            start = data.index(b"\x89PNG")
            message = data[: start - 4] + struct.pack("<I", len(image)) + image
            database.execute(_REPLACE, (message, identity))

    return change
