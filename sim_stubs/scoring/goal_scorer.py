"""Scores a rehearsal by what is true in its simulated world."""

from __future__ import annotations

from dataclasses import dataclass, field

from sim_stubs.scoring.success import Verdict, judge
from sim_stubs.world.world import World
from vizbot.core.observer import GoalReport, Outcome, Step


@dataclass
class GoalScorer:
    """An observer that scores each goal where the robot stopped, from the world's truth.

    Attributes:
        world: The simulated world, which the robot never sees whole.
        verdicts: One for each goal so far.
    """

    world: World
    verdicts: list[Verdict] = field(default_factory=list)

    def on_step(self, step: Step) -> None:
        """Nothing is scored under way."""

    def on_goal(self, report: GoalReport) -> None:
        """Score the place where the robot stands now."""
        stopped = report.outcome is Outcome.ARRIVED
        self.verdicts.append(judge(self.world, report.text, stopped=stopped))
