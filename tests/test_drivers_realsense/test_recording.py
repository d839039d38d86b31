"""What is told about a recording before the SDK opens it."""

import os
import sqlite3
from contextlib import closing

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.realsense.recording_check import check_header, check_topics
from drivers.tum_sequence import RecordedSequence
from vizbot.core.errors import ConfigError

TOPICS = (
    "/file_version",
    "/device_0/info",
    "/device_0/sensor_0/Depth_0/image/data/compressedDepth",
    "/device_0/sensor_1/Color_0/image/data/compressed",
)


def write_db3(path, topics=TOPICS, messages=TOPICS):
    path.unlink(missing_ok=True)
    with closing(sqlite3.connect(path)) as database, database:
        database.execute("CREATE TABLE topics (id INTEGER PRIMARY KEY, name TEXT)")
        database.execute("CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INT, data BLOB)")
        for topic_id, topic in enumerate(topics):
            database.execute("INSERT INTO topics VALUES (?, ?)", (topic_id, topic))
            if topic in messages:
                row = (topic_id, bytes(9000))
                database.execute("INSERT INTO messages (topic_id, data) VALUES (?, ?)", row)
    return path


def write_bag(path, index_pos, size=1000):
    header = b"#ROSBAG V2.0\n\x45\0\0\0\x12\0\0\0index_pos=" + index_pos.to_bytes(8, "little")
    path.write_bytes(header + bytes(size - len(header)))
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("recording")


@pytest.fixture(scope="module")
def whole(folder):
    return write_db3(folder / "whole.db3").read_bytes()


def check_recording(path):
    check_header(path)
    check_topics(path)


def refusal(path):
    with pytest.raises(ConfigError) as error:
        check_recording(path)
    assert "\n" not in str(error.value)
    assert str(path) in str(error.value)
    return str(error.value)


def test_whole_recordings_pass(tmp_path):
    check_recording(write_db3(tmp_path / "home.db3"))
    check_recording(write_db3(tmp_path / "what? 100%.DB3"))
    check_recording(write_bag(tmp_path / "home.bag", 900))


def test_checking_writes_nothing(tmp_path):
    path = write_db3(tmp_path / "home.db3")
    before = path.read_bytes()
    check_recording(path)
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == before


@given(st.floats(0, 1, exclude_max=True))
def test_a_database_cut_anywhere_is_refused(folder, whole, fraction):
    path = folder / "cut.db3"
    path.write_bytes(whole[: int(fraction * len(whole))])
    refusal(path)


@given(st.binary(max_size=300))
def test_other_bytes_are_no_database(folder, content):
    path = folder / "other.db3"
    path.write_bytes(content)
    assert "not a rosbag2 database" in refusal(path)


@pytest.mark.parametrize("topic", TOPICS)
def test_a_database_without_a_topic_or_its_messages_is_refused(tmp_path, topic):
    others = [name for name in TOPICS if name != topic]
    refusal(write_db3(tmp_path / "home.db3", topics=others))
    refusal(write_db3(tmp_path / "home.db3", messages=others))


def test_a_database_of_something_else_is_refused(tmp_path):
    path = tmp_path / "music.db3"
    with closing(sqlite3.connect(path)) as database, database:
        database.execute("CREATE TABLE songs (id INTEGER PRIMARY KEY)")
    assert "no such table: topics" in refusal(path)


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    assert "No such file" in refusal(tmp_path / "none.db3")
    (tmp_path / "folder.bag").mkdir()
    assert "not a file; give a recording" in refusal(tmp_path / "folder.bag")


def test_a_pipe_is_refused_without_waiting_for_its_other_end(tmp_path):
    os.mkfifo(tmp_path / "home.db3")
    assert "not a file; give a recording" in refusal(tmp_path / "home.db3")


def test_a_database_whose_words_are_no_text_is_refused(tmp_path):
    path = write_db3(tmp_path / "home.db3")
    content = path.read_bytes()
    spoilt = content.replace(b"CREATE TABLE topics (id", b"CREATE TABLE topics \xf5\xf5\xf5")
    assert spoilt != content
    path.write_bytes(spoilt)
    assert "not a readable rosbag2 database" in refusal(path)


def test_another_kind_of_file_is_refused(tmp_path):
    assert "not a .db3 or .bag" in refusal(tmp_path / "home.mp4")


@pytest.mark.parametrize(
    ("index_pos", "size", "why"),
    [(0, 1000, "not stopped properly"), (5000, 1000, "cut short"), (1000, 1000, "cut short")],
)
def test_a_bag_without_its_index_is_refused(tmp_path, index_pos, size, why):
    assert why in refusal(write_bag(tmp_path / "home.bag", index_pos, size))


def test_a_bag_cut_in_its_header_is_refused(tmp_path):
    path = tmp_path / "home.bag"
    path.write_bytes(b"#ROSBAG V2.0\n\x45\0\0\0")
    assert "cut short in its header" in refusal(path)
    path.write_bytes(b"#ROSBAG V1.2\n")
    assert "not a rosbag of version 2.0" in refusal(path)


def test_a_bag_of_ros_2_is_called_one(tmp_path):
    topics = ("/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw")
    path = write_db3(tmp_path / "bag_0.db3", topics, topics)
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information:\n")
    assert "a ROS 2 bag, which is not read" in refusal(path)
    for other in (tmp_path, tmp_path / "bag.mcap"):
        with pytest.raises(ConfigError, match=r"a ROS 2 bag.*; write its images as"):
            RecordedSequence(other)
