"""The SDK reads recordings in a process of its own, which may crash or hang."""

import signal
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.realsense import playback
from drivers.realsense.playback import RealSenseRecording
from sim_stubs.realsense.software_device import SoftwareD435i
from tests.fuzz.bags import write_recording
from tests.helpers.checkout import ROOT
from tests.helpers.d435i_frames import ANY, START, colour, depth_mm, read_all, stamp_of
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.core.types import Intrinsics

ENDS = """
import os, sys
from multiprocessing.connection import Connection
from vizbot.core.types import Intrinsics
connection = Connection(int(sys.argv[1]))
connection.recv()
for _ in range({opened}):
    connection.send(([], Intrinsics(64, 48, 60.0, 60.0, 32.0, 24.0)))
    connection.recv()
os.kill(os.getpid(), {signal})
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("process") / "home.db3"
    device = SoftwareD435i()
    with device.record(path):
        for index in range(4):
            stamp = stamp_of(index)
            device.push_depth(depth_mm(index), stamp + 0.03 * (index == 2))
            device.push_color(colour(index), stamp)
    return path


@pytest.mark.parametrize(("key", "value"), [("fx", 1e7), ("fy", 1e-30), ("cx", 1e30)])
def test_a_calibration_that_no_camera_has_is_refused_with_its_value(tmp_path, key, value):
    path, camera = tmp_path / "home.db3", Intrinsics(64, 48, 61.0, 61.0, 32.0, 24.0)
    device = SoftwareD435i(color=replace(camera, **{key: value}))
    with device.record(path):
        device.push_frame(np.zeros((48, 64, 3), np.uint8), np.ones((48, 64), np.uint16), START)
    with pytest.raises(ConfigError, match=rf"{key} \[px\] is {value:g}".replace("+", r"\+")):
        RealSenseRecording(ANY, path)


def children():
    """Processes that this one has begun."""
    found = Path("/proc/self/task").glob("*/children")
    return {child for file in found for child in file.read_text().split()}


@pytest.mark.parametrize(
    ("ending", "why"), [(signal.SIGSEGV, "it ends the SDK"), (signal.SIGALRM, "it takes too long")]
)
def test_a_reader_that_crashes_or_hangs_is_one_line(recording, monkeypatch, ending, why):
    monkeypatch.setenv("PYTHONPATH", str(ROOT))

    def end(opened):
        program = ENDS.format(opened=opened, signal=int(ending))
        monkeypatch.setattr(
            playback, "interpreter_command", lambda _, end: [sys.executable, "-c", program, end]
        )

    end(opened=0)
    with pytest.raises(ConfigError, match=rf"home\.db3: cannot be played \({why}\); record"):
        RealSenseRecording(ANY, recording)
    end(opened=1)
    with RealSenseRecording(ANY, recording) as camera:
        for _ in range(2):
            with pytest.raises(DeviceError, match=rf"home\.db3: cannot be read \({why}\); copy"):
                camera.read()


def test_a_closed_recording_leaves_no_process(recording):
    before = children()
    with RealSenseRecording(ANY, recording) as camera:
        assert camera.read() is not None
        assert len(children() - before) == 1
    assert children() <= before


def test_what_is_warned_of_in_that_process_is_logged_here(recording, caplog):
    with RealSenseRecording(ANY, recording) as camera:
        frames = read_all(camera)
    assert len(frames) < 4
    assert "colour and depth are 33 ms apart" in caplog.text


def test_a_bag_is_read_as_a_database_is(tmp_path):
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (3, 48, 64, 3)).astype(np.uint8)
    depth = rng.integers(0, 5000, (3, 48, 64)).astype(np.uint16)
    taken = [(stamp_of(n), rgb[n], depth[n]) for n in range(3)]
    write_recording(tmp_path / "walk.bag", taken)
    with RealSenseRecording(ANY, tmp_path / "walk.bag") as camera:
        frames = read_all(camera)
    assert [frame.stamp - START for frame in frames] == pytest.approx([0, 1 / 30, 2 / 30], abs=1e-6)
    for number, frame in enumerate(frames):
        np.testing.assert_array_equal(frame.rgb, rgb[number])
        np.testing.assert_allclose(frame.depth, depth[number] / 1000.0, atol=1e-5)
        np.testing.assert_allclose(frame.imu.gyro, [[0.1, 0.2, 0.3]], atol=1e-6)
        np.testing.assert_allclose(frame.imu.accel, [[0.0, 0.0, 9.8]], atol=1e-6)
