"""The way of one camera frame through pose estimation and mapping, from file to file.

    python -m tests.tools.frame_way

A robot with wheels and a gyroscope drives through the box room. Every function of Python that a
frame enters below `mapping` and `vizbot/perception`, from `Perception.update` on, is noted. A step
is a change from one file to another, a return a step into a file that the frame was in before.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any

from sim_stubs.clock import SimulatedClock
from tests.helpers.box_room import T_BASE_CAM, dead_reckoning, lap, render, turns, with_gyro
from tests.helpers.checkout import ROOT
from vizbot.config import PerceptionConfig
from vizbot.operator.printing import echo
from vizbot.perception.perception import Perception

BELOW = tuple(f"{ROOT / folder}/" for folder in ("mapping", "vizbot/perception"))
STANDING, FRAMES, SETTLED = 8, 30, 20
"""Frames at rest, by which the gyroscope's bias is learned; all; the first one that counts."""


def way_of(call: Callable[[], Any]) -> tuple[Any, list[str]]:
    """What a call returns, and the files that it comes through, none twice in a row."""
    files: list[str] = []

    def note(frame: FrameType, event: str, _: object) -> None:
        name = frame.f_code.co_filename
        if event == "call" and name.startswith(BELOW) and files[-1:] != [name]:
            files.append(name)

    sys.setprofile(note)
    try:
        result = call()
    finally:
        sys.setprofile(None)
    return result, [str(Path(name).relative_to(ROOT)) for name in files]


def counts(files: Sequence[str]) -> tuple[int, int]:
    """Steps and returns of a way."""
    return len(files) - 1, len(files) - len(set(files))


def ways() -> tuple[list[str], list[str]]:
    """The ways of the first plain frame and of the first keyframe that count."""
    path = [lap(100)[0]] * STANDING + lap(100)[: FRAMES - STANDING]
    wheels, turned = dead_reckoning(path), turns(path)
    frames = [with_gyro(render(T, 0.2 * i), turned[i]) for i, T in enumerate(path)]
    encoder: Any = SimpleNamespace(dimension=1)  # no frame is embedded
    perception = Perception(frames[0], T_BASE_CAM, encoder, SimulatedClock(), PerceptionConfig())
    found: dict[bool, list[str]] = {}
    for i, (frame, T_odom_base) in enumerate(zip(frames, wheels, strict=True)):
        estimate, files = way_of(lambda: perception.update(frame, T_odom_base))  # noqa: B023
        if i >= SETTLED:
            found.setdefault(estimate.is_keyframe, files)
    return found[False], found[True]


def main() -> None:
    """Print steps and returns of both, and the files of the longer way."""
    plain, keyframe = ways()
    for kind, files in (("plain frame", plain), ("with a keyframe", keyframe)):
        steps, returns = counts(files)
        echo(f"{kind}: {steps} steps, {returns} returns")
    echo("\n".join(keyframe))


if __name__ == "__main__":
    main()
