"""The way of one camera frame through pose estimation and mapping, from file to file.

    python -m tests.tools.frame_way

A robot with wheels and a gyroscope drives through the box room. Every function of Python that a
frame enters below `mapping` and `vizbot/perception`, from `Perception.update` on, is noted. A step
is a change from one file to another, a return a step into a file that the frame was in before.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any

import numpy as np

from sim_stubs.clock import SimulatedClock
from tests.helpers.box_room import T_BASE_CAM, dead_reckoning, lap, render
from tests.helpers.checkout import ROOT
from vizbot.config import PerceptionConfig
from vizbot.core.geometry import invert, yaw_of
from vizbot.core.types import SE3, ImuSamples, RGBDFrame
from vizbot.operator.printing import echo
from vizbot.perception.perception import Perception

FOLDERS = ("mapping", "vizbot/perception")
STANDING, FRAMES, SETTLED = 8, 30, 20
"""Frames at rest, by which the gyroscope's bias is learned; all; the first one that counts."""


@dataclass(frozen=True, slots=True)
class Way:
    """The files that a frame came through, one after another, none twice in a row."""

    files: tuple[str, ...]

    @property
    def steps(self) -> int:
        """Changes from one file to another."""
        return len(self.files) - 1

    @property
    def returns(self) -> int:
        """Steps into a file that the frame was in before."""
        return len(self.files) - len(set(self.files))


def way_of(call: Callable[[], Any], folders: tuple[str, ...] = FOLDERS) -> tuple[Any, Way]:
    """What a call returns, and its way through the files below some folders of the checkout."""
    below = tuple(f"{ROOT / folder}/" for folder in folders)
    files: list[str] = []

    def note(frame: FrameType, event: str, _: object) -> None:
        name = frame.f_code.co_filename
        if event == "call" and name.startswith(below) and files[-1:] != [name]:
            files.append(name)

    sys.setprofile(note)
    try:
        result = call()
    finally:
        sys.setprofile(None)
    return result, Way(tuple(str(Path(name).relative_to(ROOT)) for name in files))


def turning(frame: RGBDFrame, T_before_now: SE3) -> RGBDFrame:
    """The frame with what a gyroscope reads in the 0.2 s of a motion before it."""
    stamps = frame.stamp - 0.2 + np.arange(1, 41) * 0.005
    rates = np.tile(yaw_of(T_before_now) / 0.2 * T_BASE_CAM[2, :3], (40, 1))
    return replace(frame, imu=ImuSamples(stamps, rates, np.zeros(0), np.zeros((0, 3))))


def ways() -> tuple[Way, Way]:
    """The ways of the first plain frame and of the first keyframe that count."""
    path = [lap(100)[0]] * STANDING + lap(100)[: FRAMES - STANDING]
    wheels, steps = dead_reckoning(path), [invert(a) @ b for a, b in pairwise([path[0], *path])]
    encoder: Any = SimpleNamespace(dimension=1)  # no frame is embedded
    perception: Perception | None = None
    found: dict[bool, Way] = {}
    for i, (T_map_base, T_odom_base, step) in enumerate(zip(path, wheels, steps, strict=True)):
        frame = turning(render(T_map_base, 0.2 * i), step)
        if perception is None:
            clock, config = SimulatedClock(), PerceptionConfig()
            perception = Perception(frame, T_BASE_CAM, encoder, clock, config)
        update = perception.update
        estimate, way = way_of(lambda: update(frame, T_odom_base))  # noqa: B023
        if i >= SETTLED:
            found.setdefault(estimate.is_keyframe, way)
    return found[False], found[True]


def main() -> None:
    """Print steps and returns of both, and the files of the longer way."""
    plain, keyframe = ways()
    echo(f"plain frame: {plain.steps} steps, {plain.returns} returns")
    echo(f"with a keyframe: {keyframe.steps} steps, {keyframe.returns} returns")
    echo("\n".join(keyframe.files))


if __name__ == "__main__":
    main()
