"""Frames that a software D435i is made to give."""

import os
import subprocess
import sys
from contextlib import contextmanager

import numpy as np

from drivers.realsense.camera import RealSense
from drivers.realsense.config import RealSenseConfig
from tests.helpers.beside import beside
from tests.helpers.checkout import ROOT
from vizbot.core.simulated_clock import SimulatedClock

SERIAL = "900000000001"
START = 1_700_000_000.0
FRAMES = 60
ANY = RealSenseConfig()
LIVE = RealSenseConfig(serial=SERIAL, first_frame_timeout=2.0)
R_QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def stamp_of(index):
    return START + index / 30


def colour(index):
    rows, columns = np.mgrid[:480, :640]
    image = np.stack([columns, rows, columns + rows], axis=-1) + 3 * index
    return image.astype(np.uint8)


def depth_mm(index):
    """A wall at 2 m, a box at 1 m that moves, a patch where nothing was measured."""
    image = np.full((480, 640), 2000, np.uint16)
    image[150:330, 200 + index : 340 + index] = 1000
    image[60:90, 60:90] = 0
    return image


def push_frames(device, indices):
    """Frames, and IMU samples from 10 ms before the first to the last."""
    first = stamp_of(indices[0]) - 0.01
    motions = [(first + n / 200, n, device.push_gyro) for n in range(2 + 200 * len(indices) // 30)]
    motions += [(first + n / 100, n, device.push_accel) for n in range(100 * len(indices) // 30)]
    motions.sort(key=lambda motion: motion[0])
    for index in indices:
        while motions and motions[0][0] <= stamp_of(index):
            stamp, n, push = motions.pop(0)
            push((float(n), 1.0, 2.0), stamp)
        device.push_frame(colour(index), depth_mm(index), stamp_of(index))


def read_all(camera):
    frames = []
    while (frame := camera.read(timeout=5.0)) is not None:
        frames.append(frame)
    return frames


def in_another_process(code):
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env=environment,
        timeout=60,
        check=False,
    )


@contextmanager
def opened(device, **settings):
    """A live `RealSense` on a software camera, its clock, which only tests advance, and context."""
    clock, context = SimulatedClock(), device.plug_in()
    config = RealSenseConfig(**({"serial": SERIAL, "first_frame_timeout": 2.0} | settings))
    with RealSense(config, clock, context) as camera:
        yield camera, clock, context


@contextmanager
def streaming(device):
    """A software camera gives frames at its rate, in a thread of its own."""

    def stream(ended):
        number = 0
        while not ended.wait(1 / 30):
            rgb = np.full((480, 640, 3), number % 256, np.uint8)
            device.push_frame(rgb, np.full((480, 640), 1500, np.uint16), 1.7e9 + number / 30)
            number += 1

    with beside(stream):
        yield
