from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from vizbot.core.errors import DeviceError
from vizbot.core.observer import GoalReport, Outcome
from vizbot.core.types import STOP
from vizbot.mission import advise, drive_to_all, watch
from vizbot.objectnav.tasks import Task


@dataclass
class ScriptedPipeline:
    """Ends the search for each goal after as many ticks as `script` says; writes a diary."""

    script: dict[str, int]
    frames: int = 1000
    diary: list[str] = field(default_factory=list)
    steps: int = 0

    def tick(self, goal):
        if self.steps == self.frames:
            return None
        self.steps += 1
        if goal is Task.MAP:
            return SimpleNamespace(ended=None, question=None)
        self.script[goal.text] -= 1
        if self.script[goal.text] < 0:
            raise DeviceError("the camera is gone")
        arrived = self.script[goal.text] == 0
        return SimpleNamespace(ended=(Outcome.ARRIVED, "near") if arrived else None, question=None)

    def finish(self):
        self.diary.append("finish")

    def report(self, goal, outcome, reason):
        self.diary.append(f"report {goal.text}")
        return GoalReport(goal.text, outcome, reason, ())

    def look_up(self, goal):
        self.diary.append(f"look up {goal.text}")
        return GoalReport(goal.text, Outcome.LOCATED, "", ())


def devices_for(diary):
    def drive(twist):
        assert twist == STOP
        diary.append("stop")

    clock = SimpleNamespace(sleep=lambda seconds: diary.append("settle"))
    return SimpleNamespace(base=SimpleNamespace(drive=drive), clock=clock)


def goals(*texts):
    return [SimpleNamespace(text=text, embedding=np.zeros(1), threshold=0.3) for text in texts]


def test_goals_are_visited_in_order_and_the_base_rests_before_each_report():
    pipeline = ScriptedPipeline({"chair": 3, "sofa": 2})
    reports = drive_to_all(pipeline, devices_for(pipeline.diary), goals("chair", "sofa"), 10)
    assert [(report.text, report.outcome) for report in reports] == [
        ("chair", Outcome.ARRIVED),
        ("sofa", Outcome.ARRIVED),
    ]
    one = ["stop", "settle", "report {}"]
    assert pipeline.diary == [s.format(text) for text in ("chair", "sofa") for s in one]


def test_a_goal_that_is_given_up_does_not_cost_the_next_its_turn():
    pipeline = ScriptedPipeline({"chair": 99, "sofa": 2})
    chair, sofa = drive_to_all(pipeline, devices_for([]), goals("chair", "sofa"), 10)
    assert chair.outcome is Outcome.GAVE_UP and "10 steps" in chair.reason
    assert sofa.outcome is Outcome.ARRIVED


def test_the_base_is_stopped_before_an_error_is_raised():
    pipeline = ScriptedPipeline({"chair": 0})
    with pytest.raises(DeviceError):
        drive_to_all(pipeline, devices_for(pipeline.diary), goals("chair"), 10)
    assert pipeline.diary == ["stop"]


def test_a_recording_is_watched_to_its_end_before_it_is_asked():
    pipeline = ScriptedPipeline({}, frames=7)
    reports = watch(pipeline, goals("chair"))
    assert pipeline.steps == 7
    assert pipeline.diary == ["finish", "look up chair"]
    assert reports[0].outcome is Outcome.LOCATED


def test_a_live_camera_without_a_base_gets_commands_for_each_goal_and_is_then_asked():
    pipeline = ScriptedPipeline({"chair": 3, "sofa": 1000})
    reports = advise(pipeline, goals("chair", "sofa"), 10)
    assert pipeline.steps == 3 + 5
    assert pipeline.diary == ["finish", "look up chair", "look up sofa"]
    assert [report.outcome for report in reports] == [Outcome.LOCATED] * 2
