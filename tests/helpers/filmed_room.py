"""A software D435i that films a room: `python -m tests.helpers.filmed_room ARGUMENTS` launches.

That is `vizbot launch --force ARGUMENTS` with this camera plugged in, for a robot that stands.
"""

import sys
from contextlib import contextmanager

import cv2
import numpy as np

from drivers.realsense.sdk import rs
from sim_stubs.realsense.software_device import COLOR, SoftwareD435i
from sim_stubs.world.body import FreeFloor
from tests.helpers.beside import beside
from vizbot.cli.standard_error import lose_what_cannot_be_written
from vizbot.core.geometry import yaw_of

LAUNCH = ("-m", "tests.helpers.filmed_room", "--port", "0", "--out", "run")
"""What Python is given to launch such a robot, but for its settings."""
RATE = 15
"""Frames a second."""


@contextmanager
def filmed(camera, floor):
    """Push what a robot sees that stands in the middle of a round room full of paper snippets."""
    rng = np.random.default_rng(0)
    around = round(2 * np.pi * COLOR.fx)
    snippets = rng.integers(0, 255, (COLOR.height // 20, around // 20, 3), np.uint8)
    wall = cv2.resize(snippets, (around, COLOR.height), interpolation=cv2.INTER_NEAREST)
    depth = np.full((COLOR.height, COLOR.width), 2000, np.uint16)

    def film(over):
        number = 0
        while not over.wait(1 / RATE):
            left = round(-yaw_of(floor.T_world_base) * COLOR.fx)
            seen = np.take(wall, range(left, left + COLOR.width), axis=1, mode="wrap")
            camera.push_frame(np.ascontiguousarray(seen), depth, 1.7e9 + number / RATE)
            number += 1

    with beside(film):
        yield


def settings(base_path):
    """Settings of a robot with this camera and a base at a path.

    A simulated base whose threads this machine keeps from running for a moment is no silent one.
    """
    devices = f"[realsense]\nimu = false\nfps = {RATE}\n[roomba]\nsilence_timeout = 0.5\n"
    return f'serial_port = "{base_path}"\n{devices}'


def main(*arguments):
    from vizbot.cli import app as cli

    lose_what_cannot_be_written()  # before anything is opened, as the command itself does it
    camera = SoftwareD435i(fps=RATE)
    context = camera.plug_in()
    rs.context = lambda: context
    sys.argv = ["vizbot", "launch", "--force", "--clip", "embedded", *arguments]
    with filmed(camera, FreeFloor()):
        cli.main()


if __name__ == "__main__":
    main(*sys.argv[1:])
