"""Watch a run with an observer of your own: print what the robot does when that changes.

Needs the simulator (the extra `sim`):

    python examples/observer.py "yellow chair" --world 0
"""

import argparse

from vizbot import Config, GoalReport, Step, open_encoder
from vizbot.mission import drive_to_all
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.rig import Rig


class Narrator:
    """An `Observer`: any class with these two methods."""

    def __init__(self) -> None:
        self.activity = ""

    def on_step(self, step: Step) -> None:
        """Every step of the run; it must not change what it gets."""
        if step.activity != self.activity:
            self.activity = step.activity
            x, y = step.T_map_base[:2, 3]
            best = step.best_score or 0.0
            print(
                f"{step.index:4} at {x:5.2f} {y:5.2f} m, {step.measure} {best:.2f}: {self.activity}"
            )

    def on_goal(self, report: GoalReport) -> None:
        """The end of each search."""
        print(f"{report.text}: {report.outcome} ({report.reason})")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("goal", help="what to go to, in words")
    parser.add_argument("--world", default="0", help="as for `vizbot dry-run`")
    parser.add_argument("--steps", type=int, default=1000, help="at most")
    arguments = parser.parse_args()

    config = Config()
    encoder = open_encoder(config.clip, config.device, config.half)
    with Rig(config, "sim", "sim", arguments.world, first_goal=arguments.goal) as rig:
        pipeline = Pipeline(rig.devices, encoder, config, [Narrator()])
        drive_to_all(pipeline, rig.devices, [pipeline.goal(arguments.goal)], arguments.steps)


if __name__ == "__main__":
    main()
