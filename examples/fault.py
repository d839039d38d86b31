"""Rehearse a fault of your own: a lens that is half covered from some moment on.

Needs the simulator (the extra `sim`):

    python examples/fault.py "yellow chair" --world 0 --after 10
"""

import argparse
from dataclasses import replace

from vizbot import Config, open_encoder
from vizbot.core.interfaces import Camera, Clock
from vizbot.core.types import RGBDFrame
from vizbot.mission import drive_to_all
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.rig import Rig


class CoveredLens:
    """A camera whose left half is black and measures no depth, from `start` [s] on."""

    def __init__(self, camera: Camera, clock: Clock, start: float) -> None:
        self.camera, self.clock, self.start = camera, clock, start
        self.intrinsics = camera.intrinsics

    def read(self, timeout: float = 1.0) -> RGBDFrame | None:
        """The next frame, half of it covered."""
        frame = self.camera.read(timeout)
        if frame is None or self.clock.now() < self.start:
            return frame
        rgb, depth = frame.rgb.copy(), frame.depth.copy()
        half = rgb.shape[1] // 2
        rgb[:, :half], depth[:, :half] = 0, 0.0
        return replace(frame, rgb=rgb, depth=depth)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("goal", help="what to go to, in words")
    parser.add_argument("--world", default="0", help="as for `vizbot dry-run`")
    parser.add_argument("--after", type=float, default=10.0, help="seconds until it is covered")
    parser.add_argument("--steps", type=int, default=1000, help="at most")
    arguments = parser.parse_args()

    config = Config()
    encoder = open_encoder(config.clip, config.device, config.half)
    with Rig(config, "sim", "sim", arguments.world, first_goal=arguments.goal) as rig:
        clock = rig.devices.clock
        lens = CoveredLens(rig.devices.camera, clock, clock.now() + arguments.after)
        devices = replace(rig.devices, camera=lens)
        pipeline = Pipeline(devices, encoder, config, [])
        goal = pipeline.goal(arguments.goal)
        (report,) = drive_to_all(pipeline, devices, [goal], arguments.steps)
        print(f"{report.text}: {report.outcome} ({report.reason})")


if __name__ == "__main__":
    main()
