"""Read spoilt recordings of a RealSense as the program does; `python -m` in a process apart."""

import itertools
import shutil
import sys
from functools import partial
from pathlib import Path

import numpy as np

from drivers.realsense.playback import RealSenseRecording
from sim_stubs.realsense.software_device import SoftwareD435i
from tests.fuzz.bags import write_recording
from tests.fuzz.spoilt_recordings import harmful_databases, spoilt_bytes, spoilt_messages
from tests.fuzz.trial import try_one
from tests.helpers.d435i_frames import ANY, stamp_of
from vizbot.core.types import Intrinsics

FRAMES, CAMERA = 6, Intrinsics(64, 48, 61.0, 61.0, 32.0, 24.0)


def frames():
    """(stamp [s], RGB, depth [mm]) of each."""
    rng = np.random.default_rng(0)
    for number in range(FRAMES):
        rgb = rng.integers(0, 255, (CAMERA.height, CAMERA.width, 3)).astype(np.uint8)
        depth = np.full((CAMERA.height, CAMERA.width), 1500, np.uint16)
        yield stamp_of(number), rgb, depth


def write_db3(path):
    device = SoftwareD435i(color=CAMERA)
    with device.record(path):
        for stamp, rgb, depth in frames():
            device.push_gyro((0.1, 0.2, 0.3), stamp - 0.005)
            device.push_accel((0.0, 0.0, 9.8), stamp - 0.004)
            device.push_frame(rgb, depth, stamp)


def write_bag(path):
    write_recording(path, list(frames()))


def require_valid(frame, intrinsics):
    """Check what every part of the program relies on."""
    size = intrinsics.height, intrinsics.width
    assert frame.intrinsics == intrinsics
    assert frame.rgb.shape == (*size, 3) and frame.rgb.dtype == np.uint8, frame.rgb.shape
    assert frame.depth.shape == size and frame.depth.dtype == np.float32, frame.depth.shape
    assert np.isfinite(frame.stamp), frame.stamp
    assert np.isfinite(frame.depth).all() and (frame.depth >= 0.0).all()
    for samples in (frame.imu.gyro, frame.imu.accel, frame.imu.gyro_stamps, frame.imu.accel_stamps):
        assert np.isfinite(samples).all(), samples


def read(path):
    with RealSenseRecording(ANY, path) as camera:
        k = camera.intrinsics
        assert np.isfinite([k.fx, k.fy, k.cx, k.cy]).all() and min(k.fx, k.fy) > 0.0, k
        stamps = []
        while (frame := camera.read()) is not None:
            require_valid(frame, k)
            stamps.append(frame.stamp)
        assert (np.diff(stamps) > 0.0).all(), stamps


def tries(kind, seed, count):
    """Ways to spoil a recording of a kind, in the order of the trials."""
    if kind == "bag":
        return spoilt_bytes("bag", seed, count)
    messages = spoilt_messages(seed, count // 2)
    return itertools.chain(messages, spoilt_bytes("db3", seed, count - count // 2))


def main(work, kind, seed, count):
    """Try spoilt recordings.

    Args:
        work: An empty folder.
        kind: `db3`, `bag`, or `harmful` for databases that are made to harm.
        seed: What they are drawn from.
        count: How many are drawn.
    """
    ending, write = (".bag", write_bag) if kind == "bag" else (".db3", write_db3)
    good, path = work / f"good{ending}", work / f"spoilt{ending}"
    write(good)
    read(good)
    for spoilt in harmful_databases() if kind == "harmful" else tries(kind, seed, count):
        shutil.copyfile(good, path)
        spoilt.spoil(path)
        try_one(spoilt, partial(read, path))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
