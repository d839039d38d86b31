"""`vizbot stub realsense`: a recording that plays in vizbot and in any RealSense program."""

import itertools
import sqlite3
import time
from contextlib import closing

import numpy as np
import pytest
from typer.testing import CliRunner

from drivers.realsense.config import RealSenseConfig
from drivers.realsense.playback import RealSenseRecording
from drivers.realsense.sdk import rs
from sim_stubs.realsense.config import SimulatedRealSenseConfig
from sim_stubs.realsense.footage import record_footage
from sim_stubs.realsense.software_device import SoftwareD435i, require_all
from sim_stubs.world.body import WorldConfig
from sim_stubs.world.world_name import open_world
from sim_stubs.world.world_plan import D435I_COLOUR
from tests.helpers.d435i_frames import push_frames
from tests.helpers.failing import raising
from vizbot.cli import app as cli
from vizbot.core.errors import ConfigError

SECONDS, REST, WHEEL_BASE = 1.2, 0.8, 0.235
WORLD = """
<mujoco>
  <worldbody>
    <geom type="plane" size="0 0 1" rgba="0.5 0.4 0.3 1"/>
    <geom type="box" size="0.1 3 1.2" pos="3 0 1.2" rgba="0.2 0.6 0.2 1"/>
    <geom type="box" size="3 0.1 1.2" pos="0 3 1.2" rgba="0.4 0.5 0.6 1"/>
    <light pos="1 1 2.2" type="spot"/>
    <site name="start" pos="0 0 0"/>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    path = tmp_path_factory.mktemp("world") / "corner.xml"
    path.write_text(WORLD)
    return path


@pytest.fixture(scope="module")
def frames(tmp_path_factory, world):
    path = tmp_path_factory.mktemp("footage") / "corner.db3"
    with open_world(str(world), WorldConfig()) as corner:
        record_footage(corner, WHEEL_BASE, SimulatedRealSenseConfig(), path, SECONDS, REST)
    with RealSenseRecording(RealSenseConfig(), path) as player:
        return list(iter(player.read, None))


@pytest.mark.slow
def test_the_simulated_camera_is_recorded_at_its_full_rates(frames):
    assert len(frames) == round(30 * SECONDS)
    stamps = [frame.stamp for frame in frames]
    np.testing.assert_allclose(np.diff(stamps), 1 / 30, atol=1e-5)
    for before, frame in itertools.pairwise(frames):
        assert before.stamp < frame.imu.gyro_stamps[0] and frame.imu.gyro_stamps[-1] <= frame.stamp
    assert sum(len(frame.imu.gyro) for frame in frames) == pytest.approx(200 * SECONDS, abs=2)
    assert sum(len(frame.imu.accel) for frame in frames) == pytest.approx(100 * SECONDS, abs=2)
    assert frames[0].intrinsics == D435I_COLOUR


@pytest.mark.slow
def test_the_robot_rests_and_then_turns_where_it_stands(frames):
    rest = np.concatenate([frame.imu.gyro for frame in frames[:20]]).mean(axis=0)
    turning = np.concatenate([frame.imu.gyro for frame in frames[-6:]]).mean(axis=0) - rest
    assert np.linalg.norm(rest) < 0.03
    assert turning[1] == pytest.approx(-0.5, abs=0.05)  # to the left, about the camera's y
    assert 0.3 < np.median(frames[-1].depth) < 8.0


@pytest.mark.slow
def test_the_command_says_where_the_recording_is(tmp_path, world):
    path = tmp_path / "corner.db3"
    asked = ["--world", str(world), "--out", str(path), "--seconds", "0.1"]
    told = CliRunner().invoke(cli.app, ["stub", "realsense", *asked])
    assert told.exit_code == 0, told.output
    assert told.stdout.strip() == str(path) and "3 frames" in told.stderr
    with RealSenseRecording(RealSenseConfig(), path) as player:
        assert len(list(iter(player.read, None))) == 3


@pytest.mark.alone
def test_any_realsense_program_plays_it_at_its_own_pace(tmp_path):
    path = tmp_path / "quick.db3"
    device = SoftwareD435i()
    with device.record(path):
        push_frames(device, range(20))
    pipeline, wanted = rs.pipeline(rs.context()), rs.config()
    wanted.enable_device_from_file(str(path), repeat_playback=False)
    pipeline.start(wanted)
    pipeline.wait_for_frames()
    began = time.monotonic()
    played = 0
    while pipeline.try_wait_for_frames(500)[0]:
        played, ended = played + 1, time.monotonic()
    pipeline.stop()
    assert played > 5
    assert ended - began == pytest.approx(19 / 30, abs=0.4)


@pytest.mark.parametrize("step", ["add_imu_extrinsics", "set_pace"])
def test_a_full_disk_is_one_line_and_leaves_nothing(tmp_path, monkeypatch, step):
    monkeypatch.setattr(
        f"sim_stubs.realsense.software_device.{step}",
        raising(sqlite3.OperationalError("database or disk is full")),
    )
    device = SoftwareD435i()
    with (
        pytest.raises(ConfigError, match=r"walk\.db3: database or disk is full; make room"),
        device.record(tmp_path / "walk.db3"),
    ):
        push_frames(device, range(2))
    assert list(tmp_path.iterdir()) == []


def test_a_recording_that_cannot_begin_is_one_line(tmp_path):
    device = SoftwareD435i()
    with (
        pytest.raises(ConfigError, match=r"cannot write .*walk\.db3: "),
        device.record(tmp_path / "nowhere" / "walk.db3"),
    ):
        pytest.fail("it is recorded")


def test_a_recording_that_lacks_images_is_refused(tmp_path):
    path, device = tmp_path / "walk.db3", SoftwareD435i()
    with device.record(path):
        push_frames(device, range(2))
    with closing(sqlite3.connect(path)) as database:
        found = database.execute("SELECT name FROM topics JOIN messages ON topics.id = topic_id")
        count = sum(name.endswith("/imu/data") or "/image/data/" in name for (name,) in found)
    assert count > 4
    require_all(path, count)
    with pytest.raises(sqlite3.OperationalError, match=f"1 of {count + 1} .* lost"):
        require_all(path, count + 1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--out", "home.bag"], r"home\.bag: the SDK records \.db3"),
        (["--out", "nowhere/home.db3"], "folder is not there"),
        (["--out", "home.db3", "--seconds", "0"], "--seconds 0"),
        (["--out", "home.db3", "--seconds", "nan"], "--seconds nan"),
        (["--out", "home.db3", "--seconds", "inf"], "--seconds inf"),
        (["--out", "there.db3"], "is there already"),
    ],
)
def test_what_cannot_be_written_is_refused_at_once(tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.db3").touch()
    with pytest.raises(ConfigError, match=message):
        cli.app(["stub", "realsense", *arguments], standalone_mode=False)
    assert [path.name for path in tmp_path.iterdir()] == ["there.db3"]
